"""Which response answers which request, by specifier and multiplexer."""

from conformance.sdo.frames import (
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
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
    UploadSegment,
    UploadSegmentResponse,
)

ANSWERS: dict[type, type] = {
    UploadInitiate: UploadInitiateResponse,
    UploadSegment: UploadSegmentResponse,
    DownloadInitiate: DownloadInitiateResponse,
    DownloadSegment: DownloadSegmentResponse,
    BlockUploadInitiate: BlockUploadInitiateResponse,
    BlockDownloadInitiate: BlockDownloadInitiateResponse,
    BlockEnd: BlockEndResponse,
}


def is_answer(response: Response, request: Request) -> bool:
    """Say whether a response is a positive answer to a request, by specifier and multiplexer."""
    kind = ANSWERS.get(type(request))
    if kind is None or not isinstance(response, kind):
        return False
    return getattr(response, "mux", None) == getattr(request, "mux", None)


def names_object(request: Request) -> bool:
    """Say whether a request has a multiplexer, which its answer repeats."""
    return getattr(request, "mux", None) is not None
