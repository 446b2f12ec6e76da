"""Which cause a breach has.

A cause is a rule and the kind of answer that broke it. A general rule (``response.answered``) is
broken in as many ways as there are requests, so there the kind of request counts as well.
"""

from collections.abc import Sequence

from conformance.dialogue.rule_families import told_once
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockUploadInitiate,
    Request,
    Response,
    Unknown,
    UploadInitiateResponse,
)
from conformance.sdo.kinds import NO_ANSWER, OTHER_DATA, Kind, kind_of_request
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import (
    ABORT_CODE,
    ANSWERED,
    IDLE_AFTERWARDS,
    MULTIPLEXER,
    NO_REBOOT,
    NOT_REFUSED,
    RESERVED,
    SPECIFIER,
    UNSOLICITED,
    Cause,
    Rule,
    Violation,
)
from conformance.sdo.rules.block_upload import ACKNOWLEDGED, NEXT_SUB_BLOCK
from conformance.sdo.rules.defects import ABORT_ANSWERED, GAVE_UP, SWITCHED
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED, BLOCK_UNSUPPORTED
from conformance.sdo.rules.upload_initiates import ABOVE_THRESHOLD, INVALID_BLOCK_SIZE, NO_SWITCH
from conformance.sdo.seen import Received, Seen

# Of a case that has not sent anything itself yet.
NOTHING_SENT = Unknown(b"")
# Broken by an answer of any kind to a request of any kind: the request tells their causes apart.
GENERAL = {
    **dict.fromkeys((ANSWERED.id, SPECIFIER.id, NOT_REFUSED.id, UNSOLICITED.id), "to"),
    **dict.fromkeys((IDLE_AFTERWARDS.id, NO_REBOOT.id), "behind"),
}
TIMED_OUT = Kind("abort", AbortCode.TIMED_OUT)
# Of an abort that breaks these, it does not matter which code it has.
WHATEVER_CODE = frozenset(rule.id for rule in (MULTIPLEXER, UNSOLICITED))
ANY_ABORT = Kind("abort")
NO_ABORT_CODE = Kind("abort with a code that is none")
# Reserved bits and bytes, wherever they are.
NOT_ZERO = Kind("other than 0")
# A transfer that nobody is interested in any more keeps the server from all others.
BLOCKED = "to whatever is asked, until the client aborts"
# Rules about time-outs themselves.
OF_TIME = "time-out."
# By these an ordinary upload is wrong in the place of a block upload.
SWITCHES = frozenset(
    rule.id
    for rule in (NO_SWITCH, ABOVE_THRESHOLD, INVALID_BLOCK_SIZE, BLOCK_UNSUPPORTED, SPECIFIER)
)
# What a sub-block of a block upload has to be.
OF_SUB_BLOCKS = frozenset(rule.id for rule in (NEXT_SUB_BLOCK, ACKNOWLEDGED))


def cause_of(violation: Violation, rule: Rule, request: Request) -> Cause:
    """Return the cause of a breach.

    ``rule`` is the broken one as the registry has it, ``request`` is what was sent last.
    """
    if violation.told_as is not None:
        return violation.told_as
    answer = violation.seen.kind
    # The abort of a client that has waited too long has this code as well, and may be echoed.
    echoed = isinstance(request, Abort) and request.code == AbortCode.TIMED_OUT
    if answer == TIMED_OUT and not echoed and not rule.id.startswith(OF_TIME):
        return GAVE_UP
    # One with reserved bits may be taken for a segment, and be refused.
    aborted = isinstance(request, Abort) and not request.reserved_bits
    behind_abort = aborted and answer != NO_ANSWER and rule.id != NO_REBOOT.id
    if behind_abort or rule.id == ABORT_NOT_ANSWERED.id:
        return ABORT_ANSWERED
    if answer.is_abort and rule.id in WHATEVER_CODE:
        answer = ANY_ABORT
    if answer.is_abort and rule.id == ABORT_CODE.id:
        answer = NO_ABORT_CODE
    if rule.id in SWITCHES and _is_switched(violation.seen, request):
        return SWITCHED
    if answer == NO_ANSWER and rule.id in OF_SUB_BLOCKS and isinstance(request, BlockAck):
        rule = ANSWERED  # it was answered by fewer segments than it asks for, perhaps by none
    asked = ""
    if rule.id in GENERAL and answer != OTHER_DATA and request is not NOTHING_SENT:
        # Wrong data are that, whatever was asked last.
        asked = f"{GENERAL[rule.id]} {violation.asked_as or kind_of_request(request)}"
    elif rule.id == RESERVED.id:
        answer = NOT_ZERO
    rule_id, kind = told_once(rule.id, answer)
    return Cause(rule_id, *kind, asked)


def _is_switched(seen: Seen, request: Request) -> bool:
    """Say whether an ordinary upload has come where a block upload was asked for."""
    response = seen.response if isinstance(seen, Received) else None
    return (
        isinstance(request, BlockUploadInitiate)
        and isinstance(response, UploadInitiateResponse)
        and response.mux == request.mux  # else it answers what was asked before
    )


def blocked(refusals: Sequence[Response], mux: Multiplexer) -> Cause | None:
    """Return the cause where nothing but refusals has come, of ``mux`` too, which can be read."""
    codes = {answer.code for answer in refusals if isinstance(answer, Abort) and answer.mux == mux}
    if len(codes) != 1 or not all(isinstance(answer, Abort) for answer in refusals):
        return None
    return blocked_by(Kind(ANY_ABORT.name, codes.pop()))


def blocked_by(refusal: Kind) -> Cause:
    """Return the cause where each request has the same ``refusal``."""
    return Cause(IDLE_AFTERWARDS.id, *refusal, BLOCKED)
