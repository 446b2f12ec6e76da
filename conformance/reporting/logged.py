"""The frames of bus.log, read again case by case; it may have been packed by gzip since."""

import gzip
import heapq
import math
import zlib
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import lru_cache
from itertools import islice, pairwise
from pathlib import Path
from typing import NamedTuple, overload

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
        return _seconds(self.stamp)

    @property
    def data(self) -> bytes | None:
        """The bytes of a classic data frame; None for any other."""
        text = self.frame.partition("#")[2]
        try:
            return bytes.fromhex(text)
        except ValueError:
            return None


class CaseLines(Sequence[Logged]):
    """The lines of a case, each made when it is asked for: of most nobody asks for all."""

    __slots__ = ("_fields", "_numbers")

    def __init__(self, fields: Sequence[Sequence[str]], numbers: Sequence[int]) -> None:
        """Take the four fields of each line, and its number in the log."""
        self._fields = fields
        self._numbers = numbers

    def __len__(self) -> int:
        return len(self._fields)

    @overload
    def __getitem__(self, position: int) -> Logged: ...
    @overload
    def __getitem__(self, position: slice) -> "CaseLines": ...
    def __getitem__(self, position: int | slice) -> "Logged | CaseLines":
        if isinstance(position, slice):
            return CaseLines(self._fields[position], self._numbers[position])
        return _logged(self._numbers[position], self._fields[position])

    def __iter__(self) -> Iterator[Logged]:
        return map(_logged, self._numbers, self._fields)

    @property
    def frames(self) -> list[str]:
        """The frames as candump writes them."""
        return [fields[2] for fields in self._fields]

    @property
    def sent(self) -> bytes:
        """1 for each frame that we sent, else 0."""
        return bytes([fields[3] == SENT for fields in self._fields])

    def time(self, position: int) -> float:
        """Return the time of a line, in seconds."""
        return _seconds(self._fields[position][0])


def log_in(folder: Path, name: str) -> Path:
    """Return where a log of a run lies, as it was written or packed; it need not be there."""
    path = folder / name
    packed = folder / (name + PACKED)
    return packed if packed.is_file() and not path.is_file() else path


def log_lines(path: Path) -> Iterator[Logged]:
    """Yield the lines of a log, as far as they go and were written to their end; raises OSError."""
    for number, line in enumerate(_texts(path), start=1):
        fields = line.split()
        if len(fields) == FIELDS:
            yield _logged(number, fields)


def _texts(path: Path) -> Iterator[str]:
    with ExitStack() as stack:
        opened = gzip.open if path.suffix == PACKED else open
        file = stack.enter_context(opened(path, "rt", encoding="utf-8", errors="replace"))
        stack.enter_context(suppress(EOFError, zlib.error, gzip.BadGzipFile))  # it was cut off
        yield from file


def _logged(number: int, fields: Sequence[str]) -> Logged:
    stamp, bus, frame, direction = fields
    return Logged(stamp, bus, frame, direction == SENT, number, _identifier_of(frame))


def _seconds(stamp: str) -> float:
    return float(stamp[1:-1])


def _identifier_of(frame: str) -> int:
    return _identifier(frame.partition("#")[0])


@lru_cache(KNOWN_IDS)
def _identifier(digits: str) -> int:
    if not digits:
        return NO_FRAME
    return int(digits, 16) | EXTENDED * (len(digits) > SHORT_DIGITS)


# The first and the last line of a case, and its number.
Span = tuple[int, int, int]


def frames_by_case(
    folder: Path,
    log: str,
    places: Sequence[Place | None],
    node_ids: Sequence[int],
    channels: Mapping[int, ChannelIds] | None = None,
) -> Iterator[tuple[int, CaseLines]]:
    """Yield the number of each case that has a place in this log, and its lines; raises OSError.

    Those of devices that are tested side by side overlap. Where the ``channels`` of the devices are
    given, by node-ID, a case is not handed what went over those of others; nor is it what went over
    another bus than its first line. In a self-test each worker has a bus of its own.
    """
    spans = sorted(
        (place.first, place.last, number)
        for number, place in enumerate(places)
        if place is not None and place.log == log and place.last >= place.first
    )
    owners = _Owners(channels or {}, node_ids)
    in_turn = all(last < first for (_, last, _), (first, _, _) in pairwise(spans))
    cases = _in_turn if in_turn else _side_by_side
    yield from cases(_texts(log_in(folder, log)), spans, owners, node_ids)


class _Owners:
    """Whose frames are whose."""

    def __init__(self, channels: Mapping[int, ChannelIds], node_ids: Sequence[int]) -> None:
        self._nodes = set(node_ids)
        self._owners: defaultdict[int, set[int]] = defaultdict(set)
        for node_id, ids in channels.items():
            for identifier in (ids.request.identifier, ids.response.identifier):
                self._owners[identifier].add(node_id)

    def of(self, digits: str) -> set[int]:
        """Return the nodes that are handed frames with an identifier: all, where it is nobody's."""
        return self._owners.get(_identifier(digits), self._nodes)


def _in_turn(
    texts: Iterator[str], spans: Sequence[Span], owners: _Owners, node_ids: Sequence[int]
) -> Iterator[tuple[int, CaseLines]]:
    """Yield cases that follow one another."""
    read = 0
    for first, last, number in spans:
        lines = [text.split() for text in islice(texts, first - 1 - read, last - read)]
        read = last
        if not lines:
            return
        whole = [fields for fields in lines if len(fields) == FIELDS]
        buses = {fields[1] for fields in whole}
        heads = {fields[2].partition("#")[0] for fields in whole}
        own = {head for head in heads if node_ids[number] in owners.of(head)}
        if len(whole) == len(lines) and len(buses) == 1 and own == heads:
            yield number, CaseLines(lines, range(first, first + len(lines)))
            continue
        kept = _Kept([], [])
        for line, fields in enumerate(lines, first):
            belongs = len(fields) == FIELDS and fields[1] == whole[0][1]
            if belongs and fields[2].partition("#")[0] in own:
                kept.fields.append(fields)
                kept.numbers.append(line)
        yield number, CaseLines(kept.fields, kept.numbers)


def _side_by_side(
    texts: Iterator[str], spans: Sequence[Span], owners: _Owners, node_ids: Sequence[int]
) -> Iterator[tuple[int, CaseLines]]:
    """Yield cases that overlap, in the order in which they end."""
    waiting = list(reversed(spans))
    buses: dict[int, str] = {}
    open_cases: defaultdict[tuple[int, str], dict[int, _Kept]] = defaultdict(dict)

    @lru_cache(KNOWN_IDS)
    def takers(digits: str, bus: str) -> list[dict[int, _Kept]]:
        """Return where the open cases stand that get such frames."""
        return [open_cases[node_id, bus] for node_id in owners.of(digits)]

    def ended(number: int) -> tuple[int, CaseLines]:
        kept = open_cases[node_ids[number], buses[number]].pop(number)
        return number, CaseLines(kept.fields, kept.numbers)

    ends: list[tuple[int, int]] = []
    next_begin, next_end = waiting[-1][0] if waiting else NEVER, NEVER
    for line, text in enumerate(texts, start=1):
        fields = text.split()
        if len(fields) != FIELDS:
            continue
        while line > next_end:
            _, number = heapq.heappop(ends)
            next_end = ends[0][0] if ends else NEVER
            yield ended(number)
        while line >= next_begin:
            _, last, number = waiting.pop()
            heapq.heappush(ends, (last, number))
            buses[number] = fields[1]
            open_cases[node_ids[number], fields[1]][number] = _Kept([], [])
            next_begin, next_end = waiting[-1][0] if waiting else NEVER, ends[0][0]
        for cases in takers(fields[2].partition("#")[0], fields[1]):
            for kept in cases.values():
                kept.fields.append(fields)
                kept.numbers.append(line)
    for _, number in sorted(ends):
        yield ended(number)


class _Kept(NamedTuple):
    """The lines of a case that has not ended yet."""

    fields: list[list[str]]
    numbers: list[int]
