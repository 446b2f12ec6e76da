"""bus.log: every frame of a run as ``candump -L`` writes it, with its direction."""

import heapq
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from conformance.bus.link import Captured, Direction


class BusLog:
    """Writes frames as they come.

    python-can's writer is not used because it loses the DLC of remote frames.
    """

    def __init__(self, path: Path, channel: str) -> None:
        """``channel`` is the name that stands in each line."""
        # A bare number is no name of an interface, and a space would end it.
        self._channel = f"can{channel}" if channel.isdigit() else "_".join(channel.split())
        self._file = path.open("w", encoding="utf-8")

    def write(self, captured: Captured) -> None:
        """Append one frame."""
        mark = "R" if captured.direction is Direction.RECEIVED else "T"
        self._file.write(f"({captured.timestamp:f}) {self._channel} {captured.frame} {mark}\n")

    def close(self) -> None:
        """Finish the file."""
        self._file.close()


def merge_logs(parts: Sequence[Path], whole: Path) -> None:
    """Make one log of several, in the order of time, and remove them."""
    with ExitStack() as stack:
        files = [stack.enter_context(part.open(encoding="utf-8")) for part in parts]
        if files:
            # A line begins with its time, which has as many digits in each.
            merged = stack.enter_context(whole.open("w", encoding="utf-8"))
            merged.writelines(heapq.merge(*files, key=lambda line: line.partition(" ")[0]))
    for part in parts:
        part.unlink()
