"""bus.log: every frame of a run as ``candump -L`` writes it, with its direction."""

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
