"""Block uploads (CiA 301, 7.2.4.3.13 to 7.2.4.3.15)."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

from conformance.sdo.abort_codes import ACCUSATIONS, OF_DOWNLOADS
from conformance.sdo.crc import crc16
from conformance.sdo.decoding import decode_segment
from conformance.sdo.describe import describe, hex_bytes
from conformance.sdo.frames import (
    BlockAck,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    Request,
)
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.oracle.answers import (
    BLOCK_UPLOAD,
    Codes,
    DueAbort,
    answered,
    expect,
    misread,
    require,
    require_mux,
    shape,
    zero,
)
from conformance.sdo.oracle.block_download import unsupported
from conformance.sdo.oracle.branch import Branch, Due, Freedom, Misfit, owing, quiet
from conformance.sdo.oracle.knowledge import Memory
from conformance.sdo.oracle.levels import must
from conformance.sdo.oracle.reasons import Reason, Reasons, must_refuse, read_reasons
from conformance.sdo.oracle.segmented_download import refused
from conformance.sdo.oracle.segmented_upload import require_value, upload_begins
from conformance.sdo.oracle.states import IDLE, Running, begin
from conformance.sdo.rules import (
    BLOCK_CRC,
    BLOCK_SEQUENCE,
    FILLER,
    NOT_REFUSED,
    RESERVED,
    SIZE,
    Rule,
    Violation,
    upload_initiates,
)
from conformance.sdo.rules import block_upload as rules
from conformance.sdo.rules.block_details import NUMBERED_ANEW
from conformance.sdo.rules.sizes import TYPE_LENGTH
from conformance.sdo.seen import Received

BEHIND_THE_END = "an inner frame behind the end of a block upload"


@begin.register
def _(request: BlockUploadInitiate, memory: Memory) -> list[Branch]:
    mux = request.mux
    value = memory.value(mux)
    reasons = read_reasons(memory.facts(mux), value) + unsupported(BlockUploadInitiate, mux, memory)
    branches: list[Branch] = []
    if request.threshold and not must_refuse(reasons):
        switched = upload_begins(mux, memory, request.threshold)
        branches.append(switched.choosing(Freedom("block upload within pst", "switches")))
    reasons += _block_size_reasons(request.block_size)
    if not must_refuse(reasons):
        branches.insert(0, _served(request, memory))
    return branches + refused(IDLE, mux, reasons, memory)


def _block_size_reasons(block_size: int) -> Reasons:
    if 1 <= block_size <= LARGEST_BLOCK:
        return ()
    return (Reason(upload_initiates.INVALID_BLOCK_SIZE),)


def _served(request: BlockUploadInitiate, memory: Memory) -> Branch:
    mux = request.mux
    words = f"C0h to C6h, block upload initiate response {mux}"

    def take(frame: bytes) -> Iterable[Branch]:
        response = expect(BlockUploadInitiateResponse, frame, NOT_REFUSED, words)
        require_mux(response.mux, mux, frame)
        length = memory.facts(mux).reads
        size = response.size
        fits = size is None or length in (None, size)
        require(fits, TYPE_LENGTH, f"{length} bytes, as the type has", frame)
        crc = response.crc_supported
        state = NotStarted(mux, size, crc and request.crc_supported, request.block_size)
        served = memory.serving(BlockUploadInitiate, mux)
        findings = [*shape(response, frame)]
        if size is None:
            findings += zero(RESERVED, response.payload, frame)
        rest = quiet(state, served, NOT_REFUSED, *_choices(size, crc, request))
        return [rest.noting(*findings)]

    return owing(IDLE, memory, Due(NOT_REFUSED, words, take))


def _choices(size: int | None, crc: bool, request: BlockUploadInitiate) -> Iterable[Freedom]:
    yield Freedom("block upload", "served")
    yield Freedom("size of a block upload", "not indicated" if size is None else "indicated")
    client = "can" if request.crc_supported else "cannot"
    yield Freedom(f"CRC of a block upload, client {client}", "yes" if crc else "no")
    if request.threshold and size is not None and size <= request.threshold:
        yield Freedom("block upload within pst", "in blocks")


@dataclass(frozen=True, slots=True)
class _BlockUpload(Running):
    """What the states share.

    ``data`` are the payloads that were acknowledged, ``sent`` those that were sent behind them;
    ``total`` is the number of all segments once it is known.
    """

    size: int | None
    crc: bool
    block_size: int
    data: bytes = b""
    sent: bytes = b""
    total: int | None = None
    name: ClassVar[str] = BLOCK_UPLOAD
    senseless: ClassVar[Codes] = (*ACCUSATIONS, *OF_DOWNLOADS)
    abort_rule: ClassVar[Rule] = rules.CLIENT_ABORT

    @property
    def acknowledged(self) -> int:
        """The number of segments that the client has acknowledged."""
        return len(self.data) // SEGMENT_LENGTH

    @property
    def segments(self) -> int | None:
        """The number of segments of the whole transfer; None while it is not known."""
        if self.total is not None or self.size is None:
            return self.total
        return max(-(-self.size // SEGMENT_LENGTH), 1)

    def sends(self, memory: Memory, *goes_on: int) -> list[Branch]:
        """Send the next sub-block, numbered from 1, or as the last one ``goes_on`` behind a number.

        A server should not count on, but may.
        """
        sending = Sending(
            self.mux, self.size, self.crc, self.block_size, self.data, self.sent, self.total
        )
        behind = (0, *dict.fromkeys(goes_on))
        return [replace(sending, before=number).segment_due(memory) for number in behind]

    def ends(self, memory: Memory) -> Branch:
        """Send the end of the transfer: n, and the CRC."""
        words = "C1h to DDh, block end"

        def take(frame: bytes) -> Iterable[Branch]:
            response = expect(BlockEnd, frame, rules.ENDS, words)
            data = self.data[: len(self.data) - response.unused]
            size = self.size
            require(size in (None, len(data)), SIZE, f"{size} bytes, as announced", frame)
            require_value(self.mux, data, memory, frame, whole=True)
            crc = crc16(data) if self.crc else 0
            require(response.crc == crc, BLOCK_CRC, f"CRC {crc:04X}h", frame)
            fillers = self.data[len(data) :]
            ended = BlockUploadEnd(
                self.mux, size, self.crc, self.block_size, data, ended_with=frame
            )
            rest = quiet(ended, memory, rules.ENDS)
            return [rest.noting(*shape(response, frame), *zero(FILLER, fillers, frame))]

        return owing(self, memory, Due(rules.ENDS, words, take))


@dataclass(frozen=True, slots=True)
class NotStarted(_BlockUpload):
    """The initiate is answered, the start is due."""

    foreign_rule: ClassVar[Rule] = rules.FOREIGN_BEFORE_START

    def go_on(self, request: Request, memory: Memory) -> list[Branch]:
        """Send the first sub-block."""
        if not isinstance(request, BlockUploadStart):
            ack = isinstance(request, BlockAck | BlockEndResponse)
            return self.foreign(memory, rules.NOT_STARTED if ack else rules.FOREIGN_BEFORE_START)
        branches = self.sends(memory)
        if self.size == 0 or (self.size is None and not memory.value(self.mux)):
            empty = replace(self, data=b"")
            branches.append(
                empty.ends(memory).choosing(Freedom("empty block upload", "no segment"))
            )
            branches.append(DueAbort(rules.EMPTY, (self.mux,)).branch(self, IDLE, memory))
        return branches


@dataclass(frozen=True, slots=True)
class Sending(_BlockUpload):
    """The server sends a sub-block; ``number`` is that of the segment that is due.

    ``before`` is the number behind which a server counts on, 0 where it begins anew.
    """

    number: int = 1
    before: int = 0

    def receive(self, frame: bytes, memory: Memory) -> list[Branch]:
        """Wait: while a segment is due, requests stay in the backlog."""
        raise AssertionError("a segment is due")

    def segment_due(self, memory: Memory) -> Branch:
        """Build the branch of a server that sends the next segment."""
        rule = self._rule()
        due = self.before + self.number
        words = f"block segment {due}" + (", last" if self._is_last() else "")

        def take(frame: bytes) -> Iterable[Branch]:
            response = decode_segment(frame)
            if not isinstance(response, BlockSegment):
                raise Misfit(partial(_breach, must(rule), words, frame))
            if response.sequence != due:
                raise Misfit(partial(_breach, BLOCK_SEQUENCE, words, frame), near=1)
            self._check(response, rule, words, frame, memory)
            counts_on = self.before and self.number == 1
            missed = (_breach(NUMBERED_ANEW, "block segment 1", frame),) if counts_on else ()
            return [branch.noting(*missed) for branch in self._sent(response, memory)]

        return owing(self, memory, Due(rule, words, take))

    @property
    def _position(self) -> int:
        return self.acknowledged + self.number

    def _rule(self) -> Rule:
        if self.number * SEGMENT_LENGTH <= len(self.sent):
            return rules.ACKNOWLEDGED
        return rules.NEXT_SUB_BLOCK if self.data else rules.FIRST_SUB_BLOCK

    def _is_last(self) -> bool | None:
        """Say whether the segment that is due is the very last; None when it is not known."""
        return None if self.segments is None else self._position == self.segments

    def _check(
        self, response: BlockSegment, rule: Rule, words: str, frame: bytes, memory: Memory
    ) -> None:
        marked = self._is_last()
        if marked is not None and response.last != marked:
            raise Misfit(partial(_breach, must(rule), words, frame), near=1)
        start = (self.number - 1) * SEGMENT_LENGTH
        before = self.sent[start : start + SEGMENT_LENGTH]
        if before and response.payload != before:
            expected = f"{hex_bytes(before)} again"
            raise Misfit(partial(_breach, rules.ACKNOWLEDGED, expected, frame), near=1)
        due = memory.value(self.mux)
        if due is None:
            return
        data = self.data + self.sent[:start] + response.payload
        facts = memory.facts(self.mux)
        end = min(len(data), self.size) if self.size is not None else len(data)
        if not facts.begins(data[: min(end, len(due))], due):
            raise misread(facts.reads_by, self.mux, due, response)

    def _sent(self, response: BlockSegment, memory: Memory) -> Iterable[Branch]:
        start = (self.number - 1) * SEGMENT_LENGTH
        known = self.sent[:start] + response.payload + self.sent[start + SEGMENT_LENGTH :]
        total = self._position if response.last else self.total
        following = replace(self, sent=known, total=total, number=self.number + 1)
        full = self.number == self.block_size or response.sequence == LARGEST_BLOCK
        if response.last or full:
            acknowledge = Unacknowledged(
                self.mux, self.size, self.crc, self.block_size, self.data, known, total,
                count=self.number, before=self.before,
            )  # fmt: skip
            return [quiet(acknowledge, memory, rules.FIRST_SUB_BLOCK)]
        return [following.segment_due(memory)]


def _breach(rule: Rule, expected: str, frame: bytes) -> Violation:
    return Violation(rule, expected=expected, actual=Received(decode_segment(frame)))


@dataclass(frozen=True, slots=True)
class Unacknowledged(_BlockUpload):
    """A sub-block of ``count`` segments was sent, the acknowledgement is due.

    ``before`` is the number behind which it has counted on.
    """

    count: int = 0
    before: int = 0
    foreign_rule: ClassVar[Rule] = rules.FOREIGN

    def go_on(self, request: Request, memory: Memory) -> list[Branch]:
        """Send what is next, or what was lost, or the end."""
        if not isinstance(request, BlockAck):
            return self.foreign(memory)
        if request.sequence > self.before + self.count:
            return [self._refused(DueAbort(rules.ACKNOWLEDGES_TOO_MANY), memory)]
        count = max(request.sequence - self.before, 0)
        goes_on = {request.sequence, self.before} - {0} if count < self.count else ()
        taken = count * SEGMENT_LENGTH
        following = replace(
            self,
            block_size=request.block_size,
            data=self.data + self.sent[:taken],
            sent=self.sent[taken:],
        )
        complete = bool(request.sequence) and following.acknowledged == self.segments
        ending = [following.ends(memory)] if complete else []
        if 1 <= request.block_size <= LARGEST_BLOCK:
            return ending or following.sends(memory, *goes_on)
        # Behind the last segment nothing is left that a block size could be about.
        topic = "an impossible block size in the last acknowledgement"
        invalid = DueAbort(rules.ACKNOWLEDGES_BLOCK_SIZE)
        return [
            *(branch.choosing(Freedom(topic, "ignored")) for branch in ending),
            self._refused(invalid, memory).choosing(Freedom(topic, "refused")),
        ]

    def _refused(self, refusal: DueAbort, memory: Memory) -> Branch:
        return refusal.named(self.mux).branch(self, IDLE, memory)


@dataclass(frozen=True, slots=True)
class BlockUploadEnd(_BlockUpload):
    """The end frame was sent, its confirmation is due, which is not answered."""

    ended_with: bytes = b""
    abort_rule: ClassVar[Rule] = rules.CLIENT_ABORT_AT_END
    foreign_rule: ClassVar[Rule] = rules.OVER

    def receive(self, frame: bytes, memory: Memory) -> list[Branch]:
        """Take a confirmation with reserved bits for what is out of place, too."""
        branches = Running.receive(self, frame, memory)
        if len(frame) == FRAME_LENGTH and isinstance(
            request := self.decode(frame), BlockEndResponse
        ):
            branches += self._out_of_place(memory) if request.reserved_bits else []
        return branches

    def go_on(self, request: Request, memory: Memory) -> list[Branch]:
        """Be idle when the client has everything."""
        if isinstance(request, BlockEndResponse):
            steady = memory.facts(self.mux).steady
            after = memory.learned(self.mux, self.data) if steady else memory
            return [quiet(IDLE, after, rules.OVER)]
        if isinstance(request, BlockUploadStart):
            return self._out_of_place(memory)
        if not isinstance(request, BlockAck):
            return self.foreign(memory)
        rule = rules.ACKNOWLEDGED_AGAIN
        end = BlockEnd.decode(self.ended_with)
        again = answered(
            BlockEnd, rule, f"{describe(end)}, again", self, quiet(self, memory, rule),
            unused=end.unused, crc=end.crc,
        )  # fmt: skip
        return [
            again.choosing(Freedom(BEHIND_THE_END, "end repeated")),
            *self._out_of_place(memory),
        ]

    def _out_of_place(self, memory: Memory) -> list[Branch]:
        """Ignore or refuse what belongs earlier in the transfer, or to no place of it."""
        rule = rules.ACKNOWLEDGED_AGAIN
        return [
            quiet(self, memory, rule, Freedom(BEHIND_THE_END, "ignored")),
            *(
                branch.choosing(Freedom(BEHIND_THE_END, "refused"))
                for branch in self.foreign(memory, rule)
            ),
        ]
