"""Whether a transfer is open on a channel, by what went over the wire."""

from conformance.sdo.decoding import decode_response, decode_segment
from conformance.sdo.describe import Decoder
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
    Unknown,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import FRAME_LENGTH, Message, Multiplexer

OTHER_INITIATES = UploadInitiateResponse, DownloadInitiateResponse, BlockDownloadInitiateResponse
# What ends a transfer from the side of the client.
ENDING = Abort, BlockEndResponse
# What each request that begins nothing continues, by what has come before it.
CONTINUES: dict[type, tuple[type, ...]] = {
    UploadSegment: (UploadInitiateResponse, UploadSegmentResponse),
    DownloadSegment: (DownloadInitiateResponse, DownloadSegmentResponse),
    BlockUploadStart: (BlockUploadInitiateResponse,),
    BlockAck: (BlockSegment,),
    BlockEndResponse: (BlockEnd,),
    BlockEnd: (BlockAck,),
    Unknown: (),
}
OUT_OF_PLACE = "what is out of place"
# A server may answer them with many segments, whether it has to or not.
ASKS_FOR_SEGMENTS = (BlockUploadStart, BlockAck)


class TransferTracker:
    """Follows requests and responses.

    ``open`` is the object of the running transfer or None, ``latest`` that of the last one.
    ``may_send_segments`` says that a block upload has begun, and no transfer in several frames
    since: a server may send segments of it even after its end. A block download is ``abandoned``
    when the client has aborted it and the server has not sent anything since: what it sent last
    ``asks_for_segments``. One whose initiate was answered by something else is taken for open: the
    server may wait for segments, and would take whatever comes for one but an abort. ``asked`` has
    words for a request that continues no transfer and begins none; they are empty for any other.
    ``misplaced`` are those of them that ask for segments, with whether a transfer was open.
    """

    def __init__(self) -> None:
        """Start with no transfer."""
        self.open: Multiplexer | None = None
        self.latest: Multiplexer | None = None
        self.may_send_segments = False
        self.abandoned = False
        self.asks_for_segments = False
        self.asked = ""
        self.misplaced: set[tuple[type[Request], bool]] = set()
        self._request: Request | None = None
        self._response: Response | None = None
        self._decoder = Decoder()

    def request(self, frame: bytes, built: Message | None = None) -> Request:
        """Take what the client sends; return which request it is.

        ``built`` is the message that the frame was made of, if it was.
        """
        request = self._decoder.request(frame, built)
        self._request = request
        if isinstance(request, BlockSegment):  # thousands, which end nothing, nor are they answered
            self.asked = ""
            return request
        self.asked = OUT_OF_PLACE if self._is_out_of_place(request, frame) else ""
        if self.asked and isinstance(request, ASKS_FOR_SEGMENTS):
            self.misplaced.add((type(request), self.open is not None))
        if isinstance(request, ENDING):
            self.abandoned |= self.asks_for_segments and isinstance(request, Abort)
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
        self._response = response
        if self.open is not None:
            self.latest = self.open
        begins = isinstance(response, BlockUploadInitiateResponse)
        if begins or (self.open is not None and isinstance(response, OTHER_INITIATES)):
            self.may_send_segments = begins
        return self._or_segment(response, frame)

    def read(self, frame: bytes) -> Response:
        """Return which response has arrived, as far as that can be told before it is taken.

        Where segments of a block upload may come, 81h is one, unless what follows it is the object
        and the code of an abort.
        """
        return self._or_segment(decode_response(frame), frame)

    def _or_segment(self, response: Response, frame: bytes) -> Response:
        """Return what came: an abort with reserved bits may be a segment."""
        if not isinstance(response, Abort) or not response.reserved_bits:
            return response
        may_be_segment = self.may_send_segments and not self._decoder.is_answer(response)
        return decode_segment(frame) if may_be_segment else response

    def _is_out_of_place(self, request: Request, frame: bytes) -> bool:
        before = CONTINUES.get(type(request))
        if before is None or len(frame) != FRAME_LENGTH:
            return False
        return self.open is None or not isinstance(self._response, before)

    def _follow(self, response: Response, request: Request | None) -> None:
        match response:
            case Abort() | BlockEndResponse():
                self.open = None
            case _ if isinstance(request, BlockDownloadInitiate):
                self.open = request.mux
            case BlockSegment():
                pass
            case UploadSegmentResponse():
                if response.last:
                    self.open = None
            case DownloadSegmentResponse():
                if isinstance(request, DownloadSegment) and request.last:
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


def _object(request: Request | None) -> Multiplexer | None:
    if isinstance(
        request, UploadInitiate | DownloadInitiate | BlockDownloadInitiate | BlockUploadInitiate
    ):
        return request.mux
    return None
