"""What a node that deviates looks at before any server does: which object a frame asks for."""

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import INITIATES, BlockDownloadInitiate, DownloadInitiate
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer

DOWNLOADS = (DownloadInitiate, BlockDownloadInitiate)


def initiated(frame: CanFrame, kinds: tuple[type, ...] = INITIATES) -> Multiplexer | None:
    """Return the object for which a frame starts a transfer of these kinds, or None."""
    if frame.dlc != FRAME_LENGTH:
        return None
    request = decode_request(frame.data)
    if isinstance(request, INITIATES) and isinstance(request, kinds):
        return request.mux
    return None
