"""The frames of bus.log, read again case by case; it may have been packed by gzip since."""

import gzip
import heapq
import math
import zlib
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from conformance.reporting.bus_log import Place
from conformance.sdo.cob_id import EXTENDED, SHORT_DIGITS, ChannelIds

SENT = "T"
FIELDS = 4
# A log has few CAN-IDs, but those of random frames.
KNOWN_IDS = 1024
NEVER = math.inf
PACKED = ".gz"
# What stands for the identifier of a line that is no frame.
NO_FRAME = -1


class Logged(NamedTuple):
    """A line of bus.log: its time and frame as candump writes them, and whether we sent it.

    ``bus`` is the name of the interface, ``number`` that of the line. ``identifier`` is the CAN-ID,
    with bit 29 where it has 29 bits, and NO_FRAME for what is none.
    """

    stamp: str
    bus: str
    frame: str
    sent: bool
    number: int
    identifier: int

    @property
    def time(self) -> float:
        """The time in seconds: of most lines nobody asks for it, and to read it takes long."""
        return float(self.stamp[1:-1])

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


def log_lines(path: Path) -> Iterator[Logged]:
    """Yield the lines of a log, as far as they go and were written to their end; raises OSError."""
    with ExitStack() as stack:
        opened = gzip.open if path.suffix == PACKED else open
        file = stack.enter_context(opened(path, "rt", encoding="utf-8", errors="replace"))
        stack.enter_context(suppress(EOFError, zlib.error, gzip.BadGzipFile))  # it was cut off
        for number, line in enumerate(file, start=1):
            fields = line.split()
            if len(fields) == FIELDS:
                stamp, bus, frame, direction = fields
                identifier = _identifier(frame.partition("#")[0])
                yield Logged(stamp, bus, frame, direction == SENT, number, identifier)


@lru_cache(KNOWN_IDS)
def _identifier(digits: str) -> int:
    if not digits:
        return NO_FRAME
    return int(digits, 16) | EXTENDED * (len(digits) > SHORT_DIGITS)


def frames_by_case(
    folder: Path,
    log: str,
    places: Sequence[Place | None],
    node_ids: Sequence[int],
    channels: Mapping[int, ChannelIds] | None = None,
) -> Iterator[tuple[int, list[Logged]]]:
    """Yield the number of each case that has a place in this log, and its lines; raises OSError.

    Those of devices that are tested side by side overlap. Where the ``channels`` of the devices are
    given, by node-ID, a case is not handed what went over those of others; nor is it what went over
    another bus than its first line. In a self-test each worker has a bus of its own.
    """
    waiting = sorted(
        (
            (place.first, place.last, number)
            for number, place in enumerate(places)
            if place is not None and place.log == log and place.last >= place.first
        ),
        reverse=True,
    )
    owners, nodes = _owners(channels or {}), set(node_ids)
    buses: dict[int, str] = {}
    open_cases: defaultdict[tuple[int, str], dict[int, list[Logged]]] = defaultdict(dict)

    @lru_cache(KNOWN_IDS)
    def takers(identifier: int, bus: str) -> list[dict[int, list[Logged]]]:
        """Return where the open cases stand that get such frames."""
        return [open_cases[node_id, bus] for node_id in owners.get(identifier, nodes)]

    ends: list[tuple[int, int]] = []
    next_begin, next_end = waiting[-1][0] if waiting else NEVER, NEVER
    for logged in log_lines(log_in(folder, log)):
        while logged.number > next_end:
            _, number = heapq.heappop(ends)
            next_end = ends[0][0] if ends else NEVER
            yield number, open_cases[node_ids[number], buses[number]].pop(number)
        while logged.number >= next_begin:
            _, last, number = waiting.pop()
            heapq.heappush(ends, (last, number))
            buses[number] = logged.bus
            open_cases[node_ids[number], logged.bus][number] = []
            next_begin, next_end = waiting[-1][0] if waiting else NEVER, ends[0][0]
        for cases in takers(logged.identifier, logged.bus):
            for lines in cases.values():
                lines.append(logged)
    for _, number in sorted(ends):
        yield number, open_cases[node_ids[number], buses[number]].pop(number)


def _owners(channels: Mapping[int, ChannelIds]) -> dict[int, list[int]]:
    """Return for each identifier of these channels the nodes whose it is."""
    found: defaultdict[int, list[int]] = defaultdict(list)
    for node_id, ids in channels.items():
        for identifier in {ids.request.identifier, ids.response.identifier}:
            found[identifier].append(node_id)
    return dict(found)
