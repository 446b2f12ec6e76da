"""Expedited and segmented downloads (CiA 301, 7.2.4.3.3 and 7.2.4.3.4)."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import ClassVar

from conformance.sdo.frames import (
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Unknown,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import TEXT_TYPES
from conformance.sdo.oracle.answers import DueAbort, answered, refusing
from conformance.sdo.oracle.branch import Branch, Freedom, State, owing, quiet
from conformance.sdo.oracle.knowledge import Memory
from conformance.sdo.oracle.reasons import (
    Reason,
    Reasons,
    announced_reasons,
    distinct,
    excess_reasons,
    final_reasons,
    must_refuse,
    must_refuse_now,
    value_reasons,
    write_reasons,
)
from conformance.sdo.oracle.states import IDLE, Running, begin
from conformance.sdo.rules import NOT_REFUSED, Rule, Violation, sizes
from conformance.sdo.rules import download_initiates as initiates
from conformance.sdo.rules import segmented_download as rules
from conformance.sdo.seen import said

SHORT = 4
# By these a server refuses what it should take: their codes are tolerated at most.
NO_EMPTY_LAST, NO_SHORT_SEGMENTS = (
    (Reason(rule, (), rule.tolerated, binding=False),)
    for rule in (rules.EMPTY_LAST, rules.SHORT_SEGMENTS)
)
FOREIGN_RULES: dict[type, Rule] = {
    UploadSegment: rules.UPLOAD_SEGMENT,
    Unknown: rules.UNKNOWN_SPECIFIER,
}


@begin.register
def _(request: DownloadInitiate, memory: Memory) -> list[Branch]:
    if request.expedited:
        return _expedited(request, memory)
    mux = request.mux
    facts = memory.facts(mux)
    reasons = (*write_reasons(facts), *announced_reasons(facts, request.size, block=False))
    branches = refused(IDLE, mux, reasons, memory)
    if not must_refuse_now(reasons):
        late = tuple(reason for reason in reasons if reason.late)
        state = SegmentedDownload(mux, request.size, late)
        branches.insert(0, _confirmed(mux, state, memory.begun(mux)))
    return branches


def _expedited(request: DownloadInitiate, memory: Memory) -> list[Branch]:
    mux = request.mux
    facts = memory.facts(mux)
    data = request.data if request.sized else request.data[: facts.length]
    reasons = (*write_reasons(facts), *_length_reasons(request, facts.length))
    if facts.length in (None, len(data)):
        reasons += value_reasons(facts, data)
    if facts.varies and (facts.capacity is None or facts.data_type not in TEXT_TYPES):
        reasons += (Reason(sizes.VARIABLE_LENGTH, binding=False),)
    branches = refused(IDLE, mux, reasons, memory)
    if not must_refuse(reasons):
        # Without a count, only a type of fixed length says how many bytes are stored.
        stored = data if request.sized or facts.length is not None else None
        branches.insert(0, _confirmed(mux, IDLE, memory.learned(mux, stored)))
    return branches


def _length_reasons(request: DownloadInitiate, length: int | None) -> Reasons:
    if not request.sized:
        if length is None:
            return (Reason(initiates.SIZE_NOT_INDICATED, binding=False),)
        if length > SHORT:
            return (Reason(initiates.TOO_SHORT),)
        if length == SHORT:
            return ()
        return (Reason(initiates.SIZE_NOT_INDICATED_SHORT, binding=False),)
    if length is None or len(request.data) == length:
        return ()
    if len(request.data) > length:
        return (Reason(initiates.TOO_LONG),)
    return (Reason(initiates.TOO_SHORT),)


def _confirmed(mux: Multiplexer, state: State, memory: Memory) -> Branch:
    words = f"60h, download initiate response {mux}"
    after = quiet(state, memory, NOT_REFUSED)
    return answered(DownloadInitiateResponse, NOT_REFUSED, words, IDLE, after, mux=mux)


def refused(before: State, mux: Multiplexer, reasons: Reasons, memory: Memory) -> list[Branch]:
    """Return the branch of a server that refuses for one of the reasons, binding ones first."""
    if not reasons:
        return []
    binding_first = sorted(reasons, key=lambda reason: not reason.binding)
    refusals = [reason.refusal(mux) for reason in binding_first]
    return [owing(before, memory, refusing(refusals, before, IDLE, memory))]


@dataclass(frozen=True, slots=True)
class SegmentedDownload(Running):
    """Segments are due. ``reasons`` are those from the initiate for which it may still fail."""

    size: int | None
    reasons: Reasons = ()
    data: bytes = b""
    toggle: int = 0
    name: ClassVar[str] = "segmented download"
    abort_rule: ClassVar[Rule] = rules.CLIENT_ABORT
    foreign_rule: ClassVar[Rule] = rules.BLOCK_FRAMES
    gives_way: ClassVar[bool] = True

    def go_on(self, request: Request, memory: Memory) -> list[Branch]:
        """Take a segment."""
        if not isinstance(request, DownloadSegment):
            return self.foreign(memory, FOREIGN_RULES.get(type(request), self.foreign_rule))
        if request.toggle != self.toggle:
            topic = "toggle error in a download"
            refusal = DueAbort(rules.TOGGLE, (self.mux,))
            return [
                refusal.branch(self, IDLE, memory, Freedom(topic, "aborts")),
                quiet(self, memory, rules.TOGGLE, Freedom(topic, "ignored")),
            ]
        return [
            after
            for data, freedoms in self._readings(request, memory)
            for after in self._read_as(data, request, freedoms, memory)
        ]

    def _read_as(
        self,
        data: bytes,
        request: DownloadSegment,
        freedoms: tuple[Freedom, ...],
        memory: Memory,
    ) -> Iterable[Branch]:
        """Yield how to go on with a segment that is taken for these bytes."""
        missed: tuple[Violation, ...] = ()
        if len(data) > len(request.data):
            expected = f"the {len(request.data)} bytes of a segment that states n"
            missed = (
                Violation(rules.SHORT_SEGMENTS, expected=expected, actual=said("{}", len(data))),
            )
        for branch in self._taken(data, request, memory):
            yield branch.choosing(*freedoms).noting(*missed)

    def _readings(
        self, request: DownloadSegment, memory: Memory
    ) -> Iterable[tuple[bytes, tuple[Freedom, ...]]]:
        """Yield what a segment may hold: n = 0 in the last one also means "not stated".

        A server that looks at n there only takes 7 bytes of any other, or as many as there is
        room for.
        """
        yield request.data, ()
        limit = self.size if self.size is not None else memory.facts(self.mux).length
        room = len(request.payload) if limit is None else max(limit - len(self.data), 0)
        if request.last and not request.unused and room < len(request.data):
            yield request.data[:room], (Freedom("n = 0 in a short last segment", "not stated"),)
        if not request.last and request.unused:
            chosen = (Freedom("n before the last segment", "ignored"),)
            yield request.payload, chosen
            if len(request.data) < room < len(request.payload):
                yield request.payload[:room], chosen

    def _taken(self, data: bytes, request: DownloadSegment, memory: Memory) -> list[Branch]:
        facts, last = memory.facts(self.mux), request.last
        whole = self.data + data
        reasons = self.reasons + excess_reasons(facts, self.size, len(whole), rules.TOO_MANY)
        if last:
            reasons += final_reasons(facts, self.size, whole, rules.TOO_FEW, block=False)
            reasons += () if request.data else NO_EMPTY_LAST
        reasons = distinct(reasons)
        at_once = NO_SHORT_SEGMENTS if request.unused and not last else ()
        branches = refused(self, self.mux, (*reasons, *at_once), memory)
        if last and must_refuse(reasons):
            return branches
        after = quiet(IDLE, memory.learned(self.mux, whole), rules.STORED)
        if not last:
            late = tuple(reason for reason in reasons if reason.late)
            going = replace(self, reasons=late, data=whole, toggle=self.toggle ^ 1)
            after = quiet(going, memory, rules.CONFIRMED)
        words = f"{0x20 | self.toggle << 4:02X}h, download segment response, t={self.toggle}"
        rule = rules.STORED if last else rules.CONFIRMED
        confirmed = answered(DownloadSegmentResponse, rule, words, self, after, toggle=self.toggle)
        return [confirmed, *branches]
