"""What runs on an SDO channel, by its frames: the one follower of a conversation, without I/O.

Frames go in, messages come out: the segments of a block use all of byte 0, so only the state of the
transfer tells them from other messages. The same state says which transfer is open, whether an
answer is due, and which data a download has brought. The oracle follows for itself, on purpose: it
judges, and shares nothing with what it judges.
"""

from conformance.sdo.decoding import (
    as_answer,
    decode_request,
    decode_response,
    decode_segment,
    is_abort,
    is_answer,
    is_plain,
    is_refusal,
)
from conformance.sdo.describe import hex_bytes
from conformance.sdo.frames import (
    INITIATES,
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
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.kinds import kind_of
from conformance.sdo.layout import FRAME_LENGTH, Message, Multiplexer
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.rules import BLOCK_SIZE, Violation
from conformance.sdo.rules.block_upload import ENDS
from conformance.sdo.seen import Said

# What each request that begins no transfer continues, by the response before it.
CONTINUES: dict[type, tuple[type, ...]] = {
    UploadSegment: (UploadInitiateResponse, UploadSegmentResponse),
    DownloadSegment: (DownloadInitiateResponse, DownloadSegmentResponse),
    BlockUploadStart: (BlockUploadInitiateResponse,),
    BlockAck: (BlockSegment,),
    BlockEndResponse: (BlockEnd,),
    BlockEnd: (BlockAck,),
    Unknown: (),
}
OTHER_INITIATES = UploadInitiateResponse, DownloadInitiateResponse, BlockDownloadInitiateResponse
# A server may answer them with many segments, whether it has to or not.
ASKS_FOR_SEGMENTS = (BlockUploadStart, BlockAck)
# The multiplexer of an abort that knows of no transfer.
NO_OBJECT = Multiplexer(0)


class Line:
    """Follows the requests and responses of one channel.

    ``open`` is the object of the transfer that runs, or None, and ``latest`` that of the last one.
    A transfer whose initiate was answered by something else is taken for open: the server may wait
    for segments, and would take whatever comes for one but an abort. ``asked`` and ``answered`` are
    the latest request and response; ``owed``: the former has not been answered, and has to be.

    ``unacknowledged`` counts the segments of a block download that the server has not acknowledged.
    ``in_flight`` is what the latest download has brought, as far as a server may take it: what does
    not come in sequence, or comes behind an abort, is no part of it. ``completed`` is the object of
    the download that the latest response has confirmed.

    ``may_send_segments``: a block upload has begun, and no transfer in several frames since: a
    server may send segments of it even after its end. A request ``is_out_of_place`` that continues
    no transfer and begins none; of those that ask for segments, ``misplaced`` has the kind, and
    whether a transfer was open.
    """

    def __init__(self) -> None:
        """Start with no transfer."""
        self.open: Multiplexer | None = None
        self.latest: Multiplexer | None = None
        self.asked: Request | None = None
        self.answered: Response | None = None
        self.owed = False
        self.unacknowledged = 0
        self.in_flight = bytearray()
        self.completed: Multiplexer | None = None
        self.may_send_segments = False
        self.is_out_of_place = False
        self.misplaced: set[tuple[type[Request], bool]] = set()
        # Whether the client has sent an abort since the latest response.
        self._gave_up = False
        # The download that in_flight is of, until it ends: the toggle bit or the sequence number
        # that is due, the bytes in sub-blocks before, and whether the last segment was sent.
        self._download: Multiplexer | None = None
        self._toggle, self._due, self._acknowledged, self._brought_all = 0, 1, 0, False
        # Who sends segments of a block now; whether the server may, though none were asked for.
        self._client_sends_segments = self._server_sends_segments = self._is_uploaded = False
        # The sub-block: its latest segment; whether the very last was sent, and acknowledged.
        self._last_sequence, self._last_marked = 0, False
        self._ended = self._acknowledges_last = False
        self._last_segment = b""
        # The objects of the latest initiate, and of the latest block upload.
        self._named: Multiplexer | None = None
        self._uploaded: Multiplexer | None = None
        # The sub-block of an upload: how many segments were asked for, and which is due; the
        # numbers behind the sub-block and behind the very last segment, 0 where none is behind it.
        self._block_size = self._next = self._beyond = self._behind_last = 0
        # An acknowledgement has begun it; something else was asked since the very last segment.
        self._resumed = self._superseded = False

    # What the client sends

    def request(self, frame: bytes, built: Message | None = None) -> Request:
        """Take a request, and return which it is.

        ``built`` is the message that the frame was made of: it need not be read again where these
        bytes stand for it.
        """
        request = self.asked = self._read_request(frame, built)
        self.owed = not is_abort(frame)
        if isinstance(request, BlockSegment):
            self._follow_segment(request)
            return request
        before = CONTINUES.get(type(request)) if len(frame) == FRAME_LENGTH else None
        continues = self.open is not None and isinstance(self.answered, before or ())
        self.is_out_of_place = before is not None and not continues
        if self.is_out_of_place and isinstance(request, ASKS_FOR_SEGMENTS):
            self.misplaced.add((type(request), self.open is not None))
        self.unacknowledged = 0
        self._follow_request(request)
        return request

    def _follow_request(self, request: Request) -> None:
        goes_on = isinstance(request, BlockAck) and request.sequence + 1 >= self._behind_last
        self._superseded |= not goes_on
        match request:
            case Abort():
                self.owed, self._gave_up = False, True
                self.open = self._download = None
            case BlockEndResponse():
                self.owed = self.open is None
                self.open = None
            case DownloadInitiate(expedited=False) | BlockDownloadInitiate():
                self._download, self.in_flight = request.mux, bytearray()
                self._toggle, self._due, self._acknowledged, self._brought_all = 0, 1, 0, False
            case DownloadSegment(toggle=toggle) if toggle == self._toggle:
                if self._download is not None:
                    self.in_flight += request.payload
                self._toggle ^= 1
                self._brought_all = request.last
            case BlockUploadInitiate():
                self._block_size = request.block_size
                self._next = self._beyond = 0
            case BlockUploadStart() if self._block_size:
                self._next, self._resumed = 1, False
            case BlockAck() if self._block_size:
                # A server that does not begin to count again sends such numbers as well.
                self._block_size, self._next, self._resumed = request.block_size, 1, True

    def _follow_segment(self, segment: BlockSegment) -> None:
        """Take the short way: thousands of segments come, and end nothing."""
        self.unacknowledged += 1
        self.is_out_of_place, self._superseded = False, True
        if segment.sequence == self._due:
            if self._download is not None:
                at = self._acknowledged + SEGMENT_LENGTH * (self._due - 1)
                self.in_flight[at : at + SEGMENT_LENGTH] = segment.payload
            self._due += 1
        elif segment.sequence > self._due:
            self._due = 0  # behind a gap nothing is taken before it is sent again

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

    # What the server sends

    def response(self, frame: bytes) -> Response:
        """Take a response, and return which it is."""
        response = self._or_segment(self._read_response(frame), frame)
        self.owed = self._gave_up = False
        self.completed = None
        self._follow_response(response)
        if self.open is not None:
            self.latest = self.open
        begins = isinstance(response, BlockUploadInitiateResponse)
        if begins or (self.open is not None and isinstance(response, OTHER_INITIATES)):
            self.may_send_segments = begins
        self.answered = response
        return response

    def peek(self, frame: bytes) -> Response:
        """Return which response has arrived, as far as that can be said before it is taken.

        Where segments of a block upload may come, 81h is one, unless what follows it is the object
        and the code of an abort.
        """
        return self._or_segment(decode_response(frame), frame)

    def take_due(self, frame: bytes) -> bool:
        """Take the segment of a sub-block that is due behind another, unless it is the last one.

        That is the short way for the segments of a long upload; False for any other frame.
        """
        due = self._next
        if len(frame) != FRAME_LENGTH or not 0 < due == frame[0]:
            return False
        self._count(due, last=False)
        self._last_sequence = due
        return True

    def is_due(self, sequence: int) -> bool:
        """Say whether this is the number of the segment that is due."""
        return 0 < sequence == self._next

    def surplus(self, frame: bytes, *, expected: bool) -> Violation | None:
        """Return what is wrong with a segment that comes beyond its sub-block; None for others.

        It would be taken for the answer to whatever the client sends next. ``expected``: the device
        is known to send such segments. Any frame that is none has to be taken as a response yet.
        """
        if not frame or not (self._beyond or self._behind_last):
            return None
        segment = BlockSegment.decode(frame)
        number = segment.sequence
        if 0 < number == self._next:
            return None
        if 0 < number == self._behind_last and not self._may_be_answer(frame, expected=expected):
            self._behind_last += 1
            return Violation(
                ENDS,
                expected="no segment behind the one that is marked as the last",
                actual=_one_too_many(number, frame),
            )
        if not self._beyond or number != self._beyond or number > LARGEST_BLOCK:
            self._beyond = 0
            return None
        if self._resumed and not expected:
            return None
        self._beyond = 0 if segment.last else number + 1
        return Violation(
            BLOCK_SIZE,
            expected=f"{self._block_size} segments, as asked for",
            actual=_one_too_many(number, frame),
        )

    def _may_be_answer(self, frame: bytes, *, expected: bool) -> bool:
        """Say whether this may answer what the client has sent since the last segment came.

        No answer but an abort begins as a segment that is marked again; exactly 80h is none.
        """
        if self._superseded:
            return not (expected and Abort.matches(frame[0]))
        return self._resumed and isinstance(as_answer(decode_response(frame)), BlockEnd)

    def _count(self, sequence: int, *, last: bool) -> None:
        """Take the segment that is due."""
        self._next = 0 if last or sequence >= self._block_size else sequence + 1
        self._beyond = sequence + 1 if not self._next and not last else 0
        self._behind_last, self._superseded = sequence + 1 if last else 0, False

    def _follow_response(self, response: Response) -> None:
        asked = self.asked
        match response:
            case Abort():
                self.open = self._download = None
                self.unacknowledged = 0
            case BlockEndResponse():
                self.open = None
                self.completed, self._download = self._download, None
            case _ if isinstance(asked, BlockDownloadInitiate):
                self.open = asked.mux
            case BlockSegment():
                if self.is_due(response.sequence):
                    self._count(response.sequence, last=response.last)
            case BlockAck():
                self._due = 1
                self._acknowledged += SEGMENT_LENGTH * response.sequence
                if response.sequence == self.unacknowledged:
                    self.unacknowledged = 0
            case UploadSegmentResponse():
                if response.last:
                    self.open = None
            case DownloadSegmentResponse():
                if self._brought_all:
                    self.completed, self._download = self._download, None
                if isinstance(asked, DownloadSegment) and asked.last:
                    self.open = None
            case DownloadInitiateResponse():
                self.open = None
                if isinstance(asked, DownloadInitiate) and asked.expedited:
                    self.completed = asked.mux
                elif isinstance(asked, DownloadInitiate):
                    self.open = asked.mux
            case UploadInitiateResponse(expedited=True):
                self.open = None
            case (
                UploadInitiateResponse()
                | BlockDownloadInitiateResponse()
                | BlockUploadInitiateResponse()
            ):
                self.open = asked.mux if isinstance(asked, INITIATES) else None

    def _read_response(self, frame: bytes) -> Response:
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
                    self._last_sequence = segment.sequence
                    return segment
        self._follow_sub_block(message)
        if not isinstance(message, Unknown):
            begins = isinstance(message, BlockUploadInitiateResponse)
            self._is_uploaded = begins or isinstance(message, BlockSegment)
            self._last_sequence = 0 if begins else self._last_sequence
        if isinstance(message, BlockDownloadInitiateResponse):
            self._client_sends_segments = True
        elif isinstance(message, BlockAck):
            self._client_sends_segments &= not self._acknowledges_last
        return message

    def _or_segment(self, response: Response, frame: bytes) -> Response:
        """Return what came: an abort with reserved bits may be a segment."""
        if not isinstance(response, Abort) or not response.reserved_bits:
            return response
        may_be_segment = self.may_send_segments and not self._is_answer(response)
        return decode_segment(frame) if may_be_segment else response

    def _is_stray(self, segment: BlockSegment, message: Response) -> bool:
        """Say whether a frame is rather an unwanted segment than any other message."""
        if self._is_answer(message):
            return False
        in_sequence = segment.sequence in (self._last_sequence + 1, 1)
        nothing_else = isinstance(message, Unknown) or bool(message.reserved_fields())
        return in_sequence or nothing_else

    def _is_answer(self, message: Response) -> bool:
        """Say whether this refuses something, or answers the latest request."""
        answers = self.asked is not None and is_answer(message, self.asked)
        return answers or self._is_refusal(message)

    def _is_refusal(self, message: Response) -> bool:
        """Say whether this is an abort that is due, also with reserved bits.

        Where no segment is due, one that names no object is as well.
        """
        nameless = () if self._server_sends_segments else (NO_OBJECT,)
        return is_refusal(message, self._named, self._uploaded, *nameless)

    # Segments of either side

    def _is_end(self, frame: bytes) -> bool:
        """Say whether a frame is the end of a block transfer, though segments may come yet.

        It is where the last one was sent, and this is no number that could follow.
        """
        if not self._ended or len(frame) != FRAME_LENGTH or not BlockEnd.matches(frame[0]):
            return False
        segment, end = BlockSegment.decode(frame), BlockEnd.decode(frame)
        return segment.sequence != self._last_sequence + 1 and not end.reserved_fields()

    def _follow_sub_block(self, message: Request | Response) -> None:
        if isinstance(message, BlockSegment):
            self._last_sequence = message.sequence
            self._last_marked = message.last
            self._ended |= message.last
        elif isinstance(message, BlockAck):
            self._acknowledges_last = self._last_marked and message.sequence == self._last_sequence
        elif not isinstance(message, Unknown):
            self._client_sends_segments = self._server_sends_segments = False
            self._last_marked = self._ended = False

    # What an abort leaves

    @property
    def waits_for_segments(self) -> bool:
        """Whether the server's latest response asks for segments of a block download."""
        return isinstance(self.answered, BlockDownloadInitiateResponse | BlockAck)

    @property
    def is_abandoned(self) -> bool:
        """Whether the client has aborted a block download, and nothing has come since."""
        return self._gave_up and self.waits_for_segments


def _one_too_many(number: int, frame: bytes) -> Said:
    return Said(f"block segment {number} [{hex_bytes(frame)}]", kind_of(BlockSegment).name)
