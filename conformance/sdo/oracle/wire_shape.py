"""What a response is held to as a CAN frame, before its bytes are read."""

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE, RESPONSE_BASE
from conformance.sdo.layout import FRAME_LENGTH, whole_frame
from conformance.sdo.rules import FRAME_SHAPE, Violation
from conformance.sdo.seen import OddFrame


def shaped(frame: bytes | CanFrame, node_id: int | None) -> tuple[bytes, list[Violation]]:
    """Return 8 data bytes, and what is wrong with the frame as a CAN frame.

    Of what is not known of which node it is, the identifier is not judged.
    """
    if isinstance(frame, bytes):
        frame = CanFrame(RESPONSE_BASE + (node_id or 0), frame)
    odd: dict[str, str] = {}
    if node_id is not None and frame.can_id == REQUEST_BASE + node_id:
        odd["on the identifier of the requests"] = "on the identifier of the requests"
    elif node_id is not None and frame.can_id != RESPONSE_BASE + node_id:
        odd["identifier …"] = f"identifier {frame.can_id:03X}h"
    if frame.extended:
        odd["a …-bit identifier"] = "a 29-bit identifier"
    if frame.remote:
        odd["a remote frame"] = "a remote frame"
    if frame.dlc != FRAME_LENGTH:
        odd["another length than 8"] = f"DLC {frame.dlc}"
    data = whole_frame(frame.data)
    if not odd:
        return data, []
    expected = "a data frame of 8 bytes on the COB-ID of the channel"
    return data, [Violation(FRAME_SHAPE, expected=expected, actual=OddFrame(frame, odd))]
