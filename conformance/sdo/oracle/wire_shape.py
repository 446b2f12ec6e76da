"""What a response is held to as a CAN frame, before its bytes are read."""

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE, RESPONSE_BASE
from conformance.sdo.layout import FRAME_LENGTH, whole_frame
from conformance.sdo.rules import FRAME_SHAPE, Violation


def shaped(frame: bytes | CanFrame, node_id: int | None) -> tuple[bytes, list[Violation]]:
    """Return 8 data bytes, and what is wrong with the frame as a CAN frame.

    Of what is not known of which node it is, the identifier is not judged.
    """
    if isinstance(frame, bytes):
        frame = CanFrame(RESPONSE_BASE + (node_id or 0), frame)
    wrong = []
    if node_id is not None and frame.can_id == REQUEST_BASE + node_id:
        wrong.append("on the identifier of the requests")
    elif node_id is not None and frame.can_id != RESPONSE_BASE + node_id:
        wrong.append(f"identifier {frame.can_id:03X}h")
    if frame.extended:
        wrong.append("a 29-bit identifier")
    if frame.remote:
        wrong.append("a remote frame")
    if frame.dlc != FRAME_LENGTH:
        wrong.append(f"DLC {frame.dlc}")
    data = whole_frame(frame.data)
    if not wrong:
        return data, []
    actual = f"{frame} ({', '.join(wrong)})"
    expected = "a data frame of 8 bytes on the COB-ID of the channel"
    return data, [Violation(FRAME_SHAPE, expected=expected, actual=actual)]
