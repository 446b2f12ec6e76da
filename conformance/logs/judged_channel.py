"""One SDO channel of a log, judged frame by frame."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from conformance.logs.behind import Behind
from conformance.logs.burst import Burst
from conformance.logs.emptied import Emptied
from conformance.logs.exchanges import ASKING, Exchanges, is_one_of
from conformance.logs.findings import Finding, Found, NotFollowed, Remark
from conformance.logs.patience import Patience
from conformance.logs.reading import Seen
from conformance.sdo.abort_codes import APPLICATION_STATE, AbortCode
from conformance.sdo.decoding import decode_request
from conformance.sdo.describe import describe
from conformance.sdo.frames import INITIATES, Abort, DownloadInitiate
from conformance.sdo.oracle import Awaited, Oracle
from conformance.sdo.oracle.fixed_knowledge import FixedKnowledge
from conformance.sdo.rules import ANSWERED, NO_REBOOT, UNSOLICITED, Violation
from conformance.sdo.seen import NoAnswer

# The shortest time-out of a server that is met in the field is 25 ms.
SERVER_TIMEOUT = 0.02
# A channel that is no longer followed is again once it was quiet for so long.
QUIET = 0.1
# The more requests a client sends ahead of the answers, the more ways there are in which a server
# may have gone on. These are the limits, on one channel and on all; only ways beyond the
# usual number count.
USUAL_EFFORT = 5
MOST_EFFORT = 4_000
MOST_EFFORT_OF_ALL = 20_000
# So many requests in a row may be answered yet.
MOST_OVERDUE = 50
PROGRAM_CONTROL = 0x1F51


@dataclass(slots=True)
class Effort:
    """The work of following all channels beyond the usual."""

    spent: int = 0


@dataclass(slots=True)
class Flood:
    """Responses behind each other that nothing asked for: the first is told at once."""

    latest: Seen
    violation: Violation
    more: int = 0


@dataclass(slots=True)
class JudgedChannel:
    """One default SDO channel: the oracle, what was seen last, and how much there was of it.

    ``asked`` is the request of an exchange that begins at rest; the oracle has not been told of it.
    ``effort`` is what following took beyond the usual; a channel that is ``out`` is not followed.
    ``not_judged`` are the numbers of the responses that were let pass: the state of the server was
    not known. ``absent``: the node is starting, or was not heard of yet, and need not answer.
    """

    node_id: int
    oracle: Oracle
    effort_of_all: Effort = field(default_factory=Effort)
    last: Seen | None = None
    requests: int = 0
    responses: int = 0
    asked: Seen | None = None
    effort: int = 0
    before: int = 0
    out: bool = False
    not_judged: list[int] = field(default_factory=list)
    absent: bool = True
    _patience: Patience = field(default_factory=Patience)
    _exchanges: Exchanges = field(default_factory=Exchanges)
    _overdue: dict[Violation, Seen] = field(default_factory=dict)
    _open: list[Seen] = field(default_factory=list)
    # What a node has not answered that was not heard of yet: it may not be there.
    _missing: list[Finding] = field(default_factory=list)
    _held: list[Finding] = field(default_factory=list)
    _flood: Flood | None = None
    # Whether the last frame was a request.
    _waits: bool = False
    _burst: Burst = field(default_factory=Burst)
    _behind: Behind = field(default_factory=Behind)
    _emptied: Emptied = field(default_factory=Emptied)

    @classmethod
    def of(
        cls, node_id: int, effort: Effort, patience: float | None, *, begins_idle: bool
    ) -> "JudgedChannel":
        """Return the channel of a node, at the beginning of a log."""
        oracle = Oracle(FixedKnowledge(), node_id)
        if not begins_idle:
            oracle.lose()
        return cls(node_id, oracle, effort, _patience=Patience(patience))

    @property
    def rests(self) -> bool:
        """Whether the server is idle for sure."""
        return self.oracle.idle and self.asked is None

    def request(self, seen: Seen) -> Iterator[Found]:
        """Take a request; yield the breaches before it."""
        yield from self._reported()
        last, self.last = self.last, seen
        self._waits = True
        self.requests += 1
        if not self._is_followed(seen, last):
            return
        if last is not None and self._is_overdue(seen.time, last):
            self._wait_on(last)
            if len(self._overdue) >= MOST_OVERDUE:
                yield from self._settled(last)
        self._tell()
        if last is not None and seen.time - last.time >= QUIET:
            self.oracle.rested()
        oracle = self.oracle
        if oracle.awaited is Awaited.NOTHING and not oracle.in_sub_block:
            oracle.settled()
        self._follow_open(seen)
        self._patience.asked(seen.frame.data, in_sub_block=oracle.in_sub_block)
        self._burst.sent(seen.frame.data, in_sub_block=oracle.in_sub_block)
        self._emptied.asked(seen.frame.data, in_sub_block=oracle.in_sub_block)
        if not oracle.in_sub_block:
            self._behind.asked(seen)
        if oracle.idle and is_one_of(ASKING, seen.frame):
            self.asked = seen
        else:
            oracle.request(seen.frame)
            yield from self._limited(seen)

    def response(self, seen: Seen) -> Iterator[Found]:
        """Take a response; yield its breaches, and those of the time before it."""
        last, self.last = self.last, seen
        self.responses += 1
        self._behind.answered(seen)
        yield from self.heard()
        self._waits = False
        if self._held:  # another answer: the one before was to what the log does not show
            self.not_judged += [finding.seen.number for finding in self._held]
            self._held.clear()
        if not self._is_followed(seen, last):
            self.not_judged.append(seen.number)
        else:
            emptied = self._emptied.answered(seen.frame.data)
            if emptied is not None:
                yield Remark(self.node_id, seen, emptied)
            if not self._exchanges.has(self.asked, seen):
                yield from self._judged(seen, last)
            yield from self._limited(seen)
        self.asked = None
        self._open.clear()
        self._patience.answered()

    def heard(self) -> Iterator[Found]:
        """Take that the node is there; yield the requests that it has not answered."""
        self.absent = False
        yield from self._all_missing()

    def booted(self, *, commanded: bool) -> Iterator[Found]:
        """Take a boot-up message, which a command to reset the node explains."""
        yield from self._reported()
        last = self.last
        self._tell()
        owed = self.oracle.awaited is Awaited.ANSWER
        explained = self.absent or commanded or _starts_a_program(last)
        if last is not None and owed and not explained:
            yield from self._settled(last, rebooted=True)
        crosses = last.frame.data if last is not None and self._waits else None
        self._missing.clear()
        self._begin_anew()
        self.oracle.reset(booted=True, on_its_way=crosses)
        self.absent = self._waits = False

    def told_to_reset(self, now: float) -> Iterator[Found]:
        """Take a command to reset the node; yield what it has not answered for long before."""
        yield from self.end(now)
        self._begin_anew()
        self.oracle.reset(booted=False)
        self.absent = True

    def interrupted(self) -> None:
        """Take that a command of network management may have changed where the server is."""
        if not self.rests:
            self.lost()

    def lost(self) -> None:
        """Take that it is not known where the server is."""
        self._tell()
        self.oracle.lose()
        self._begin_anew()

    def _begin_anew(self) -> None:
        self.asked = self.last = None
        self.out = self.oracle.given_up = False
        self.effort = 0
        self._overdue.clear()
        self._open.clear()
        self._burst.clear()
        self._behind.clear()
        self._emptied.clear()

    def end(self, now: float) -> Iterator[Found]:
        """Yield which answers have not come until now."""
        last = self.last
        behind = self._behind.at_the_end(now)
        if behind is not None and last is not None:
            yield Finding(self.node_id, last, behind)
        if last is not None and not self.out and self._is_overdue(now, last):
            yield from self._settled(last)
        yield from self._all_missing()
        if not self._behind.is_certain:
            for missing, seen in self._overdue.items():
                yield Finding(self.node_id, seen, missing)
        self._overdue.clear()
        yield from self._reported()

    def _is_overdue(self, now: float, last: Seen) -> bool:
        return now - last.time >= self._patience.seconds

    def _wait_on(self, last: Seen) -> None:
        """Wait on for answers that have not come for long."""
        self._tell()
        first, *others = self._open or [last]
        also = {_unanswered(seen): seen for seen in others}
        missing = self.oracle.overdue(*also)
        if missing is not None:
            self._overdue |= {missing: first, **also}
            self._open.clear()
            self.effort_of_all.spent = max(0, self.effort_of_all.spent - self.effort)
            self.effort = 0

    def _settled(self, last: Seen, *, rebooted: bool = False) -> Iterator[Finding]:
        """Yield which answers have never come, unless the node may not have been there."""
        self._wait_on(last)
        for missing in self.oracle.settled():
            seen = self._overdue.pop(missing, last)
            violation = _rebooted(missing) if rebooted and seen is last else missing
            self._missing.append(Finding(self.node_id, seen, violation))
        self._overdue.clear()
        if not self.absent:
            yield from self._all_missing()

    def _all_missing(self) -> Iterator[Finding]:
        if not self._behind.is_certain:
            yield from self._missing
        self._missing.clear()

    def _reported(self) -> Iterator[Finding]:
        """Yield what was held back, as it was to be seen what comes behind it."""
        yield from self._held
        self._held.clear()
        flood, self._flood = self._flood, None
        if flood is not None and flood.more:
            yield Finding(self.node_id, flood.latest, flood.violation, flood.more, more=True)

    def _follow_open(self, seen: Seen) -> None:
        """Remember a request of which an answer has to come, unless the client gives up first."""
        request = decode_request(seen.frame.data)
        if isinstance(request, Abort):
            self._open.clear()
        elif isinstance(request, INITIATES) and not self.oracle.in_sub_block:
            self._open.append(seen)

    def _tell(self) -> None:
        """Tell the oracle of the request that waits for its answer."""
        if self.asked is not None:
            asked, self.asked = self.asked, None
            self.oracle.request(asked.frame)

    def _is_followed(self, seen: Seen, last: Seen | None) -> bool:
        """Say whether the channel is followed: again, once it was quiet before this frame."""
        if self.out and last is not None and seen.time - last.time >= QUIET:
            self.lost()
        return not self.out

    def _judged(self, seen: Seen, last: Seen | None) -> Iterator[Found]:
        oracle, asked = self.oracle, self.asked
        self._tell()
        pause = last is not None and seen.time - last.time >= SERVER_TIMEOUT
        unasked = pause and oracle.awaited is Awaited.NOTHING
        if unasked:
            oracle.silence()
        unknown = oracle.is_unwatched
        taken = self._burst.answered(seen.frame.data, in_sub_block=oracle.in_sub_block)
        if taken is not None:
            yield Remark(self.node_id, seen, taken)
        findings = oracle.response(seen.frame)
        if oracle.unjudged:
            self.not_judged.append(seen.number)
        ended = oracle.ended
        timed_out = pause and ended is not None and ended.abort.code == AbortCode.TIMED_OUT
        by_itself = ended is not None and ended.abort.code in APPLICATION_STATE
        if ended is not None and (unasked or timed_out or by_itself or not ended.refusal):
            # It may do so at any time; whether it does so every time no log can tell.
            findings = [found for found in findings if found is not ended.violation]
        behind = self._behind.found(blamed=bool(findings))
        if self._behind.is_certain:  # whatever else is met comes of that
            findings = [] if behind is None else [behind]
        for violation in findings:
            finding = Finding(self.node_id, self._overdue.pop(violation, seen), violation)
            if unknown and finding.seen is seen:
                self._held.append(finding)
            elif not self._is_one_more(finding):
                yield from self._reported()
                self._flood = Flood(seen, violation) if violation.rule is UNSOLICITED else None
                yield finding
        if not findings:
            yield from self._reported()
        self._overdue.clear()
        if asked is not None and not findings and ended is None and oracle.idle:
            self._exchanges.add(asked, seen)

    def _is_one_more(self, finding: Finding) -> bool:
        """Count a response that nothing asked for behind another."""
        if self._flood is None or finding.violation.rule is not UNSOLICITED:
            return False
        self._flood.latest, self._flood.violation = finding.seen, finding.violation
        self._flood.more += 1
        return True

    def _limited(self, seen: Seen) -> Iterator[NotFollowed]:
        """Count what following a frame took; yield that a channel is no longer followed."""
        beyond = self.oracle.effort - self.before - USUAL_EFFORT
        self.before = self.oracle.effort
        self.effort = max(0, self.effort + beyond)
        self.effort_of_all.spent = max(0, self.effort_of_all.spent + beyond)
        too_much = self.effort > MOST_EFFORT and self.effort_of_all.spent > MOST_EFFORT_OF_ALL
        if self.oracle.given_up or too_much:
            self.out = True
            yield NotFollowed(self.node_id, seen)


def _starts_a_program(last: Seen | None) -> bool:
    """Say whether a request may start the device again: what is written to 1F51h (CiA 302-3)."""
    request = None if last is None else decode_request(last.frame.data)
    return isinstance(request, DownloadInitiate) and request.mux.index == PROGRAM_CONTROL


def _unanswered(seen: Seen) -> Violation:
    words = f"an answer to {describe(decode_request(seen.frame.data))}"
    return Violation(ANSWERED, expected=words, actual=NoAnswer())


def _rebooted(missing: Violation) -> Violation:
    """Build the breach that a device starts again in the place of an answer."""
    actual = "a boot-up message without an NMT command"
    return Violation(NO_REBOOT, expected=missing.expected, actual=actual)
