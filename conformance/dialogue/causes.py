"""Causes: what is wrong with a device, each told once however many cases meet it.

A cause is a rule and the kind of answer that broke it. A general rule (``response.answered``) is
broken in as many ways as there are requests, so there the kind says as well what was asked. A
cause that cases have met outside their own points *stands*: the suite knows it from then on, and
steps round it or says that it is in the way.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from conformance.dialogue.rule_families import NO_ANSWER, told_once
from conformance.sdo.abort_codes import APPLICATION_STATE, AbortCode
from conformance.sdo.describe import describe
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEndResponse,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    Request,
    Response,
    Unknown,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH
from conformance.sdo.rules import (
    ABORT_CODE,
    ANSWERED,
    BLOCK_SIZE,
    FRAME_SHAPE,
    IDLE_AFTERWARDS,
    MULTIPLEXER,
    NO_REBOOT,
    NOT_REFUSED,
    RESERVED,
    SPECIFIER,
    UNSOLICITED,
    Rule,
    Violation,
)
from conformance.sdo.rules.block_upload import ACKNOWLEDGED, ENDS, NEXT_SUB_BLOCK
from conformance.sdo.rules.channels import NMT_INITIALISING
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED, BLOCK_UNSUPPORTED
from conformance.sdo.rules.upload_initiates import (
    ABOVE_THRESHOLD,
    INVALID_BLOCK_SIZE,
    NO_SWITCH,
)

BOOTED_AS_HEARTBEAT = (NMT_INITIALISING.id, "a boot-up message with 7Fh instead of 00h")
# Of a case that has not sent anything itself yet.
NOTHING_SENT = Unknown(b"")
# Broken by an answer of any kind to a request of any kind: the request tells their causes apart.
GENERAL = {
    **dict.fromkeys((ANSWERED.id, SPECIFIER.id, NOT_REFUSED.id, UNSOLICITED.id), "to"),
    **dict.fromkeys((IDLE_AFTERWARDS.id, NO_REBOOT.id), "behind"),
}
# Within a sub-block a frame is a segment, but for an abort: a server that overlooks that is gone.
DEAF = (IDLE_AFTERWARDS.id, "deaf behind a block download that was aborted")
IS_BEHIND = (ANSWERED.id, "answers are one request behind")
FIRST_TWICE = (UNSOLICITED.id, "the first answers of a run come twice")
ANSWERS_TWICE = (UNSOLICITED.id, "every answer comes twice")
BEHIND_BLOCK_UPLOAD = " to block end response"
TIMED_OUT = f"abort {AbortCode.TIMED_OUT:08X}h"
# Of an abort that breaks these, it does not matter which code it has.
WHATEVER_CODE = frozenset(rule.id for rule in (MULTIPLEXER, UNSOLICITED))
OTHER_DATA = "other data"
# Reserved bits and bytes, wherever they are.
NOT_ZERO = "other than 0"
# A transfer that nobody is interested in any more keeps the server from all others.
BLOCKED = "to whatever is asked, until the client aborts"
# Behind that a wrong value says no more.
NOT_STORED = (NOT_REFUSED.id, "a download that is confirmed and not stored")
NUMBER_NOT_STORED = (NOT_REFUSED.id, "a download to a number that is confirmed and not stored")
EXPEDITED_NOT_STORED = (NOT_REFUSED.id, "an expedited download that is confirmed and not stored")
CONFIRMED = ("download initiate response", "download segment response")
# The application refuses, whatever is asked.
OF_STATE = tuple(f"abort {code:08X}h" for code in APPLICATION_STATE)
DOWNLOAD = "download initiate"
DOWNLOADS = (DownloadInitiate, BlockDownloadInitiate)
# Rules about time-outs themselves.
OF_TIME = "time-out."
MOST_WORDS = 60
# Where values read wrong under that many rules, no further one says what is wrong.
MANY_RULES = 3
BLOCK_UPLOAD = "block-upload."
# What a sub-block of a block upload has to be.
OF_SUB_BLOCKS = frozenset(rule.id for rule in (NEXT_SUB_BLOCK, ACKNOWLEDGED))
IN_BLOCK_UPLOAD = (BlockUploadStart, BlockAck, BlockEndResponse)

_BYTES = re.compile(r" ?\[[^]]*\]")
_MULTIPLEXER = re.compile(r" ?\b[0-9A-F]{4}h:[0-9A-F]{2}\b")
_NUMBER = re.compile(r"\b(?:[0-9A-F]{2}(?: [0-9A-F]{2})+|[0-9A-F]+h|0x[0-9A-Fa-f]+|\d[\d.,]*)\b")
_ABORT = re.compile(r"^abort\b.*?\b([0-9A-F]{8}h)")
_MESSAGE = re.compile(
    r"^(?:block (?:download|upload) initiate response|(?:download|upload) (?:initiate|segment)"
    r" response|block segment|block acknowledgement|block end response|block end"
    r"|command specifier)\b"
)
_DATA = re.compile(r"^\d+ bytes?: |\breads\b")
_ODD_FRAME = re.compile(r"^[0-9A-F]+#\S* \((.*)\)")
_SILENCE = ("nothing", NO_ANSWER, "none within")
_SORTS = ("expedited", "segmented", "size not indicated")


@dataclass(frozen=True, slots=True, order=True)
class Cause:
    """A rule, by its id, and in words the kind of answer that broke it."""

    rule_id: str
    answer: str

    def __str__(self) -> str:
        return f"{self.rule_id}: {self.answer}"


# A block upload is answered with an ordinary one, where its client has not allowed that.
SWITCHED = Cause(NO_SWITCH.id, "upload initiate response")
SWITCHES = frozenset(
    (rule.id, SWITCHED.answer)
    for rule in (NO_SWITCH, ABOVE_THRESHOLD, INVALID_BLOCK_SIZE, BLOCK_UNSUPPORTED, SPECIFIER)
)
# A sub-index that an object lacks is served, FFh among others.
SERVED = Cause("object.sub-index-missing", "served")
IN_BLOCKS = Cause("block-upload.first-sub-block", OTHER_DATA)
BEHIND_LAST = Cause(ENDS.id, "block segment")
SEGMENT_INSTEAD = frozenset((SPECIFIER.id, IN_BLOCKS.rule_id))
VALUES_WRONG = Cause(NOT_REFUSED.id, "values that do not read as they were written")
STRUCTURE = Cause("dictionary.structure", OTHER_DATA)
EXCEEDED = tuple(Cause(rule.id, "block segment") for rule in (BLOCK_SIZE, ENDS))


def kind_of_answer(actual: str) -> str:
    """Return what kind of answer a breach describes: no numbers, no objects, no data.

    >>> kind_of_answer("abort 1018h:01, 05040001h (command specifier not valid) [80 18 10 01]")
    'abort 05040001h'
    """
    first = _BYTES.sub("", actual.partition("; ")[0]).strip()
    if not first or first.startswith(_SILENCE):
        return NO_ANSWER
    if abort := _ABORT.match(first):
        return f"abort {abort[1]}"
    if message := _MESSAGE.match(first):
        return message[0]
    if _DATA.search(first):
        return OTHER_DATA
    if odd := _ODD_FRAME.match(first):
        first = odd[1]
    return _NUMBER.sub("…", _MULTIPLEXER.sub("", first).lstrip()).splitlines()[0][:MOST_WORDS]


def kind_of_request(request: Request) -> str:
    """Return which request it is, without object, numbers and data.

    >>> kind_of_request(DownloadInitiate.with_size(Multiplexer(0x2010), 20))
    'download initiate, segmented'
    """
    expedited = isinstance(request, DownloadInitiate) and request.expedited
    unsized = isinstance(request, DownloadInitiate | BlockDownloadInitiate) and not request.sized
    if unsized and not expedited:
        return "download initiate, size not indicated"
    name, *details = _MULTIPLEXER.sub("", describe(request)).split(", ")
    kind = ", ".join([name, *(sort for sort in _SORTS if sort in details)])
    # Reserved bits and bytes, and those of the data, make no other request of it.
    return _NUMBER.sub("…", kind.partition(";")[0].partition(":")[0])


def _without_request(cause: Cause) -> str:
    return cause.answer.partition(f" {GENERAL[cause.rule_id]} ")[0]


def cause_of(violation: Violation, rule: Rule, request: Request) -> Cause:
    """Return the cause of a breach.

    ``rule`` is the broken one as the registry has it, ``request`` is what was sent last.
    """
    if violation.habit is not None:
        return Cause(*violation.habit)
    answer = kind_of_answer(violation.actual)
    # The abort of a client that has waited too long has this code as well, and may be echoed.
    echoed = isinstance(request, Abort) and request.code == AbortCode.TIMED_OUT
    if answer == TIMED_OUT and not echoed and not rule.id.startswith(OF_TIME):
        return Cause(UNSOLICITED.id, f"{TIMED_OUT} though no transfer is due to end")
    # One with reserved bits may be taken for a segment, and be refused.
    aborted = isinstance(request, Abort) and not request.reserved_bits
    behind_abort = aborted and answer != NO_ANSWER and rule.id != NO_REBOOT.id
    if behind_abort or rule.id == ABORT_NOT_ANSWERED.id:
        return Cause(ABORT_NOT_ANSWERED.id, "an answer")
    if rule.id in WHATEVER_CODE and answer.startswith("abort "):
        answer = "abort"
    if rule.id == ABORT_CODE.id and answer.startswith("abort "):
        answer = "abort with a code that is none"
    if (
        isinstance(request, BlockUploadInitiate)
        and (rule.id, answer) in SWITCHES
        and str(request.mux) in violation.actual  # else it answers what was asked before
    ):
        return SWITCHED
    if answer == NO_ANSWER and rule.id in OF_SUB_BLOCKS and isinstance(request, BlockAck):
        rule = ANSWERED  # it was answered by fewer segments than it asks for, perhaps by none
    if rule.id in GENERAL and answer == OTHER_DATA:
        pass  # wrong data are that, whatever was asked last
    elif rule.id in GENERAL and request != NOTHING_SENT:
        asked = violation.asked or kind_of_request(request)
        answer = f"{answer} {GENERAL[rule.id]} {asked}"
    elif rule.id == RESERVED.id:
        answer = NOT_ZERO
    elif rule.id == FRAME_SHAPE.id:
        answer = answer.replace("DLC …", "another length than 8")
    return Cause(*told_once(rule.id, answer))


@dataclass(slots=True)
class Standing:
    """A cause that was seen: the case that met it first, and what was wrong there.

    ``aside`` says that no case has failed for it: it was met outside the cases.
    """

    first_case: str
    violation: Violation
    aside: bool = False
    shown_by: set[str] = field(default_factory=set)


def blocked(refusals: Sequence[Response], mux: Multiplexer) -> tuple[str, str] | None:
    """Return the cause where nothing but refusals has come, of ``mux`` too, which can be read."""
    codes = {answer.code for answer in refusals if isinstance(answer, Abort) and answer.mux == mux}
    if len(codes) != 1 or not all(isinstance(answer, Abort) for answer in refusals):
        return None
    return IDLE_AFTERWARDS.id, f"abort {codes.pop():08X}h {BLOCKED}"


class Causes:
    """What is known to be wrong with one device.

    Whatever is met comes ``of_one`` cause where that is known.
    """

    def __init__(self) -> None:
        """Nothing is known to be wrong yet."""
        self._standing: dict[Cause, Standing] = {}
        self.of_one: Cause | None = None

    def __iter__(self) -> Iterator[tuple[Cause, Standing]]:
        """Yield all causes, in the order in which they were met."""
        yield from self._standing.items()

    def get(self, cause: Cause) -> Standing | None:
        """Return what is known of a cause; None for a new one."""
        return self._standing.get(cause)

    def state(self) -> dict[Cause, Standing]:
        """Return what is known now, to come back to."""
        return {
            cause: replace(standing, shown_by=set(standing.shown_by)) for cause, standing in self
        }

    def return_to(self, state: dict[Cause, Standing]) -> None:
        """Know what was known then, and no more."""
        self._standing = state

    def of(self, violation: Violation, rule: Rule, request: Request) -> Cause:
        """Return the cause of a breach, see ``cause_of``.

        A device that sends segments behind the last one sends them in the place of any answer.
        """
        cause = self.of_one or cause_of(violation, rule, request)
        segment = cause.answer.startswith(BEHIND_LAST.answer) and rule.id in SEGMENT_INSTEAD
        return BEHIND_LAST if segment and BEHIND_LAST in self._standing else cause

    def told_as(self, cause: Cause, request: Request, point: str, *, generated: bool) -> Cause:
        """Return the cause that is known already and the same as one that was met.

        A refusal of the same kind of request with the same code is one, whatever rule is named for
        it. In one state of a matrix a kind of answer is told once, whatever was asked: ``point`` is
        the rule of that state where the case was ``generated``.
        """
        if cause in self._standing:
            return cause
        return (
            self._of_a_stub(cause)
            or self._other_data(cause, request)
            or self._answer_to_the_end(cause, request)
            or self._refusal(cause, request)
            or (self._in_one_state(cause, point) if generated else None)
            or cause
        )

    def _of_a_stub(self, cause: Cause) -> Cause | None:
        """Return by what a device that serves or confirms everything is told."""
        if cause == STRUCTURE and SERVED in self._standing:
            return SERVED  # FFh is but one of those that are served
        if self.nothing_is_stored and cause.answer in CONFIRMED:
            return Cause(*NOT_STORED)
        return None

    def _other_data(self, cause: Cause, request: Request) -> Cause | None:
        """Return by what wrong data are told: those of a block upload, or met in many places."""
        if cause.answer != OTHER_DATA:
            return None
        of_blocks = isinstance(request, IN_BLOCK_UPLOAD) or cause.rule_id.startswith(BLOCK_UPLOAD)
        if of_blocks and IN_BLOCKS in self._standing:
            return IN_BLOCKS
        known = [one for one in self._standing if one.answer == OTHER_DATA]
        if len(known) < MANY_RULES:
            return None
        return next((one for one in known if one.rule_id in GENERAL), VALUES_WRONG)

    def _answer_to_the_end(self, cause: Cause, request: Request) -> Cause | None:
        """Return by what an answer to the end of a block upload is told, wherever that is sent."""
        if isinstance(request, BlockEndResponse):
            for known in self._standing:
                answer, behind, _ = known.answer.partition(BEHIND_BLOCK_UPLOAD)
                if known.rule_id == UNSOLICITED.id and behind and cause.answer.startswith(answer):
                    return known
        return None

    def _refusal(self, cause: Cause, request: Request) -> Cause | None:
        """Return by what a refusal is told that is known from another place.

        That a device writes nothing in its state it may say to downloads of each kind.
        """
        general = cause.rule_id in GENERAL
        answer = _without_request(cause) if general else cause.answer
        blocked = Cause(IDLE_AFTERWARDS.id, f"{answer} {BLOCKED}")
        if blocked in self._standing:
            return blocked
        if answer in OF_STATE and isinstance(request, DOWNLOADS):
            for known in self._standing:
                refused, _, asked = known.answer.partition(" to ")
                if (known.rule_id, refused) == (NOT_REFUSED.id, answer) and DOWNLOAD in asked:
                    return known
        known = Cause(NOT_REFUSED.id, f"{cause.answer} to {kind_of_request(request)}")
        return known if cause.answer.startswith("abort ") and known in self._standing else None

    def _in_one_state(self, cause: Cause, point: str) -> Cause | None:
        """Return by what an answer of this kind is told that another field of a state has met."""
        if cause.rule_id in GENERAL:
            for known, standing in self:
                alike = known.rule_id == cause.rule_id and point in standing.shown_by
                if alike and _without_request(known) == _without_request(cause):
                    return known
        return None

    def add(self, cause: Cause, case_id: str, violation: Violation, *, aside: bool) -> Standing:
        """Take note that a cause was met: ``aside`` of all cases, or by one that fails for it."""
        standing = self._standing.setdefault(cause, Standing(case_id, violation, aside))
        if standing.aside and not aside:
            standing.first_case, standing.violation, standing.aside = case_id, violation, False
        return standing

    def aside(self) -> list[tuple[Cause, Standing]]:
        """Return what no case has failed for: it was met outside the cases."""
        return [(cause, standing) for cause, standing in self if standing.aside]

    @property
    def aborts_are_answered(self) -> bool:
        """Whether the device was seen to answer an abort of its client."""
        return any(cause.rule_id == ABORT_NOT_ANSWERED.id for cause in self._standing)

    @property
    def nothing_is_stored(self) -> bool:
        """Whether the device was seen to confirm a download and to keep what it held."""
        return Cause(*NOT_STORED) in self._standing

    def unstored(self, *, number: bool, size: int) -> tuple[str, str] | None:
        """Return how it is told that the device stores no value like this, if that was seen."""
        if self.nothing_is_stored:
            return NOT_STORED
        if number and Cause(*NUMBER_NOT_STORED) in self._standing:
            return NUMBER_NOT_STORED
        expedited = 0 < size <= EXPEDITED_LENGTH and Cause(*EXPEDITED_NOT_STORED) in self._standing
        return EXPEDITED_NOT_STORED if expedited else None

    @property
    def sub_blocks_are_exceeded(self) -> bool:
        """Whether the device was seen to send more segments in a sub-block than it has."""
        return any(cause in self._standing for cause in EXCEEDED)

    @property
    def boots_up_as_heartbeat(self) -> bool:
        """Whether the device was seen to send a heartbeat in the place of a boot-up message."""
        return Cause(*BOOTED_AS_HEARTBEAT) in self._standing

    @property
    def noisy(self) -> bool:
        """Whether the device was seen to send unsolicited responses."""
        unasked = (ABORT_NOT_ANSWERED.id, UNSOLICITED.id)
        return any(cause.rule_id in unasked for cause in self._standing)
