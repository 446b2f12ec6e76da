"""Which message a frame is, by the state of the conversation: the segments of a block need that."""

from conformance.sdo.decoding import (
    decode_request,
    decode_response,
    decode_segment,
    is_answer,
    is_plain,
    is_refusal,
)
from conformance.sdo.frames import (
    INITIATES,
    BlockAck,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    Request,
    Response,
    Unknown,
)
from conformance.sdo.layout import FRAME_LENGTH, Message, Multiplexer

# The multiplexer of an abort that knows of no transfer.
NO_OBJECT = Multiplexer(0)


class FrameReader:
    """Reads the frames of a ``Line``. ``last_sequence`` is the number of the latest segment.

    Segments come unasked as well: before the client has started a block upload, after it has ended
    the upload on its side, or more of them than it wanted.
    """

    def __init__(self) -> None:
        """Start outside any block transfer."""
        self._asked: Request | None = None
        # Who sends segments of a block now; whether the server may, though none were asked for.
        self._client_sends_segments = self._server_sends_segments = self._is_uploaded = False
        # The sub-block: its latest segment; whether the very last was sent, and acknowledged.
        self.last_sequence, self._last_marked = 0, False
        self._ended = self._acknowledges_last = False
        self._last_segment = b""
        # The objects of the latest initiate, and of the latest block upload.
        self._named: Multiplexer | None = None
        self._uploaded: Multiplexer | None = None

    def request(self, frame: bytes, built: Message | None) -> Request:
        """Read a frame of the client, and follow where it leads."""
        request = self._asked = self._read_request(frame, built)
        return request

    def _read_request(self, frame: bytes, built: Message | None) -> Request:
        message: Request
        if not self._client_sends_segments:
            message = built if built is not None and is_plain(built) else decode_request(frame)
            if self._last_segment and frame == self._last_segment:
                return BlockSegment.decode(frame)
        elif self._is_end(frame):
            return BlockEnd.decode(frame)
        elif isinstance(built, BlockSegment) and built.sequence:
            message = built
        else:
            message = decode_segment(frame)
        self._follow_sub_block(message)
        if isinstance(message, BlockSegment):
            self._last_segment = frame if message.last else self._last_segment
            return message
        self._last_segment = b""
        if isinstance(message, INITIATES):
            self._named = message.mux
            if isinstance(message, BlockUploadInitiate):
                self._uploaded = message.mux
        elif isinstance(message, BlockUploadStart):
            self._server_sends_segments = True
        elif isinstance(message, BlockAck):
            self._server_sends_segments &= not self._acknowledges_last
        return message

    def response(self, frame: bytes) -> Response:
        """Read a frame of the server, and follow where it leads."""
        message: Response
        if self._server_sends_segments and self._is_end(frame):
            return BlockEnd.decode(frame)
        if self._server_sends_segments:
            message = decode_segment(frame)
            if isinstance(message, BlockSegment) and message.last:  # as an abort has this bit set
                refusal = decode_response(frame)
                message = refusal if self._is_refusal(refusal) else message
        else:
            message = decode_response(frame)
            if self._is_uploaded:
                segment = decode_segment(frame)
                if isinstance(segment, BlockSegment) and self._is_stray(segment, message):
                    self.last_sequence = segment.sequence
                    return segment
        self._follow_sub_block(message)
        if not isinstance(message, Unknown):
            begins = isinstance(message, BlockUploadInitiateResponse)
            self._is_uploaded = begins or isinstance(message, BlockSegment)
            self.last_sequence = 0 if begins else self.last_sequence
        if isinstance(message, BlockDownloadInitiateResponse):
            self._client_sends_segments = True
        elif isinstance(message, BlockAck):
            self._client_sends_segments &= not self._acknowledges_last
        return message

    def _is_stray(self, segment: BlockSegment, message: Response) -> bool:
        """Say whether a frame is rather an unwanted segment than any other message."""
        if self.is_answer(message):
            return False
        in_sequence = segment.sequence in (self.last_sequence + 1, 1)
        nothing_else = isinstance(message, Unknown) or bool(message.reserved_fields())
        return in_sequence or nothing_else

    def is_answer(self, message: Response) -> bool:
        """Say whether this refuses something, or answers the latest request."""
        answers = self._asked is not None and is_answer(message, self._asked)
        return answers or self._is_refusal(message)

    def _is_refusal(self, message: Response) -> bool:
        """Say whether this is an abort that is due, also with reserved bits.

        Where no segment is due, one that names no object is as well.
        """
        nameless = () if self._server_sends_segments else (NO_OBJECT,)
        return is_refusal(message, self._named, self._uploaded, *nameless)

    def _is_end(self, frame: bytes) -> bool:
        """Say whether a frame is the end of a block transfer, though segments may come yet.

        It is where the last one was sent, and this is no number that could follow.
        """
        if not self._ended or len(frame) != FRAME_LENGTH or not BlockEnd.matches(frame[0]):
            return False
        segment, end = BlockSegment.decode(frame), BlockEnd.decode(frame)
        return segment.sequence != self.last_sequence + 1 and not end.reserved_fields()

    def _follow_sub_block(self, message: Request | Response) -> None:
        if isinstance(message, BlockSegment):
            self.last_sequence = message.sequence
            self._last_marked = message.last
            self._ended |= message.last
        elif isinstance(message, BlockAck):
            self._acknowledges_last = self._last_marked and message.sequence == self.last_sequence
        elif not isinstance(message, Unknown):
            self._client_sends_segments = self._server_sends_segments = False
            self._last_marked = self._ended = False
