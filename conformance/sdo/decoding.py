"""Which message a frame is: that follows from its byte 0 and its direction, with one exception.

The segments of a block transfer use all of byte 0 for their sequence number, so only the state of
the transfer tells them from the others. Hence three decoders. Each takes any bytes; what no clause
of CiA 301 defines becomes ``Unknown``.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TypeGuard, TypeVar

from conformance.sdo.abort_codes import AbortCode
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
    RequestMessage,
    Response,
    ResponseMessage,
    Unknown,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import FRAME_LENGTH, Message, Multiplexer

CODES = frozenset(AbortCode)
# So many messages of a kind need not be read again.
LATEST = 256
Kind = TypeVar("Kind", bound=Message)

REQUESTS: tuple[type[RequestMessage], ...] = (
    DownloadSegment,
    DownloadInitiate,
    UploadInitiate,
    UploadSegment,
    Abort,
    BlockDownloadInitiate,
    BlockEnd,
    BlockUploadInitiate,
    BlockUploadStart,
    BlockAck,
    BlockEndResponse,
)
RESPONSES: tuple[type[ResponseMessage], ...] = (
    UploadSegmentResponse,
    DownloadSegmentResponse,
    UploadInitiateResponse,
    DownloadInitiateResponse,
    Abort,
    BlockDownloadInitiateResponse,
    BlockAck,
    BlockEndResponse,
    BlockUploadInitiateResponse,
    BlockEnd,
)


def _by_command(kinds: Sequence[type[Kind]]) -> tuple[Callable[[bytes], Kind] | None, ...]:
    """Return, for each value of byte 0, what reads such a message."""
    # Whoever follows a conversation reads its frames, and most frames come more than once.
    readers = [(kind, lru_cache(LATEST)(kind.decode)) for kind in kinds]
    return tuple(
        next((read for kind, read in readers if kind.matches(command)), None)
        for command in range(256)
    )


def _with_object(kinds: Sequence[type[Kind]]) -> frozenset[bytes]:
    """Return the values of byte 0 of messages that name an object."""
    return frozenset(
        bytes((command,))
        for command in range(256)
        for kind in kinds
        if kind.matches(command) and "mux" in kind.LAYOUT.body
    )


_REQUEST_BY_COMMAND = _by_command(REQUESTS)
_RESPONSE_BY_COMMAND = _by_command(RESPONSES)
_PLAIN_REQUESTS = frozenset(REQUESTS)
_REQUEST_WITH_OBJECT = _with_object(REQUESTS)
_ABORT = b"\x80"
# The positive answers to each request.
ANSWERS: dict[type, tuple[type, ...]] = {
    UploadInitiate: (UploadInitiateResponse,),
    UploadSegment: (UploadSegmentResponse,),
    DownloadInitiate: (DownloadInitiateResponse,),
    DownloadSegment: (DownloadSegmentResponse,),
    BlockUploadInitiate: (BlockUploadInitiateResponse, UploadInitiateResponse),
    BlockDownloadInitiate: (BlockDownloadInitiateResponse,),
    BlockSegment: (BlockAck,),
    BlockAck: (BlockEnd,),
    BlockEnd: (BlockEndResponse,),
}


def decode_request(frame: bytes) -> Request:
    """Read what a client sent outside a sub-block of a block download."""
    decode = _REQUEST_BY_COMMAND[frame[0]] if len(frame) == FRAME_LENGTH else None
    return decode(frame) if decode else Unknown(bytes(frame))


def decode_response(frame: bytes) -> Response:
    """Read what a server sent outside a sub-block of a block upload."""
    decode = _RESPONSE_BY_COMMAND[frame[0]] if len(frame) == FRAME_LENGTH else None
    return decode(frame) if decode else Unknown(bytes(frame))


def is_plain(message: Message | None) -> TypeGuard[RequestMessage]:
    """Say whether the bytes of a message are read as it, sent outside a sub-block."""
    return type(message) in _PLAIN_REQUESTS


def has_object(frame: bytes) -> bool:
    """Say whether a request of these bytes names an object."""
    return frame[:1] in _REQUEST_WITH_OBJECT


def is_abort(frame: bytes) -> bool:
    """Say whether a frame is an abort by its byte 0, in either direction and in any state."""
    return frame[:1] == _ABORT


def is_answer(response: Response, request: Request) -> bool:
    """Say whether a response is a positive answer to a request, by specifier and multiplexer."""
    if not isinstance(response, ANSWERS.get(type(request), ())):
        return False
    return getattr(response, "mux", None) == getattr(request, "mux", None)


def decode_segment(frame: bytes) -> BlockSegment | Abort | Unknown:
    """Read what the sender of a block transfer sent where segments are due.

    Exactly 80h is an abort: as a segment it would have the sequence number 0, which is not one.
    """
    if len(frame) != FRAME_LENGTH:
        return Unknown(bytes(frame))
    return Abort.decode(frame) if is_abort(frame) else BlockSegment.decode(frame)


def as_answer(response: Response) -> Response:
    """Return what a response is where no segment of a block is due, whatever it was read as."""
    if isinstance(response, BlockSegment):
        return decode_response(response.encode())
    return response


def as_segment(response: Response, mux: Multiplexer) -> BlockSegment | Abort | Unknown:
    """Return what a response is where a segment of a block is due, whatever it was read as.

    ``mux`` is the object that is uploaded.
    """
    if isinstance(response, BlockSegment) and not response.last:
        return response  # an abort has this bit set
    answer = as_answer(response)
    if isinstance(answer, Abort) and is_refusal(answer, mux):
        return answer
    return response if isinstance(response, BlockSegment) else decode_segment(response.encode())


def is_refusal(message: Message | Unknown, *muxes: Multiplexer | None) -> bool:
    """Say whether this is an abort of one of these objects, also where its reserved bits are set.

    The data of a segment are hardly ever an object and the code of a refusal.
    """
    return isinstance(message, Abort) and message.code in CODES and message.mux in muxes
