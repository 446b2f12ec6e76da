"""Whether a transfer is open on a channel, by what went over the wire."""

from conformance.sdo.decoding import decode_response, decode_segment
from conformance.sdo.describe import Decoder
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer

OTHER_INITIATES = UploadInitiateResponse | DownloadInitiateResponse | BlockDownloadInitiateResponse


class TransferTracker:
    """Follows requests and responses.

    ``open`` is the object of the running transfer or None, ``latest`` that of the last one.
    ``may_send_segments`` says that a block upload has begun, and no transfer in several frames
    since: a server may send segments of it even after its end. A block download is ``abandoned``
    when the client has aborted it and the server has not sent anything since: what it sent last
    ``asks_for_segments``.
    """

    def __init__(self) -> None:
        """Start with no transfer."""
        self.open: Multiplexer | None = None
        self.latest: Multiplexer | None = None
        self.may_send_segments = False
        self.abandoned = False
        self.asks_for_segments = False
        self._request: Request | None = None
        self._decoder = Decoder()

    def request(self, frame: bytes) -> Request:
        """Take what the client sends; return which request it is."""
        request = self._decoder.request(frame)
        self._request = request
        self.abandoned |= self.asks_for_segments and isinstance(request, Abort)
        if isinstance(request, Abort | BlockEndResponse):
            self.open = None
        return request

    def response(self, frame: bytes) -> Response:
        """Take what the server sent; return which response it is, by the state in which it came.

        A segment of a block uses all of byte 0, and looks like any other response.
        """
        response = self._decoder.response(frame)
        self.abandoned = False
        self.asks_for_segments = isinstance(response, BlockDownloadInitiateResponse | BlockAck)
        self._follow(response, self._request)
        if self.open is not None:
            self.latest = self.open
        begins = isinstance(response, BlockUploadInitiateResponse)
        if begins or (self.open is not None and isinstance(response, OTHER_INITIATES)):
            self.may_send_segments = begins
        return response if isinstance(response, BlockSegment) else self.read(frame)

    def read(self, frame: bytes) -> Response:
        """Return which response has arrived, as far as that can be told before it is taken.

        Where segments of a block upload may come, exactly 80h is an abort, and 81h a segment.
        """
        response = decode_response(frame)
        if not isinstance(response, Abort) or not response.reserved_bits:
            return response
        may_be_segment = self.may_send_segments and not self._decoder.is_answer(response)
        return decode_segment(frame) if may_be_segment else response

    def _follow(self, response: Response, request: Request | None) -> None:
        match response:
            case Abort():
                self.open = None
            case DownloadInitiateResponse():
                segmented = isinstance(request, DownloadInitiate) and not request.expedited
                self.open = _object(request) if segmented else None
            case UploadInitiateResponse(expedited=True):
                self.open = None
            case (
                UploadInitiateResponse()
                | BlockDownloadInitiateResponse()
                | BlockUploadInitiateResponse()
            ):
                self.open = _object(request)
            case DownloadSegmentResponse():
                if isinstance(request, DownloadSegment) and request.last:
                    self.open = None
            case UploadSegmentResponse(last=True) | BlockEndResponse():
                self.open = None


def _object(request: Request | None) -> Multiplexer | None:
    if isinstance(
        request, UploadInitiate | DownloadInitiate | BlockDownloadInitiate | BlockUploadInitiate
    ):
        return request.mux
    return None
