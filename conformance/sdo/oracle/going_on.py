"""A block upload that goes on though its client has asked for something else (7.2.4.3.13 to .15).

What comes then are segments, whatever their first bytes would be elsewhere: 81h is no abort with
reserved bits, unless object and code of one that is due follow.
"""

from collections.abc import Iterable

from conformance.sdo.decoding import decode_response, decode_segment
from conformance.sdo.frames import BlockEnd, BlockSegment, Response
from conformance.sdo.oracle.block_upload import BlockUploadEnd, NotStarted, Unacknowledged
from conformance.sdo.oracle.branch import Branch
from conformance.sdo.oracle.levels import must
from conformance.sdo.rules import Rule, Violation
from conformance.sdo.seen import Received

FIRST = 1
AT_THE_END = "what comes where the end of a block upload is to be confirmed"


def goes_on(branches: Iterable[Branch], frame: bytes) -> Violation | None:
    """Take a response that fits nowhere for the next part of a block upload; None for another."""
    due = [branch for branch in branches if branch.due is not None]
    rule = next((rule for branch in due if (rule := _rule_of(branch))), None)
    if rule is None:
        return None
    segment = decode_segment(frame)
    ended = waits_for_the_end(due)
    if isinstance(segment, BlockSegment) and segment.sequence == FIRST:
        shown: Response = segment
    elif not ended and isinstance(end := decode_response(frame), BlockEnd):
        shown = end
    else:
        return None
    expected = " or ".join(dict.fromkeys(branch.due.words for branch in due if branch.due))
    return Violation(must(rule), expected=expected, actual=Received(shown))


def _rule_of(branch: Branch) -> Rule | None:
    """Return the rule that segments break which come in the place of an answer."""
    match branch.state:
        case NotStarted() | Unacknowledged() as state:
            return state.foreign_rule
        case BlockUploadEnd() if branch.due is not None:
            return branch.due.rule
    return None


def waits_for_the_end(branches: Iterable[Branch]) -> bool:
    """Say whether a block upload waits for the confirmation of its end."""
    return any(isinstance(branch.state, BlockUploadEnd) for branch in branches)
