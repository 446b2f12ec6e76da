"""Block downloads (CiA 301, 7.2.4.3.9 to 7.2.4.3.11)."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.decoding import decode_response, decode_segment
from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    Request,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.oracle.answers import (
    Codes,
    DueAbort,
    answered,
    expect,
    require,
    require_mux,
    shape,
    violation,
)
from conformance.sdo.oracle.branch import Branch, Due, Freedom, owing, quiet
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
    write_reasons,
)
from conformance.sdo.oracle.segmented_download import refused
from conformance.sdo.oracle.states import IDLE, Running, begin
from conformance.sdo.rules import BLOCK_ACK, BLOCK_SIZE, NOT_REFUSED, Rule, accepted, idle
from conformance.sdo.rules import block_download as rules


def unsupported(service: type, mux: Multiplexer, memory: Memory) -> Reasons:
    """Return why a block initiate is refused by a server that lacks the service.

    A server that has served it for this object has it.
    """
    served = (service, mux) in memory.served
    return () if served else (Reason(idle.BLOCK_UNSUPPORTED, binding=False),)


@begin.register
def _(request: BlockDownloadInitiate, memory: Memory) -> list[Branch]:
    mux = request.mux
    facts = memory.facts(mux)
    reasons = (
        *write_reasons(facts),
        *announced_reasons(facts, request.size, block=True),
        *unsupported(BlockDownloadInitiate, mux, memory),
    )
    branches = refused(IDLE, mux, reasons, memory)
    if must_refuse_now(reasons):
        return branches
    words = f"A0h or A4h, block download initiate response {mux}"
    late = tuple(reason for reason in reasons if reason.late)

    def take(frame: bytes) -> Iterable[Branch]:
        response = expect(BlockDownloadInitiateResponse, frame, rules.FULL_SUB_BLOCK, words)
        require_mux(response.mux, mux, frame)
        require_block_size(response.block_size, frame)
        begun = memory.begun(mux).serving(BlockDownloadInitiate, mux)
        crc = response.crc_supported
        state = SubBlock(
            mux,
            request.size,
            late,
            crc and request.crc_supported,
            response.block_size,
            begun_with=late,
        )
        rest = quiet(state, begun, NOT_REFUSED, *_choices(response.block_size, crc, request))
        return [rest.noting(*shape(response, frame))]

    return [owing(IDLE, memory, Due(NOT_REFUSED, words, take)), *branches]


def _choices(block_size: int, crc: bool, request: BlockDownloadInitiate) -> Iterable[Freedom]:
    yield Freedom("block download", "served")
    yield Freedom("block size of a download", str(block_size))
    client = "can" if request.crc_supported else "cannot"
    yield Freedom(f"CRC of a block download, client {client}", "yes" if crc else "no")


def require_block_size(block_size: int, frame: bytes) -> None:
    """Raise Misfit for a block size that cannot be."""
    require(1 <= block_size <= LARGEST_BLOCK, BLOCK_SIZE, "blksize 1 to 127", frame)


@dataclass(frozen=True, slots=True)
class _BlockDownload(Running):
    """What both states share: announced size, why it may still fail, CRC, and the data so far."""

    size: int | None
    reasons: Reasons
    crc: bool
    block_size: int
    data: bytes = b""


@dataclass(frozen=True, slots=True)
class SubBlock(_BlockDownload):
    """Segments are due. ``expected`` is the number of the next one in sequence.

    ``broken``: a segment was lost, and what follows in this sub-block is discarded. After a break
    that was acknowledged at once, numbers above ``stale`` may belong to the sub-block before.
    ``highest`` is the highest number that came: one that is not above it is late, or repeated, and
    the server may take that for ``disorder`` and abort. So it may where a sub-block behind a gap
    begins with the ``old`` number, from 3 on: that with which the one before would have gone on.

    ``begun_with`` are the reasons that were there before the sub-block: what the server has lost of
    it is none.

    Why it aborts where nothing is to be answered, ``refusals`` says: to follow each segment both
    ways would be more than can be followed.
    """

    expected: int = 1
    broken: bool = False
    stale: int | None = None
    highest: int = 0
    disorder: bool = False
    old: int = 0
    begun_with: Reasons = ()
    name: ClassVar[str] = "block download"
    # One that has lost a segment of a burst may call the next one out of sequence.
    senseless: ClassVar[Codes] = tuple(
        code for code in Running.senseless if code is not AbortCode.INVALID_SEQUENCE_NUMBER
    )
    abort_rule: ClassVar[Rule] = rules.ABORT_IN_SUB_BLOCK

    def decode(self, frame: bytes) -> Request:
        """Within a sub-block everything but an abort is a segment."""
        return decode_segment(frame)

    def on(self, request: Request, memory: Memory) -> list[Branch]:
        """Take, or discard, a segment."""
        if not isinstance(request, BlockSegment):
            return self.foreign(memory, rules.SEGMENTS_ONLY)
        return self._heard(request)._on_segment(request, memory)

    def refusals(self) -> list[DueAbort]:
        """Return the aborts that may come where no answer is due, best reasons first."""
        found = [reason.refusal(self.mux) for reason in self.reasons]
        if self.disorder:
            found.append(DueAbort(rules.SEQUENCE_ZERO, (self.mux,)))
        return found

    def behind(self, frames: Iterable[bytes]) -> Self:
        """Return the state that knows of the numbers that have come since, up to an abort."""
        state = self
        for frame in frames:
            request = self.decode(frame)
            if not isinstance(request, BlockSegment):
                break
            state = state._heard(request)
        return state

    def _heard(self, request: BlockSegment) -> Self:
        """Return the state that knows of a number."""
        number = request.sequence
        late = number <= self.highest or not 1 <= number <= self.block_size
        late |= self.highest == 0 and number == self.old > 2
        return replace(self, highest=max(number, self.highest), disorder=self.disorder or late)

    def _on_segment(self, request: BlockSegment, memory: Memory) -> list[Branch]:
        branches = self._follow(request, memory)
        if self.stale is not None and request.sequence > self.stale:
            left_over = replace(self, stale=request.sequence)
            return [quiet(left_over, memory, rules.GAP), *self._later(request, memory)]
        return branches

    def _follow(self, request: BlockSegment, memory: Memory) -> list[Branch]:
        number = request.sequence
        if not 1 <= number <= self.block_size:
            topic = "an impossible sequence number"
            return [
                quiet(self, memory, rules.SEQUENCE_ZERO, Freedom(topic, "ignored")),
                *(
                    branch.choosing(Freedom(topic, "breaks"))
                    for branch in self._break(request, memory)
                ),
            ]
        if self.broken:
            return self._later(request, memory)
        if number == self.expected:
            return self._take(request, memory)
        if number > self.expected:
            return self._break(request, memory)
        topic = "a repeated segment"
        ignored = [quiet(self, memory, rules.REPEATED_SEGMENT, Freedom(topic, "ignored"))]
        if request.last:
            ignored.append(self._acknowledge(memory, rules.REPEATED_SEGMENT))
        return [
            *ignored,
            *(branch.choosing(Freedom(topic, "breaks")) for branch in self._break(request, memory)),
        ]

    def _take(self, request: BlockSegment, memory: Memory) -> list[Branch]:
        """Take the segment that is due."""
        data = self.data + request.payload
        reasons = self.reasons + self._excess(len(data), memory)
        if request.last:
            reasons += self._shortfall(len(data), memory)
        reasons = distinct(reasons)
        taken = replace(self, data=data, reasons=reasons, expected=self.expected + 1, stale=None)
        if self._completes(request):
            rule = rules.LAST_SEGMENT if request.last else rules.FULL_SUB_BLOCK
            branches = refused(self, self.mux, reasons, memory)
            return [taken._acknowledge(memory, rule, request), *branches]
        return [quiet(taken, memory, rules.FULL_SUB_BLOCK)]

    def _excess(self, count: int, memory: Memory) -> Reasons:
        """Say why ``count`` bytes, fillers of the last segment included, are too many.

        A last segment without data (n = 7) is odd: it may be taken for one too many.
        """
        facts = memory.facts(self.mux)
        least = max(count - SEGMENT_LENGTH, 0)
        certain = excess_reasons(facts, self.size, least, rules.TOO_MANY)
        possible = excess_reasons(facts, self.size, least + 1, rules.TOO_MANY) if least else ()
        return certain or tuple(replace(reason, binding=False) for reason in possible)

    def _shortfall(self, count: int, memory: Memory) -> Reasons:
        """Say why a transfer that ends after ``count`` bytes, fillers included, has too few."""
        least = max(self.size or 0, memory.facts(self.mux).length or 0)
        return (
            (Reason(rules.TOO_FEW, accepted.TOO_SHORT, accepted.GENERAL, late=True),)
            if count < least
            else ()
        )

    def _break(self, request: BlockSegment, memory: Memory) -> list[Branch]:
        """Acknowledge what came in sequence before a gap: at once, at the end, or much later.

        A server that looks for the number that is due and does nothing else takes it when it comes
        late, and may leave it to its time-out to say that it lacks one.
        """
        topic = "acknowledges a gap"
        waiting = quiet(self, memory, rules.GAP, Freedom("behind a gap", "waits for what is due"))
        at_once = replace(self, stale=request.sequence)._acknowledge(memory, rules.GAP)
        later = self._later(request, memory)
        if self._completes(request):
            # Both are the same, but for what the server thinks of the segments that follow.
            return [at_once, *later, waiting]
        return [
            waiting,
            at_once.choosing(Freedom(topic, "at once")),
            *(branch.choosing(Freedom(topic, "at the end of the sub-block")) for branch in later),
        ]

    def _later(self, request: BlockSegment, memory: Memory) -> list[Branch]:
        """Discard a segment behind a gap; acknowledge what came before it at the end."""
        if self._completes(request):
            return [replace(self, stale=None)._acknowledge(memory, rules.GAP)]
        return [quiet(replace(self, broken=True, stale=None), memory, rules.GAP)]

    def _completes(self, request: BlockSegment) -> bool:
        """Say whether a segment, in sequence or not, is the last one of the sub-block."""
        return request.last or request.sequence >= self.block_size

    def lossy(self, frame: bytes, memory: Memory) -> Due | None:
        """Return what is due where a response shows that the server has lost a segment.

        It may say so at once: the frame names fewer segments than came in sequence.
        """
        response = decode_response(frame)
        if not isinstance(response, BlockAck) or response.sequence >= self.expected - 1:
            return None
        return replace(self, stale=self.highest)._acknowledge(memory, rules.GAP).due

    def _acknowledge(self, memory: Memory, rule: Rule, last: BlockSegment | None = None) -> Branch:
        """Build the branch of a server that acknowledges what came in sequence.

        It may have lost some of that: any number is right that is not above.
        """
        number = self.expected - 1
        words = f"A2h, block acknowledgement, ackseq {number}"

        def take(frame: bytes) -> Iterable[Branch]:
            response = expect(BlockAck, frame, rule, words)
            require(response.sequence <= number, BLOCK_ACK, words, frame)
            require_block_size(response.block_size, frame)
            block_size = response.block_size
            whole = response.sequence == number
            if whole and last is not None and last.last:
                ended = BlockDownloadEnd(
                    self.mux, self.size, self.reasons, self.crc, block_size, self.data,
                    last.encode(), frame,
                )  # fmt: skip
                rest = quiet(ended, memory, rule)
            else:
                rest = quiet(self._next_sub_block(response, memory), memory, rule)
            chosen = Freedom("block size of a download", str(block_size))
            missed = () if whole else (violation(rules.WHOLE_SUB_BLOCK, words, frame),)
            return [rest.choosing(chosen).noting(*missed, *shape(response, frame))]

        return owing(self, memory, Due(rule, words, take))

    def _next_sub_block(self, ack: BlockAck, memory: Memory) -> Self:
        lost = self.expected - 1 - ack.sequence
        data, reasons = self.data, self.reasons
        if lost:
            data = data[: len(data) - lost * SEGMENT_LENGTH]
            reasons = distinct(self.begun_with + self._excess(len(data), memory))
        return replace(
            self,
            data=data,
            reasons=reasons,
            begun_with=reasons,
            expected=1,
            broken=False,
            block_size=ack.block_size,
            highest=0,
            disorder=False,
            old=ack.sequence + 1,
        )

    def pass_time(self, memory: Memory) -> list[Branch]:
        """Give up, acknowledge what has come, or wait."""
        again = replace(self, stale=None)._acknowledge(memory, rules.SILENT_IN_SUB_BLOCK)
        chosen = Freedom("server time-out in a sub-block", "acknowledges")
        return [*Running.pass_time(self, memory), again.choosing(chosen)]


@dataclass(frozen=True, slots=True)
class BlockDownloadEnd(_BlockDownload):
    """The last segment is acknowledged, the end is due.

    ``last_segment`` and ``acknowledgement`` are kept: if the one is lost, both may come again.
    """

    last_segment: bytes = b""
    acknowledgement: bytes = b""
    name: ClassVar[str] = "block download"
    abort_rule: ClassVar[Rule] = rules.ABORT_BEFORE_END
    foreign_rule: ClassVar[Rule] = rules.FOREIGN_AT_END

    def receive(self, frame: bytes, memory: Memory) -> list[Branch]:
        """Take the last segment again, or what a frame says otherwise."""
        branches = Running.receive(self, frame, memory)
        if frame != self.last_segment:
            return branches
        topic = "the last segment of a block download again"
        return [
            quiet(self, memory, rules.LAST_AGAIN, Freedom(topic, "ignored")),
            self._acknowledged_again(memory).choosing(Freedom(topic, "acknowledged")),
            DueAbort(rules.LAST_AGAIN).branch(self, IDLE, memory, Freedom(topic, "refused")),
            *branches,
        ]

    def _acknowledged_again(self, memory: Memory) -> Branch:
        due = BlockAck.decode(self.acknowledgement)
        words = f"A2h, block acknowledgement, ackseq {due.sequence}, again"
        after = quiet(self, memory, rules.LAST_AGAIN)
        return answered(BlockAck, rules.LAST_AGAIN, words, self, after, sequence=due.sequence)

    def go_on(self, request: Request, memory: Memory) -> list[Branch]:
        """Confirm the end, or refuse what came."""
        if not isinstance(request, BlockEnd):
            return self.foreign(memory)
        facts = memory.facts(self.mux)
        data = self.data[: len(self.data) - request.unused]
        reasons = self.reasons + excess_reasons(facts, self.size, len(data), rules.UNUSED_TOO_MANY)
        reasons += final_reasons(facts, self.size, data, rules.TOO_FEW, block=True)
        wrong_crc = self.crc and request.crc != crc16(data)
        if wrong_crc or (self.crc and must_refuse(reasons)):
            # Both the size and the CRC may be wrong at once: either is named.
            reasons += (Reason(rules.WRONG_CRC, binding=wrong_crc),)
        # A bad end frame may be called just that, though there are better codes.
        reasons = tuple(replace(reason, tolerate=accepted.IMPRECISE) for reason in reasons)
        branches = refused(self, self.mux, distinct(reasons), memory)
        if must_refuse(reasons):
            return branches
        after = quiet(IDLE, memory.learned(self.mux, data), rules.STORED)
        words = "A1h, block end response"
        return [answered(BlockEndResponse, rules.STORED, words, self, after), *branches]
