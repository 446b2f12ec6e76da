"""The frames of bus.log, read again case by case; it may have been packed by gzip since."""

import gzip
import heapq
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from conformance.reporting.bus_log import Place

SENT = "T"
PACKED = ".gz"


class Logged(NamedTuple):
    """A line of bus.log: seconds, the frame as candump writes it, and whether we sent it.

    ``number`` is that of the line.
    """

    time: float
    frame: str
    sent: bool
    number: int

    @property
    def can_id(self) -> int:
        """The CAN-ID; -1 for what is no frame."""
        digits = self.frame.partition("#")[0]
        return int(digits, 16) if digits else -1

    @property
    def data(self) -> bytes | None:
        """The bytes of a classic data frame; None for any other."""
        text = self.frame.partition("#")[2]
        try:
            return bytes.fromhex(text)
        except ValueError:
            return None


def log_in(folder: Path, name: str) -> Path:
    """Return where a log of a run lies, as it was written or packed; it need not be there."""
    path = folder / name
    packed = folder / (name + PACKED)
    return packed if packed.is_file() and not path.is_file() else path


def log_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines of a log with their numbers, as far as they go; raises OSError."""
    if path.suffix != PACKED:
        with path.open(encoding="utf-8", errors="replace") as file:
            yield from enumerate(file, start=1)
        return
    with gzip.open(path, "rt", encoding="utf-8", errors="replace") as packed:
        try:
            yield from enumerate(packed, start=1)
        except (EOFError, zlib.error, gzip.BadGzipFile):
            return  # it was cut off


def frames_by_case(
    folder: Path, log: str, places: Sequence[Place | None]
) -> Iterator[tuple[int, list[Logged]]]:
    """Yield the number of each case that has a place in this log, and its lines; raises OSError.

    Those of devices that are tested side by side overlap.
    """
    waiting = sorted(
        (
            (place.first, place.last, number)
            for number, place in enumerate(places)
            if place is not None and place.log == log and place.last >= place.first
        ),
        reverse=True,
    )
    open_cases: list[tuple[int, int, list[Logged]]] = []
    for line_number, line in log_lines(log_in(folder, log)):
        while waiting and waiting[-1][0] <= line_number:
            _, last, number = waiting.pop()
            heapq.heappush(open_cases, (last, number, []))
        logged = logged_line(line_number, line)
        for _, _, lines in open_cases:
            if logged is not None:
                lines.append(logged)
        while open_cases and open_cases[0][0] <= line_number:
            _, number, lines = heapq.heappop(open_cases)
            yield number, lines
    while open_cases:  # the log was cut off
        _, number, lines = heapq.heappop(open_cases)
        yield number, lines


def logged_line(number: int, line: str) -> Logged | None:
    """Read a line of bus.log; None for one that was not written to its end."""
    match line.split():
        case [time, _, frame, direction]:
            return Logged(float(time.strip("()")), frame, direction == SENT, number)
        case _:
            return None
