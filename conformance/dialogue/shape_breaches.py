"""Frames that are no proper response, or none that was asked for, as breaches."""

from collections.abc import Sequence

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import CobId
from conformance.sdo.frames import Abort, Response
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.rules import FRAME_SHAPE, UNSOLICITED, Violation
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED
from conformance.sdo.seen import OddFrame, Received


def check_shape(frame: CanFrame, response: CobId) -> None:
    """Raise Violation unless a frame is a data frame of 8 bytes in the format of the channel."""
    odd: dict[str, str] = {}
    if frame.can_id != response.can_id:
        odd["on the identifier of the requests"] = "on the identifier of the requests"
    if frame.extended != response.extended:
        article, bits = ("a", 29) if frame.extended else ("an", 11)
        odd[f"{article} …-bit identifier"] = f"{article} {bits}-bit identifier"
    if frame.remote:
        odd["a remote frame"] = "a remote frame"
    if frame.fd:
        odd["a CAN FD frame"] = "a CAN FD frame"
    if frame.dlc != FRAME_LENGTH:
        odd["another length than 8"] = f"DLC {frame.dlc}"
    if odd:
        raise Violation(
            FRAME_SHAPE,
            expected=f"a data frame of 8 bytes on {response} with "
            f"{'a 29' if response.extended else 'an 11'}-bit identifier",
            actual=OddFrame(frame, odd),
        )


def unsolicited(responses: Sequence[Response], expected: str = "no answer") -> Violation:
    """Build the breach that answers came though none, or fewer, had to come."""
    return Violation(UNSOLICITED, expected=expected, actual=Received(responses[0], responses[1:]))


def unasked(response: Response, *, aborted: bool) -> Violation:
    """Build the breach that a response came though nothing asked for it.

    ``aborted``: the client had aborted a transfer before.
    """
    answers_abort = aborted and isinstance(response, Abort)
    return Violation(
        ABORT_NOT_ANSWERED if answers_abort else UNSOLICITED,
        expected="no answer to an abort" if answers_abort else "no further answer",
        actual=Received(response),
    )
