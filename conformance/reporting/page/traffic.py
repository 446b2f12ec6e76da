"""What bus.log holds of each case: its frames in words, what was written, how fast answers came."""

from bisect import insort
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

from conformance.device.safety import WRITING
from conformance.reporting.logged import Logged
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.describe import Decoder, describe
from conformance.sdo.frames import DownloadInitiate, Request
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.nmt import NMT_ID, describe_nmt

# A case may have thousands of frames; the page shows the first and the last.
FIRST_SHOWN, LAST_SHOWN = 12, 4
SLOWEST = 5
PERCENTILES = (50, 95, 100)


@dataclass(slots=True)
class Written:
    """The downloads of one object: how many were begun, when, and the short values they had."""

    begun: int = 0
    first: float = 0.0
    last: float = 0.0
    values: Counter[str] = field(default_factory=Counter)


@dataclass(slots=True)
class Times:
    """How long answers to one kind of request took, in seconds; the slowest with their cases."""

    all: list[float] = field(default_factory=list)
    slowest: list[tuple[float, int]] = field(default_factory=list)

    def add(self, seconds: float, case: int) -> None:
        """Take an answer that came in the case of this number."""
        self.all.append(seconds)
        if len(self.slowest) < SLOWEST or seconds > self.slowest[0][0]:
            insort(self.slowest, (seconds, case))
            del self.slowest[:-SLOWEST]

    def percentiles(self) -> list[float]:
        """Return the times within which each share of the answers came, in milliseconds."""
        ordered = sorted(self.all)
        return [1000 * ordered[(len(ordered) - 1) * share // 100] for share in PERCENTILES]


@dataclass(slots=True)
class Traffic:
    """The frames of a run: those that are shown, as lines of text by the number of their case.

    What was ``written`` is kept by node-ID and object, NMT commands by their words, and the lines
    that are ``commanding``; response ``times`` by kind of request.
    """

    shown: dict[int, list[str]] = field(default_factory=dict)
    written: dict[tuple[int, Multiplexer], Written] = field(default_factory=dict)
    commands: Counter[str] = field(default_factory=Counter)
    times: defaultdict[str, Times] = field(default_factory=lambda: defaultdict(Times))
    requests: int = 0
    responses: int = 0
    commanding: set[int] = field(default_factory=set)

    def take(self, case: int, node_id: int, ids: ChannelIds, lines: Sequence[Logged]) -> None:
        """Take the frames of a case of this number, on this channel of this node.

        What the bus carried between the cases counts with those that follow.
        """
        _Case(self, case, node_id, ids).take(lines)


class _Case:
    """Adds the frames of one case to the traffic of its run."""

    def __init__(self, traffic: Traffic, number: int, node_id: int, ids: ChannelIds) -> None:
        self._traffic = traffic
        self._number = number
        self._node_id = node_id
        self._ids = ids
        self._own = self._ids.request.can_id, self._ids.response.can_id
        self._decoder = Decoder()
        self._asked: tuple[float, Request] | None = None

    def take(self, lines: Sequence[Logged]) -> None:
        """Follow the frames, and keep those that are shown."""
        shown = []
        for position, logged in enumerate(lines):
            is_shown = position < FIRST_SHOWN or position >= len(lines) - LAST_SHOWN
            words = self._follow(logged, is_shown)
            if is_shown:
                elapsed = (logged.time - lines[0].time) * 1000
                arrow = ">" if logged.sent else "<"
                shown.append(f"{elapsed:.1f} {arrow} {logged.frame} {words}".rstrip())
            elif position == FIRST_SHOWN:
                left_out = len(lines) - FIRST_SHOWN - LAST_SHOWN
                shown.append(f"… {left_out} frames, which are in bus.log")
        self._traffic.shown[self._number] = shown

    def _follow(self, logged: Logged, is_shown: bool) -> str:
        """Count a frame; return it in words where they are wanted."""
        can_id, data = logged.can_id, logged.data
        if data is None or len(data) != FRAME_LENGTH or can_id not in self._own:
            return self._beside(logged, can_id, data)
        if can_id == self._ids.request.can_id:
            request = self._decoder.request(data)
            if logged.sent:
                self._traffic.requests += 1
                self._asked = logged.time, request
                self._note(request, logged.time)
            return describe(request) if is_shown else ""
        self._traffic.responses += 1
        response = self._decoder.response(data)
        if self._asked is not None:
            time, request = self._asked
            self._asked = None
            self._traffic.times[_in_words(type(request).__name__)].add(
                logged.time - time, self._number
            )
        return describe(response) if is_shown else ""

    def _beside(self, logged: Logged, can_id: int, data: bytes | None) -> str:
        """Note an NMT command; return what is not of the device's SDO channel in words."""
        if data is None or can_id < 0:
            return ""
        words = describe_nmt(CanFrame(can_id, data)) or ""
        if logged.sent and can_id == NMT_ID and logged.number not in self._traffic.commanding:
            self._traffic.commanding.add(logged.number)  # cases of several devices see it
            self._traffic.commands[words] += 1
        return words

    def _note(self, request: Request, time: float) -> None:
        """Keep what would be written."""
        if not isinstance(request, WRITING):
            return
        written = self._traffic.written.setdefault(
            (self._node_id, request.mux), Written(first=time)
        )
        written.begun += 1
        written.last = time
        if isinstance(request, DownloadInitiate) and request.expedited:
            written.values[request.data.hex(" ").upper()] += 1
        elif request.size is not None:
            written.values[f"{request.size} bytes"] += 1


@cache
def _in_words(name: str) -> str:
    """Return the name of a kind of request in words."""
    return "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in name).strip()
