"""bus.log: the frames of a run as ``candump -L`` writes them, with their direction.

Which of its lines are those of a case stands in results.jsonl. A comment line would be skipped by
can-utils, but python-can's reader takes every line for a frame.
"""

import heapq
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from conformance.bus.link import Captured, Direction
from conformance.reporting.appending import GrowingFile

# Lines that wait for the end of the case, and bytes that wait for room on a full disk.
MOST_LINES = 1_000
MOST_WAITING = 16 * 2**20
# A frame that is sent may be answered by a sub-block of 127 segments. What comes beyond that is
# a flood; what it consists of has been shown by then.
ANSWERS = 128
FLOOD = 10_000


class Place(NamedTuple):
    """Where frames are in a log: the numbers of the first and the last line, from 1.

    Without a frame the last is before the first. ``left_out`` are frames of a flood that are not
    written; ``between`` are lines between the first and the last that other workers have written.
    """

    log: str
    first: int
    last: int
    left_out: int = 0
    between: int = 0

    @property
    def lines(self) -> int:
        """The number of lines of the worker that ran the case."""
        return self.last + 1 - self.first - self.between


def in_a_log(channel: str) -> str:
    """Return the name of a channel as a line of a log can have it."""
    # A bare number is no name of an interface, and a space would end it.
    return f"can{channel}" if channel.isdigit() else "_".join(channel.split())


class BusLog:
    """Writes frames as they come; errors fail no case: at the end it says what it could not write.

    python-can's writer is not used because it loses the DLC of remote frames.
    """

    def __init__(self, path: Path, channel: str) -> None:
        """``channel`` is the name that stands in each line."""
        self._channel = in_a_log(channel)
        self._name = path.name
        self._file = GrowingFile(path, MOST_WAITING)
        self._waiting: list[str] = []
        self._excess = 0
        self._lines = 0
        self._since = (0, 0)
        self.left_out = 0

    def write(self, captured: Captured) -> None:
        """Append one frame, unless it belongs to a flood that has been shown."""
        if captured.direction is Direction.RECEIVED:
            mark = "R"
            if self._excess >= FLOOD:
                self.left_out += 1
                return
            self._excess += 1
        else:
            mark = "T"
            self._excess = max(0, self._excess - ANSWERS)
        self._lines += 1
        self._waiting.append(f"({captured.timestamp:f}) {self._channel} {captured.frame} {mark}\n")
        if len(self._waiting) >= MOST_LINES:
            self.flush()

    def begin(self) -> None:
        """Begin a case: ``place`` counts from here on."""
        self._since = (self._lines, self.left_out)

    def place(self) -> Place:
        """Return where the frames of the case are, up to now."""
        lines, left_out = self._since
        return Place(self._name, lines + 1, self._lines, self.left_out - left_out)

    def flush(self) -> None:
        """Hand all lines to the operating system: they stay whatever befalls this process."""
        if self._waiting:
            waiting, self._waiting = self._waiting, []
            self._file.append("".join(waiting).encode())

    def close(self) -> str:
        """Finish the file; say what could not be written, empty when all is there."""
        self.flush()
        return self._file.close()


Wanted = Mapping[str, Iterable[int]]


def merge_logs(
    parts: Sequence[Path], whole: Path, wanted: Wanted | None = None
) -> dict[tuple[str, int], int]:
    """Make one log of several, in the order of time, and remove them.

    ``wanted`` are numbers of lines, by the names of the parts; returns where those are now. Raises
    OSError, and leaves the parts where they are.
    """
    places: dict[tuple[str, int], int] = {}
    with ExitStack() as stack:
        lines = [_numbered(part, stack, (wanted or {}).get(part.name, ())) for part in parts]
        if lines:
            merged = stack.enter_context(whole.open("w", encoding="utf-8"))
            # A line begins with its time, which has as many digits in each. Those of one part stay
            # in their order, also where they have the same time.
            for place, (line, number, name) in enumerate(heapq.merge(*lines), start=1):
                merged.write(line)
                if number:
                    places[name, number] = place
    for part in parts:
        part.unlink()
    return places


def _numbered(
    part: Path, stack: ExitStack, wanted: Iterable[int]
) -> Iterator[tuple[str, int, str]]:
    """Yield the lines of a log, with their numbers where these are wanted, and with its name."""
    kept, name = frozenset(wanted), part.name
    file = stack.enter_context(part.open(encoding="utf-8"))
    return (
        (line, number if number in kept else 0, name) for number, line in enumerate(file, start=1)
    )
