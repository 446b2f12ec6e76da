"""Reads before there is a dialogue: nothing but the first answer of them is taken."""

from conformance.bus.channel import Channel
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import UploadInitiateResponse
from conformance.sdo.layout import Multiplexer


def end_read(channel: Channel, frame: CanFrame, mux: Multiplexer) -> None:
    """Abort the upload that a response begins, if segments of it would follow.

    In the middle of it a server may refuse the next read.
    """
    response = decode_response(frame.data)
    if isinstance(response, UploadInitiateResponse) and not response.expedited:
        channel.abort(mux, AbortCode.GENERAL_ERROR)
