"""Whether a transfer is open on a channel, by what went over the wire."""

from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEndResponse,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegmentResponse,
    decode_response,
)
from conformance.sdo.layout import Multiplexer


class TransferTracker:
    """Follows requests and responses; ``open`` is the object of the running transfer or None,
    ``latest`` that of the last one."""

    def __init__(self) -> None:
        """Start with no transfer."""
        self.open: Multiplexer | None = None
        self.latest: Multiplexer | None = None
        self._request: Request | None = None

    def request(self, request: Request) -> None:
        """Take what the client sent."""
        self._request = request
        if isinstance(request, Abort | BlockEndResponse):
            self.open = None

    def response(self, frame: bytes) -> None:
        """Take what the server sent."""
        request = self._request
        self._follow(frame, request)
        if self.open is not None:
            self.latest = self.open

    def _follow(self, frame: bytes, request: Request | None) -> None:
        match decode_response(frame):
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
