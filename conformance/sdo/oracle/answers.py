"""Answers as they may be due: aborts of all sorts, and what every other response is held to."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TypeVar

from conformance.sdo.abort_codes import OF_DOWNLOADS, OF_UPLOADS, AbortCode, describe_code
from conformance.sdo.decoding import decode_response, decode_segment, is_refusal
from conformance.sdo.describe import hex_bytes
from conformance.sdo.frames import (
    Abort,
    BlockSegment,
    Response,
    UploadInitiateResponse,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Message, Multiplexer
from conformance.sdo.oracle.branch import Branch, Due, Freedom, Misfit, State
from conformance.sdo.oracle.knowledge import Memory
from conformance.sdo.oracle.levels import must, should
from conformance.sdo.rules import (
    ABORT_CODE,
    FILLER,
    MULTIPLEXER,
    NOT_REFUSED,
    OTHER_SERVICE,
    RESERVED,
    SUBSTITUTE,
    UNUSED_COUNT,
    Rule,
    Violation,
)
from conformance.sdo.seen import Misread, Received, Said, filled

Kind = TypeVar("Kind", bound=Message)
Codes = tuple[AbortCode, ...]
KNOWN_CODES = tuple(AbortCode)
# The name of all states of a block upload.
BLOCK_UPLOAD = "block upload"


@dataclass(frozen=True, slots=True)
class DueAbort:
    """An abort that may be due: by which rule, which has the codes that are right.

    ``only`` are the codes that are right here, ``tolerate`` those that are tolerated here, where
    the rule says otherwise. ``muxes`` are those that the abort may name; None stands for any.
    ``looks_like`` is what the request has in the place of a multiplexer, where it need not be one.
    ``findings`` are noted when the server refuses: where it should not.
    """

    rule: Rule
    muxes: tuple[Multiplexer, ...] | None = None
    only: Codes | None = None
    tolerate: Codes | None = None
    looks_like: Multiplexer | None = None
    findings: tuple[Violation, ...] = ()

    @property
    def codes(self) -> Codes:
        """The codes that are right."""
        return self.rule.codes if self.only is None else self.only

    @property
    def tolerated(self) -> Codes:
        """The codes that are accepted as well, as breaches of a SHOULD."""
        return self.rule.tolerated if self.tolerate is None else self.tolerate

    def words(self) -> str:
        """Say what is expected."""
        return _any_of(self.codes)

    def branch(self, before: State, after: State, memory: Memory, *freedoms: Freedom) -> Branch:
        """Build the branch of a server that refuses, and is in ``after`` then."""
        due = refusing((self,), before, after, memory, *freedoms)
        return Branch(before, memory, self.rule, due)

    def taken(
        self, abort: Abort, frame: bytes, after: State, memory: Memory, freedoms: Iterable[Freedom]
    ) -> Branch:
        """Return where a server is that has sent this abort for this reason."""
        chosen = frozenset((*freedoms, *self._choices(abort)))
        rest = Branch(after, memory, self.rule, freedoms=chosen)
        return rest.noting(*self.breaches(abort, frame), *self.findings)

    def read(self, frame: bytes) -> Abort:
        """Read an abort, or say that the frame is none."""
        abort = decode_response(frame)
        if not isinstance(abort, Abort):
            raise Misfit(partial(breach, self.rule, self.words(), frame))
        return abort

    def _choices(self, abort: Abort) -> Iterable[Freedom]:
        yield Freedom(f"abort by {self.rule.id}", describe_code(abort.code))
        if self.looks_like is not None:
            own = "that of the request" if abort.mux == self.looks_like else "another"
            yield Freedom("multiplexer of an abort without a transfer", own)

    def breaches(self, abort: Abort, frame: bytes) -> Iterable[Violation]:
        """Yield what is wrong with an abort that came for this reason."""
        yield from shape(abort, frame)
        if self.muxes is not None and abort.mux not in self.muxes:
            named = " or ".join(str(mux) for mux in self.muxes)
            yield violation(MULTIPLEXER, f"multiplexer {named}", frame)
        if abort.code not in KNOWN_CODES:
            yield violation(ABORT_CODE, self.words(), frame)
        elif abort.code in self.tolerated and abort.code not in self.codes:
            missed = SUBSTITUTE if abort.code == AbortCode.GENERAL_ERROR else self.rule
            yield violation(should(missed), self.words(), frame)
        elif abort.code not in self.codes:
            wrong = OTHER_SERVICE if self._is_of_other_service(abort.code) else self.rule
            yield breach(wrong, self.words(), frame)

    def _is_of_other_service(self, code: int) -> bool:
        """Say whether the codes that are right are about reading, and this about writing, or so."""
        reads, writes = frozenset(OF_UPLOADS), frozenset(OF_DOWNLOADS)
        own, other = (writes, reads) if code in reads else (reads, writes)
        right = frozenset(self.codes)
        fits = right.isdisjoint(other) and not right.isdisjoint(own)
        return self.rule is NOT_REFUSED and code in other and fits

    def named(self, *muxes: Multiplexer) -> "DueAbort":
        """Say which object the abort has to name."""
        return replace(self, muxes=muxes)


def refusing(
    refusals: Sequence[DueAbort], before: State, after: State, memory: Memory, *freedoms: Freedom
) -> Due:
    """Build the answer of a server that refuses for one of these reasons, and is in ``after`` then.

    It is one answer to look at: of most requests it is soon clear that they are not refused.
    """
    rule = refusals[0].rule
    # What is merely tolerated is not asked for.
    due = [refusal for refusal in refusals if refusal.codes] or refusals
    words = " or ".join(dict.fromkeys(refusal.words() for refusal in due))
    muxes = [mux for refusal in refusals for mux in refusal.muxes or ()]

    def take(frame: bytes) -> Iterable[Branch]:
        if before.name == BLOCK_UPLOAD and (segment := _segment(frame, muxes)):
            found = Violation(must(rule), expected=words, actual=Received(segment))
            raise Misfit(lambda: found)
        abort = decode_response(frame)
        if not isinstance(abort, Abort):
            raise Misfit(partial(breach, rule, words, frame))
        return [refusal.taken(abort, frame, after, memory, freedoms) for refusal in refusals]

    return Due(rule, words, take)


@cache
def _any_of(codes: Codes) -> str:
    if codes == KNOWN_CODES:
        return "an abort with any code of CiA 301"
    if not codes:
        return "no abort for that reason"
    return "an abort with " + " or ".join(describe_code(code) for code in codes)


def is_segment(frame: bytes, muxes: Iterable[Multiplexer]) -> bool:
    """Say whether a frame within a block upload is a segment, though it might look like others.

    Exactly 80h is an abort, and so is what names one of these objects and the code of an abort.
    """
    looks_like = decode_response(frame)
    if is_refusal(looks_like, *muxes):
        return False
    return isinstance(looks_like, Abort | UploadSegmentResponse) and isinstance(
        decode_segment(frame), BlockSegment
    )


def _segment(frame: bytes, muxes: Iterable[Multiplexer]) -> Response | None:
    return decode_segment(frame) if is_segment(frame, muxes) else None


def violation(rule: Rule, expected: str, frame: bytes) -> Violation:
    """Build a breach of a rule by a response."""
    return Violation(rule, expected=expected, actual=Received(decode_response(frame)))


def breach(rule: Rule, expected: str, frame: bytes) -> Violation:
    """Build a breach of a rule by a response that no choice allows."""
    return violation(must(rule), expected, frame)


def expect(kind: type[Kind], frame: bytes, rule: Rule, words: str) -> Kind:
    """Read a response of one kind; raises Misfit for any other."""
    response = decode_response(frame)
    if not isinstance(response, kind):
        raise Misfit(partial(breach, rule, words, frame))
    return response


def require(holds: bool, rule: Rule, expected: str, frame: bytes) -> None:
    """Raise Misfit where a response of the right kind has a wrong content."""
    if not holds:
        raise Misfit(partial(violation, rule, expected, frame), near=1)


def misread(rule: Rule, mux: Multiplexer, due: bytes, response: Response) -> Misfit:
    """Say that a response has other data than those that are due, or that they begin with."""
    expected = f"{mux} to read as {hex_bytes(due)}"
    wrong = partial(Violation, rule, expected=expected, actual=Misread(response))
    return Misfit(wrong, near=1)


def require_mux(found: Multiplexer, due: Multiplexer, frame: bytes) -> None:
    """Raise Misfit unless a response is about the object that was asked for."""
    require(found == due, MULTIPLEXER, f"multiplexer {due}", frame)


def shape(response: Message, frame: bytes) -> Iterable[Violation]:
    """Yield what is wrong with a response though it can be followed: reserved bits and bytes."""
    for found in response.reserved_fields():
        yield Violation(
            RESERVED, expected="0", actual=Said(f"{found} [{hex_bytes(frame)}]", "reserved fields")
        )


def zero(rule: Rule, rest: bytes, frame: bytes) -> Iterable[Violation]:
    """Yield a breach when bytes without data are not 0."""
    if any(rest):
        yield Violation(rule, expected="00 in bytes without data", actual=filled(rest, frame))


def initiate_shape(
    response: UploadInitiateResponse, frame: bytes, length: int | None
) -> Iterable[Violation]:
    """Yield what is wrong with an upload initiate response though it can be followed.

    ``length`` is that of the object's type, which decides where no count is indicated.
    """
    yield from shape(response, frame)
    if response.unused and not (response.expedited and response.sized):
        yield violation(UNUSED_COUNT, "n = 0", frame)
    if response.expedited:
        count = len(response.data) if response.sized else length
        yield from zero(FILLER, response.payload[count or 4 :], frame)
    elif not response.sized:
        yield from zero(RESERVED, response.payload, frame)


def answered(
    kind: type[Kind], rule: Rule, words: str, before: State, after: Branch, **fields: object
) -> Branch:
    """Build the branch of a server that has to send one message with the fields given."""

    def take(frame: bytes) -> Iterable[Branch]:
        response = expect(kind, frame, rule, words)
        for name, due in fields.items():
            broken = MULTIPLEXER if name == "mux" else must(rule)
            require(getattr(response, name) == due, broken, words, frame)
        return [after.noting(*shape(response, frame))]

    return Branch(before, after.memory, rule, Due(rule, words, take))
