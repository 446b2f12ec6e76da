"""The traffic of each case in bus.log: its frames in words, writes, and times of answers."""

from bisect import insort
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Self

from conformance.device.safety import WRITING
from conformance.reporting.logged import CaseLines, Logged
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import LARGEST_STANDARD_ID, ChannelIds, CobId
from conformance.sdo.describe import describe
from conformance.sdo.frames import BlockDownloadInitiate, DownloadInitiate, Request, Response
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.line import Line
from conformance.sdo.nmt import ERROR_CONTROL_BASE, NMT_ID, describe_nmt

# A case may have thousands of frames; the page shows the first and the last.
FIRST_SHOWN, LAST_SHOWN = 12, 4
SLOWEST = 5
PERCENTILES = (50, 95, 100)
# So many conversations are known at the most: a run has half as many with one device.
MOST_KNOWN = 10_000


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


@dataclass(frozen=True, slots=True)
class Conversation:
    """What the frames of a case say, whenever and to whichever device; numbers count from 0.

    Each frame as a message, or in words where it is none of SDO; the numbers of requests with those
    of their answers, and their kind; ``writes`` and NMT ``commands`` with their numbers.
    """

    messages: list[Request | Response | str] = field(default_factory=list)
    answers: list[tuple[int, int, str]] = field(default_factory=list)
    writes: list[tuple[int, DownloadInitiate | BlockDownloadInitiate]] = field(default_factory=list)
    commands: list[tuple[int, str]] = field(default_factory=list)
    requests: int = 0
    responses: int = 0

    @classmethod
    def of(cls, lines: Sequence[Logged], ids: ChannelIds) -> Self:
        """Read the frames of a case, on this channel."""
        request_id = ids.request.identifier
        own = request_id, ids.response.identifier
        line = Line()
        found, requests, responses = cls(), 0, 0
        asked: tuple[int, Request] | None = None
        for number, logged in enumerate(lines):
            identifier, data = logged.identifier, logged.data
            if data is None or len(data) != FRAME_LENGTH or identifier not in own:
                found.messages.append(found.beside(number, logged, data))
            elif identifier == request_id:
                request = line.request(data)
                found.messages.append(request)
                if logged.sent:
                    requests += 1
                    asked = number, request
                    if isinstance(request, WRITING):
                        found.writes.append((number, request))
            else:
                found.messages.append(line.response(data))
                responses += 1
                if asked is not None:
                    before, request = asked
                    asked = None
                    found.answers.append((before, number, _in_words(type(request).__name__)))
        return replace(found, requests=requests, responses=responses)

    def beside(self, number: int, logged: Logged, data: bytes | None) -> str:
        """Take an NMT command; return what is not of the device's SDO channel in words."""
        if data is None or not 0 <= logged.identifier <= LARGEST_STANDARD_ID:
            return ""
        words = describe_nmt(CanFrame(logged.identifier, data)) or ""
        if logged.sent and logged.identifier == NMT_ID:
            self.commands.append((number, words))
        return words


@dataclass(slots=True)
class Traffic:
    """The frames of a run: as the page shows them, lines of text, by the number of their case.

    Those of the cases ``not_in_words`` it does not show. What was ``written`` is kept by node-ID
    and object, NMT commands by their words, and the lines of this log that are ``commanding``;
    response ``times`` by kind of request.
    """

    shown: dict[int, str] = field(default_factory=dict)
    not_in_words: set[int] = field(default_factory=set)
    written: dict[tuple[int, Multiplexer], Written] = field(default_factory=dict)
    commands: Counter[str] = field(default_factory=Counter)
    times: defaultdict[str, Times] = field(default_factory=lambda: defaultdict(Times))
    requests: int = 0
    responses: int = 0
    commanding: set[int] = field(default_factory=set)
    _conversations: dict[tuple[bytes, str], Conversation] = field(default_factory=dict)

    def take(
        self, case: int, node_id: int, ids: ChannelIds, lines: CaseLines, *, in_words: bool
    ) -> None:
        """Take the frames of a case of this number, on this channel of this node.

        They are shown ``in_words``, or not at all. What the bus carried between the cases counts
        with those that follow.
        """
        if in_words:
            found = Conversation.of(lines, ids)
            self.shown[case] = _shown(lines, found.messages)
        else:
            found = self._known(lines, node_id, ids)
            self.not_in_words.add(case)
        self._count(found, case, node_id, lines)

    def _known(self, lines: CaseLines, node_id: int, ids: ChannelIds) -> Conversation:
        """Return what the frames of a case say: equal devices say the same in most cases."""
        form = _form(lines, node_id, ids)
        known = self._conversations.get(form)
        if known is None:
            known = Conversation.of(lines, ids)
            known.messages.clear()
            if len(self._conversations) < MOST_KNOWN:
                self._conversations[form] = known
        return known

    def _count(self, found: Conversation, case: int, node_id: int, lines: CaseLines) -> None:
        """Count what a case of this number has said."""
        self.requests += found.requests
        self.responses += found.responses
        for asked, answered, kind in found.answers:
            seconds = lines.time(answered) - lines.time(asked)
            self.times[kind].add(seconds, case)
        for number, request in found.writes:
            self._note(node_id, request, lines.time(number))
        for number, words in found.commands:
            if lines[number].number not in self.commanding:
                self.commanding.add(lines[number].number)  # cases of several devices see it
                self.commands[words] += 1

    def _note(
        self, node_id: int, request: DownloadInitiate | BlockDownloadInitiate, time: float
    ) -> None:
        """Keep what would be written."""
        written = self.written.setdefault((node_id, request.mux), Written(first=time))
        written.begun += 1
        written.last = time
        if isinstance(request, DownloadInitiate) and request.expedited:
            written.values[request.data.hex(" ").upper()] += 1
        elif request.size is not None:
            written.values[f"{request.size} bytes"] += 1


def _form(lines: CaseLines, node_id: int, ids: ChannelIds) -> tuple[bytes, str]:
    """Return who sent the frames of a case, and all of them in one text, whichever node it was."""
    frames = " ".join(lines.frames)
    own = ids.request, ids.response, CobId(ERROR_CONTROL_BASE + node_id)
    for place, identifier in enumerate(own):
        frames = frames.replace(str(identifier.frame(b"")), f"{place}#")
    return lines.sent, frames


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


@cache
def _in_words(name: str) -> str:
    """Return the name of a kind of request in words."""
    return "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in name).strip()
