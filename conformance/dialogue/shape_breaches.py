"""Frames that are no proper response, or none that was asked for, as breaches."""

from collections.abc import Sequence

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import CobId
from conformance.sdo.describe import in_words
from conformance.sdo.frames import Abort, Response
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.rules import FRAME_SHAPE, UNSOLICITED, Violation
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED

MOST_SHOWN = 3


def check_shape(frame: CanFrame, response: CobId) -> None:
    """Raise Violation unless a frame is a data frame of 8 bytes in the format of the channel."""
    wrong = []
    if frame.can_id != response.can_id:
        wrong.append("on the identifier of the requests")
    if frame.extended != response.extended:
        wrong.append(f"{'a 29' if frame.extended else 'an 11'}-bit identifier")
    if frame.remote:
        wrong.append("a remote frame")
    if frame.fd:
        wrong.append("a CAN FD frame")
    if frame.dlc != FRAME_LENGTH:
        wrong.append(f"DLC {frame.dlc}")
    if wrong:
        raise Violation(
            FRAME_SHAPE,
            expected=f"a data frame of 8 bytes on {response} with "
            f"{'a 29' if response.extended else 'an 11'}-bit identifier",
            actual=f"{frame} ({', '.join(wrong)})",
        )


def in_brief(responses: Sequence[Response]) -> str:
    """Describe the first of some responses, and say how many more there are.

    A sub-block that comes late has up to 127.
    """
    shown = [in_words(response) for response in responses[:MOST_SHOWN]]
    more = [f"{len(responses) - MOST_SHOWN} more"] if len(responses) > MOST_SHOWN else []
    return "; ".join([*shown, *more])


def unsolicited(responses: Sequence[Response], expected: str = "no answer") -> Violation:
    """Build the breach that answers came though none, or fewer, had to come."""
    return Violation(UNSOLICITED, expected=expected, actual=in_brief(responses))


def unasked(response: Response, *, aborted: bool) -> Violation:
    """Build the breach that a response came though nothing asked for it.

    ``aborted``: the client had aborted a transfer before.
    """
    answers_abort = aborted and isinstance(response, Abort)
    return Violation(
        ABORT_NOT_ANSWERED if answers_abort else UNSOLICITED,
        expected="no answer to an abort" if answers_abort else "no further answer",
        actual=in_words(response),
    )
