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
from conformance.sdo.frames import BlockDownloadInitiate, DownloadInitiate, Request, Response
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
    """The frames of a run: as the page shows them, lines of text, by the number of their case.

    Of the frames of ``not_in_words`` cases it is only said where they are. What was ``written`` is
    kept by node-ID and object, NMT commands by their words, and the lines that are ``commanding``;
    response ``times`` by kind of request.
    """

    shown: dict[int, str] = field(default_factory=dict)
    not_in_words: int = 0
    written: dict[tuple[int, Multiplexer], Written] = field(default_factory=dict)
    commands: Counter[str] = field(default_factory=Counter)
    times: defaultdict[str, Times] = field(default_factory=lambda: defaultdict(Times))
    requests: int = 0
    responses: int = 0
    commanding: set[int] = field(default_factory=set)

    def take(
        self, case: int, node_id: int, ids: ChannelIds, lines: Sequence[Logged], *, in_words: bool
    ) -> None:
        """Take the frames of a case of this number, on this channel of this node.

        They are shown ``in_words``, or it is only said where they are. What the bus carried between
        the cases counts with those that follow.
        """
        messages = _Case(self, case, node_id, ids).follow(lines)
        self.shown[case] = _shown(lines, messages) if in_words else _where(lines)
        self.not_in_words += not in_words


def _shown(lines: Sequence[Logged], messages: Sequence[Request | Response | str]) -> str:
    """Write the first and the last frames of a case, at milliseconds from its first."""
    begin = lines[0].time if lines else 0.0

    def written(first: int, behind_last: int) -> list[str]:
        shown = zip(lines[first:behind_last], messages[first:behind_last], strict=True)
        return [_line(begin, logged, message) for logged, message in shown]

    last = len(lines) - LAST_SHOWN
    if last <= FIRST_SHOWN:
        return "\n".join(written(0, len(lines)))
    left_out = f"… {last - FIRST_SHOWN} frames, which are in bus.log"
    return "\n".join([*written(0, FIRST_SHOWN), left_out, *written(last, len(lines))])


def _line(begin: float, logged: Logged, message: Request | Response | str) -> str:
    words = message if isinstance(message, str) else describe(message)
    arrow = ">" if logged.sent else "<"
    return f"{(logged.time - begin) * 1000:.1f} {arrow} {logged.frame} {words}".rstrip()


def _where(lines: Sequence[Logged]) -> str:
    """Say where the frames of a case are."""
    if not lines:
        return ""
    numbers = f"lines {lines[0].number} to {lines[-1].number}"
    return f"… {len(lines)} frames, which are in bus.log, {numbers}"


class _Case:
    """Adds the frames of one case to the traffic of its run."""

    def __init__(self, traffic: Traffic, number: int, node_id: int, ids: ChannelIds) -> None:
        self._traffic = traffic
        self._number = number
        self._node_id = node_id
        self._request_id = ids.request.can_id
        self._own = ids.request.can_id, ids.response.can_id
        self._decoder = Decoder()

    def follow(self, lines: Sequence[Logged]) -> list[Request | Response | str]:
        """Count the frames; return each as a message, or in words where it is none of SDO."""
        traffic, decoder = self._traffic, self._decoder
        messages: list[Request | Response | str] = []
        asked: tuple[Logged, Request] | None = None
        for logged in lines:
            can_id, data = logged.can_id, logged.data
            if data is None or len(data) != FRAME_LENGTH or can_id not in self._own:
                messages.append(self._beside(logged, data))
            elif can_id == self._request_id:
                request = decoder.request(data)
                messages.append(request)
                if logged.sent:
                    traffic.requests += 1
                    asked = logged, request
                    if isinstance(request, WRITING):
                        self._note(request, logged.time)
            else:
                messages.append(decoder.response(data))
                traffic.responses += 1
                if asked is not None:
                    before, request = asked
                    asked = None
                    times = traffic.times[_in_words(type(request).__name__)]
                    times.add(logged.time - before.time, self._number)
        return messages

    def _beside(self, logged: Logged, data: bytes | None) -> str:
        """Note an NMT command; return what is not of the device's SDO channel in words."""
        if data is None or logged.can_id < 0:
            return ""
        words = describe_nmt(CanFrame(logged.can_id, data)) or ""
        is_command = logged.sent and logged.can_id == NMT_ID
        if is_command and logged.number not in self._traffic.commanding:
            self._traffic.commanding.add(logged.number)  # cases of several devices see it
            self._traffic.commands[words] += 1
        return words

    def _note(self, request: DownloadInitiate | BlockDownloadInitiate, time: float) -> None:
        """Keep what would be written."""
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
