"""SDO messages in words, for failures and traces; and what each frame of a conversation is."""

from collections.abc import Callable
from functools import cache, singledispatch

from conformance.sdo.abort_codes import describe_code
from conformance.sdo.decoding import (
    decode_request,
    decode_response,
    decode_segment,
    is_plain,
    is_refusal,
)
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
    RemoteFrame,
    Request,
    Response,
    Unknown,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import FRAME_LENGTH, Message, Multiplexer

# What a positive answer to a request is.
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


def hex_bytes(data: bytes) -> str:
    """Write bytes as the field does: ``40 18 10 01``; ``no data`` for none."""
    return data.hex(" ").upper() or "no data"


def shown(data: bytes) -> str:
    """Write a value with its length; of a long one the beginning and the end."""
    if len(data) <= 32:
        return f"{len(data)} bytes: {hex_bytes(data)}"
    return f"{len(data)} bytes: {hex_bytes(data[:16])} … {hex_bytes(data[-8:])}"


def describe(message: Message | Unknown) -> str:
    """Return one line of words for a message, reserved bits that are set included."""
    words = _describing(type(message))(message)
    reserved = message.reserved_fields() if isinstance(message, Message) else []
    return "; ".join([words, *reserved]) if reserved else words


def _bytes(count: int) -> str:
    return "1 byte" if count == 1 else f"{count} bytes"


def in_words(message: Message | Unknown) -> str:
    """Return a message in words, with its bytes."""
    return f"{describe(message)} [{hex_bytes(message.encode())}]"


@singledispatch
def _words(message: Message | Unknown) -> str:
    raise TypeError(f"not an SDO message: {message!r}")


@_words.register
def _(message: DownloadInitiate) -> str:
    return f"download initiate {message.mux}, {_initiate(message)}"


@_words.register
def _(message: DownloadInitiateResponse) -> str:
    return f"download initiate response {message.mux}"


@_words.register
def _(message: UploadInitiate) -> str:
    return f"upload initiate {message.mux}"


@_words.register
def _(message: UploadInitiateResponse) -> str:
    return f"upload initiate response {message.mux}, {_initiate(message)}"


def _initiate(message: DownloadInitiate | UploadInitiateResponse) -> str:
    unused = f", n={message.unused}" if message.unused else ""
    if message.expedited:
        count = _bytes(4 - message.unused) if message.sized else f"size not indicated{unused}"
        return f"expedited, {count}: {hex_bytes(message.data)}"
    size = "size not indicated" if message.size is None else _bytes(message.size)
    return f"segmented, {size}{unused}"


@_words.register
def _(message: DownloadSegment) -> str:
    return f"download segment, {_segment(message)}"


@_words.register
def _(message: UploadSegmentResponse) -> str:
    return f"upload segment response, {_segment(message)}"


def _segment(message: DownloadSegment | UploadSegmentResponse) -> str:
    last = ", last" if message.last else ""
    return f"t={message.toggle}{last}, {_bytes(len(message.data))}: {hex_bytes(message.data)}"


@_words.register
def _(message: DownloadSegmentResponse) -> str:
    return f"download segment response, t={message.toggle}"


@_words.register
def _(message: UploadSegment) -> str:
    return f"upload segment request, t={message.toggle}"


@_words.register
def _(message: Abort) -> str:
    return f"abort {message.mux}, {describe_code(message.code)}"


@_words.register
def _(message: BlockDownloadInitiate) -> str:
    return f"block download initiate {message.mux}, {_block_initiate(message)}"


@_words.register
def _(message: BlockUploadInitiateResponse) -> str:
    return f"block upload initiate response {message.mux}, {_block_initiate(message)}"


def _block_initiate(message: BlockDownloadInitiate | BlockUploadInitiateResponse) -> str:
    size = "size not indicated" if message.size is None else _bytes(message.size)
    return f"{size}, {_crc_support(message.crc_supported)}"


def _crc_support(supported: bool) -> str:
    return "with CRC" if supported else "without CRC"


@_words.register
def _(message: BlockDownloadInitiateResponse) -> str:
    crc = _crc_support(message.crc_supported)
    return f"block download initiate response {message.mux}, blksize {message.block_size}, {crc}"


@_words.register
def _(message: BlockUploadInitiate) -> str:
    crc = _crc_support(message.crc_supported)
    size = f"blksize {message.block_size}, pst {message.threshold}"
    return f"block upload initiate {message.mux}, {size}, {crc}"


@_words.register
def _(message: BlockSegment) -> str:
    last = ", last" if message.last else ""
    return f"block segment {message.sequence}{last}: {hex_bytes(message.payload)}"


@_words.register
def _(message: BlockAck) -> str:
    return f"block acknowledgement, ackseq {message.sequence}, blksize {message.block_size}"


@_words.register
def _(message: BlockEnd) -> str:
    return f"block end, n={message.unused}, CRC {message.crc:04X}h"


@_words.register
def _(message: BlockEndResponse) -> str:
    return "block end response"


@_words.register
def _(message: BlockUploadStart) -> str:
    return "block upload start"


@_words.register
def _(message: Unknown) -> str:
    if len(message.frame) != FRAME_LENGTH:
        return f"{_bytes(len(message.frame))} instead of 8: {hex_bytes(message.frame)}"
    return f"command specifier {message.frame[0]:02X}h, which is not defined"


@_words.register
def _(message: RemoteFrame) -> str:
    return f"remote frame, DLC {message.dlc}"


# A look into this cache takes a third of what singledispatch takes to find a kind.
_describing: Callable[[type], Callable[[Message | Unknown], str]] = cache(_words.dispatch)

INITIATES = (UploadInitiate, DownloadInitiate, BlockUploadInitiate, BlockDownloadInitiate)
# The multiplexer of an abort that knows of no transfer.
NONE = Multiplexer(0)


class Decoder:
    """Follows a conversation on one channel, so that it can tell the segments of a block.

    They come unasked as well: before the client has started a block upload, after it has ended the
    upload on its side, or more of them than it wanted.
    """

    def __init__(self) -> None:
        """Start outside any block transfer."""
        self._client_sends_segments = False
        self._server_sends_segments = False
        self._may_send_segments = False
        self._acknowledges_last = False
        self._last_sequence = 0
        self._last_marked = False
        # Whether the very last segment was sent, by either side; and that of the client itself.
        self._ended = False
        self._last_segment = b""
        self._asked: Request | None = None
        self._latest: Multiplexer | None = None
        self._uploaded: Multiplexer | None = None

    def request(self, frame: bytes, built: Message | None = None) -> Request:
        """Read a frame of the client and follow where it leads.

        ``built`` is the message that the frame was made of: it need not be read again where these
        bytes stand for it.
        """
        message: Request
        if not self._client_sends_segments:
            message = built if built is not None and is_plain(built) else decode_request(frame)
            if self._last_segment and frame == self._last_segment:
                self._asked = again = BlockSegment.decode(frame)
                return again
        elif self._is_end(frame):
            self._asked = end = BlockEnd.decode(frame)
            return end
        elif isinstance(built, BlockSegment) and built.sequence:
            message = built
        else:
            message = decode_segment(frame)
        self._asked = message
        self._follow(message)
        if isinstance(message, BlockSegment):
            self._last_segment = frame if message.last else self._last_segment
            return message
        self._last_segment = b""
        if isinstance(message, INITIATES):
            self._latest = message.mux
            if isinstance(message, BlockUploadInitiate):
                self._uploaded = message.mux
        elif isinstance(message, BlockUploadStart):
            self._server_sends_segments = True
        elif isinstance(message, BlockAck):
            self._server_sends_segments &= not self._acknowledges_last
        return message

    def response(self, frame: bytes) -> Response:
        """Read a frame of the server and follow where it leads."""
        message: Response
        if self._server_sends_segments and self._is_end(frame):
            return BlockEnd.decode(frame)
        if self._server_sends_segments:
            message = decode_segment(frame)
            if isinstance(message, BlockSegment) and message.last:  # as an abort has this bit set
                refusal = decode_response(frame)
                message = refusal if self.is_refusal(refusal) else message
        else:
            message = decode_response(frame)
            if self._may_send_segments:
                segment = decode_segment(frame)
                if isinstance(segment, BlockSegment) and self._is_stray(segment, message):
                    self._last_sequence = segment.sequence
                    return segment
        self._follow(message)
        if not isinstance(message, Unknown):
            begins = isinstance(message, BlockUploadInitiateResponse)
            self._may_send_segments = begins or isinstance(message, BlockSegment)
            self._last_sequence = 0 if begins else self._last_sequence
        if isinstance(message, BlockDownloadInitiateResponse):
            self._client_sends_segments = True
        elif isinstance(message, BlockAck):
            self._client_sends_segments &= not self._acknowledges_last
        return message

    def _is_end(self, frame: bytes) -> bool:
        """Say whether a frame is the end of a block transfer, though segments may come yet.

        It is where the last one was sent, and this is no number that could follow.
        """
        if not self._ended or len(frame) != FRAME_LENGTH or not BlockEnd.matches(frame[0]):
            return False
        segment, end = BlockSegment.decode(frame), BlockEnd.decode(frame)
        return segment.sequence != self._last_sequence + 1 and not end.reserved_fields()

    def _is_stray(self, segment: BlockSegment, message: Response) -> bool:
        """Say whether a frame is rather an unwanted segment than any other message."""
        if self.is_answer(message):
            return False
        in_sequence = segment.sequence in (self._last_sequence + 1, 1)
        nothing_else = isinstance(message, Unknown) or bool(message.reserved_fields())
        return in_sequence or nothing_else

    def is_answer(self, message: Response) -> bool:
        """Say whether this refuses something, or answers the initiate that was sent last."""
        kinds = ANSWERS.get(type(self._asked), ())
        due = getattr(self._asked, "mux", None)
        answers = isinstance(message, kinds) and getattr(message, "mux", None) == due
        return answers or self.is_refusal(message)

    def is_refusal(self, message: Response) -> bool:
        """Say whether this is an abort that is due, also with reserved bits.

        Where no segment is due, one that names no object is as well.
        """
        nameless = () if self._server_sends_segments else (NONE,)
        return is_refusal(message, self._latest, self._uploaded, *nameless)

    def _follow(self, message: Request | Response) -> None:
        if isinstance(message, BlockSegment):
            self._last_sequence = message.sequence
            self._last_marked = message.last
            self._ended |= message.last
        elif isinstance(message, BlockAck):
            self._acknowledges_last = self._last_marked and message.sequence == self._last_sequence
        elif not isinstance(message, Unknown):
            self._client_sends_segments = self._server_sends_segments = False
            self._last_marked = self._ended = False
