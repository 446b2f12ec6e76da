"""Expedited and segmented uploads (CiA 301, 7.2.4.3.6 and 7.2.4.3.7)."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import ClassVar

from conformance.sdo.abort_codes import ACCUSATIONS, OF_DOWNLOADS
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import (
    DownloadSegment,
    Request,
    Unknown,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.oracle.answers import (
    Codes,
    DueAbort,
    expect,
    initiate_shape,
    misread,
    require,
    require_mux,
    zero,
)
from conformance.sdo.oracle.branch import Branch, Due, Freedom, owing, quiet
from conformance.sdo.oracle.knowledge import Memory
from conformance.sdo.oracle.reasons import must_refuse, read_reasons
from conformance.sdo.oracle.segmented_download import refused
from conformance.sdo.oracle.states import IDLE, Running, begin
from conformance.sdo.rules import (
    FILLER,
    NOT_REFUSED,
    SIZE,
    TOGGLE,
    UPLOAD_ENDS,
    Rule,
    upload_initiates,
)
from conformance.sdo.rules import segmented_upload as rules
from conformance.sdo.rules.sizes import TYPE_LENGTH

# Empty segments are allowed; a server that sends nothing else never comes to an end.
MOST_EMPTY_SEGMENTS = 16
FOREIGN_RULES: dict[type, Rule] = {
    DownloadSegment: rules.DOWNLOAD_SEGMENT,
    Unknown: rules.UNKNOWN_SPECIFIER,
}


@begin.register
def _(request: UploadInitiate, memory: Memory) -> list[Branch]:
    reasons = read_reasons(memory.facts(request.mux), memory.value(request.mux))
    branches = refused(IDLE, request.mux, reasons, memory)
    return branches if must_refuse(reasons) else [upload_begins(request.mux, memory), *branches]


def upload_begins(mux: Multiplexer, memory: Memory, most: int | None = None) -> Branch:
    """Build the branch of a server that answers with an ordinary upload.

    ``most`` is pst where a block upload becomes one: the most bytes that it may have.
    """
    words = f"4xh, upload initiate response {mux}"
    rule = NOT_REFUSED if most is None else upload_initiates.SWITCH

    def take(frame: bytes) -> Iterable[Branch]:
        response = expect(UploadInitiateResponse, frame, rule, words)
        require_mux(response.mux, mux, frame)
        facts = memory.facts(mux)
        shape = tuple(initiate_shape(response, frame, facts.length))
        if response.expedited:
            data = response.data
            if not response.sized:
                data = data[: _uncounted(mux, memory)]
            require_value(mux, data, memory, frame, whole=True)
            require(
                most is None or len(data) <= most,
                upload_initiates.ABOVE_THRESHOLD,
                f"{most} bytes at most",
                frame,
            )
            kind = "counted" if response.sized else "not counted"
            known = response.sized or facts.length is not None
            after = memory.learned(mux, data) if known and facts.steady else memory
            rest = quiet(IDLE, after, NOT_REFUSED, Freedom("expedited upload", kind))
        else:
            size = response.size
            _require_size(mux, size, memory, most, frame)
            choice = "not indicated" if size is None else "indicated"
            state = SegmentedUpload(mux, size, most)
            rest = quiet(state, memory, NOT_REFUSED, Freedom("size of a segmented upload", choice))
        return [rest.noting(*shape)]

    return owing(IDLE, memory, Due(rule, words, take))


def _uncounted(mux: Multiplexer, memory: Memory) -> int | None:
    """Return how many bytes count where the answer does not say it."""
    value = memory.value(mux)
    return memory.facts(mux).length or (len(value) if value is not None else None)


def _require_size(
    mux: Multiplexer, size: int | None, memory: Memory, most: int | None, frame: bytes
) -> None:
    if size is None:
        return
    length = memory.facts(mux).reads
    require(length in (None, size), TYPE_LENGTH, f"{length} bytes, as the type has", frame)
    require(
        most is None or size <= most,
        upload_initiates.ABOVE_THRESHOLD,
        f"{most} bytes at most, as pst says",
        frame,
    )


def require_value(
    mux: Multiplexer, data: bytes, memory: Memory, frame: bytes, *, whole: bool
) -> None:
    """Raise Misfit when data, or their beginning, are not what the object has to read as."""
    facts = memory.facts(mux)
    due = memory.value(mux)
    if whole:
        fits = facts.reads in (None, len(data))
        require(fits, TYPE_LENGTH, f"{facts.reads} bytes, as the type has", frame)
    if due is not None:
        holds = facts.same(data, due) if whole else facts.begins(data, due)
        if not holds:
            raise misread(facts.reads_by, mux, due, decode_response(frame))


@dataclass(frozen=True, slots=True)
class SegmentedUpload(Running):
    """The client asks for segments. ``most`` is pst where a block upload became this one."""

    size: int | None
    most: int | None = None
    data: bytes = b""
    toggle: int = 0
    empty: int = 0
    name: ClassVar[str] = "segmented upload"
    senseless: ClassVar[Codes] = (*ACCUSATIONS, *OF_DOWNLOADS)
    abort_rule: ClassVar[Rule] = rules.CLIENT_ABORT
    foreign_rule: ClassVar[Rule] = rules.BLOCK_FRAMES
    gives_way: ClassVar[bool] = True

    def go_on(self, request: Request, memory: Memory) -> list[Branch]:
        """Send the next segment."""
        if not isinstance(request, UploadSegment):
            return self.foreign(memory, FOREIGN_RULES.get(type(request), self.foreign_rule))
        if request.toggle != self.toggle:
            return [DueAbort(rules.TOGGLE, (self.mux,)).branch(self, IDLE, memory)]
        return [self._segment(memory)]

    def _segment(self, memory: Memory) -> Branch:
        words = f"upload segment response, t={self.toggle}"

        def take(frame: bytes) -> Iterable[Branch]:
            response = expect(UploadSegmentResponse, frame, rules.SEGMENTS, words)
            require(response.toggle == self.toggle, TOGGLE, words, frame)
            data = self.data + response.data
            self._require_length(data, response.last, frame)
            require_value(self.mux, data, memory, frame, whole=response.last)
            shape = zero(FILLER, response.payload[len(response.data) :], frame)
            empty = self.empty + (not response.data)
            if response.last:
                steady = memory.facts(self.mux).steady
                after = memory.learned(self.mux, data) if steady else memory
                return [quiet(IDLE, after, rules.SEGMENTS).noting(*shape)]
            require(empty <= MOST_EMPTY_SEGMENTS, UPLOAD_ENDS, "a last segment", frame)
            going = replace(self, data=data, toggle=self.toggle ^ 1, empty=empty)
            return [quiet(going, memory, rules.SEGMENTS).noting(*shape)]

        return owing(self, memory, Due(rules.SEGMENTS, words, take))

    def _require_length(self, data: bytes, last: bool, frame: bytes) -> None:
        if self.size is not None:
            fits = len(data) == self.size if last else len(data) <= self.size
            require(fits, SIZE, f"{self.size} bytes, as announced", frame)
        if self.most is not None:
            require(
                len(data) <= self.most,
                upload_initiates.ABOVE_THRESHOLD,
                f"{self.most} bytes at most",
                frame,
            )
