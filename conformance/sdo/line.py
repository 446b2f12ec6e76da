"""What runs on an SDO channel, by its frames: the one follower of a conversation, without I/O.

Frames go in, messages come out: the segments of a block use all of byte 0, so only the state of the
transfer tells them from other messages. The same state says which transfer is open, whether an
answer is due, and which data a download has brought. The oracle follows for itself, on purpose: it
judges, and shares nothing with what it judges.
"""

from collections.abc import Callable
from typing import Any

from conformance.sdo.decoding import (
    as_answer,
    decode_response,
    decode_segment,
    is_abort,
)
from conformance.sdo.describe import hex_bytes
from conformance.sdo.frame_reader import FrameReader
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
Initiated = UploadInitiateResponse | BlockDownloadInitiateResponse | BlockUploadInitiateResponse
# They end whatever transfer runs.
ENDINGS = (Abort, BlockEndResponse)
# A server may answer them with many segments, whether it has to or not.
ASKS_FOR_SEGMENTS = (BlockUploadStart, BlockAck)


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
        self._reader = FrameReader()
        # Whether the client has sent an abort since the latest response.
        self._gave_up = False
        # The download that in_flight is of, until it ends: the toggle bit or the sequence number
        # that is due, the bytes in sub-blocks before, and whether the last segment was sent.
        self._download: Multiplexer | None = None
        self._toggle, self._due, self._acknowledged, self._brought_all = 0, 1, 0, False
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
        request = self.asked = self._reader.request(frame, built)
        self.owed = True
        if isinstance(request, BlockSegment):  # thousands, which end nothing
            self.is_out_of_place, self._superseded = False, True
            self.unacknowledged += 1
            self._take_segment(request)
            return request
        kind = type(request)
        before = CONTINUES.get(kind)
        self.is_out_of_place = before is not None and self._is_out_of_place(before, frame)
        if self.is_out_of_place and kind in ASKS_FOR_SEGMENTS:
            self.misplaced.add((kind, self.open is not None))
        self.unacknowledged = 0
        self._superseded |= kind is not BlockAck
        if kind in _REQUESTS:
            _REQUESTS[kind](self, request)
        return request

    def _is_out_of_place(self, before: tuple[type, ...], frame: bytes) -> bool:
        if len(frame) != FRAME_LENGTH:
            self.owed = not is_abort(frame)
            return False
        return self.open is None or not isinstance(self.answered, before)

    def _abort(self, _: Abort) -> None:
        self.owed, self._gave_up = False, True
        self.open = self._download = None

    def _confirm_end(self, _: BlockEndResponse) -> None:
        self.owed = self.open is None
        self.open = None

    def _begin_download(self, request: DownloadInitiate | BlockDownloadInitiate) -> None:
        if isinstance(request, BlockDownloadInitiate) or not request.expedited:
            self._download, self.in_flight = request.mux, bytearray()
            self._toggle, self._due, self._acknowledged, self._brought_all = 0, 1, 0, False

    def _download_segment(self, segment: DownloadSegment) -> None:
        if segment.toggle == self._toggle:
            if self._download is not None:
                self.in_flight += segment.payload
            self._toggle ^= 1
            self._brought_all = segment.last

    def _take_segment(self, segment: BlockSegment) -> None:
        if segment.sequence == self._due:
            if self._download is not None:
                at = self._acknowledged + SEGMENT_LENGTH * (self._due - 1)
                self.in_flight[at : at + SEGMENT_LENGTH] = segment.payload
            self._due += 1
        elif segment.sequence > self._due:
            self._due = 0  # behind a gap nothing is taken before it is sent again

    def _begin_block_upload(self, request: BlockUploadInitiate) -> None:
        self._block_size = request.block_size
        self._next = self._beyond = 0

    def _start_block_upload(self, _: BlockUploadStart) -> None:
        if self._block_size:
            self._next, self._resumed = 1, False

    def _acknowledge(self, request: BlockAck) -> None:
        self._superseded |= request.sequence + 1 < self._behind_last
        if self._block_size:
            # A server that does not begin to count again sends such numbers as well.
            self._block_size, self._next, self._resumed = request.block_size, 1, True

    # What the server sends

    def response(self, frame: bytes) -> Response:
        """Take a response, and return which it is."""
        response = self._reader.response(frame)
        if isinstance(response, Abort) and response.reserved_bits:
            response = self._or_segment(response)
        self.owed = self._gave_up = False
        self.completed = None
        kind, asked = type(response), self.asked
        if isinstance(asked, BlockDownloadInitiate) and kind not in ENDINGS:
            self.open = asked.mux
        elif kind in _RESPONSES:
            _RESPONSES[kind](self, response)
        if self.open is not None:
            self.latest = self.open
        if kind is BlockUploadInitiateResponse:
            self.may_send_segments = True
        elif self.open is not None and kind in OTHER_INITIATES:
            self.may_send_segments = False
        self.answered = response
        return response

    def peek(self, frame: bytes) -> Response:
        """Return which response has arrived, as far as that can be said before it is taken.

        Where segments of a block upload may come, 81h is one, unless what follows it is the object
        and the code of an abort.
        """
        response = decode_response(frame)
        if isinstance(response, Abort) and response.reserved_bits:
            response = self._or_segment(response)
        return response

    def take_due(self, frame: bytes) -> bool:
        """Take the segment of a sub-block that is due behind another, unless it is the last one.

        That is the short way for the segments of a long upload; False for any other frame.
        """
        due = self._next
        if len(frame) != FRAME_LENGTH or not 0 < due == frame[0]:
            return False
        self._count(due, last=False)
        self._reader.last_sequence = due
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

    def _aborted(self, _: Abort) -> None:
        self.open = self._download = None
        self.unacknowledged = 0

    def _complete(self, _: BlockEndResponse) -> None:
        self.open = None
        self.completed, self._download = self._download, None

    def _receive_segment(self, segment: BlockSegment) -> None:
        if self.is_due(segment.sequence):
            self._count(segment.sequence, last=segment.last)

    def _acknowledged_by(self, response: BlockAck) -> None:
        self._due = 1
        self._acknowledged += SEGMENT_LENGTH * response.sequence
        if response.sequence == self.unacknowledged:
            self.unacknowledged = 0

    def _uploaded_segment(self, segment: UploadSegmentResponse) -> None:
        if segment.last:
            self.open = None

    def _confirm_segment(self, _: DownloadSegmentResponse) -> None:
        if self._brought_all:
            self.completed, self._download = self._download, None
        if isinstance(self.asked, DownloadSegment) and self.asked.last:
            self.open = None

    def _confirm_download(self, _: DownloadInitiateResponse) -> None:
        asked, self.open = self.asked, None
        if isinstance(asked, DownloadInitiate) and asked.expedited:
            self.completed = asked.mux
        elif isinstance(asked, DownloadInitiate):
            self.open = asked.mux

    def _begun(self, response: Initiated) -> None:
        is_over = isinstance(response, UploadInitiateResponse) and response.expedited
        self.open = None
        if isinstance(self.asked, INITIATES) and not is_over:
            self.open = self.asked.mux

    def _or_segment(self, abort: Abort) -> Response:
        """Return what came: an abort with reserved bits may be a segment."""
        may_be_segment = self.may_send_segments and not self._reader.is_answer(abort)
        return decode_segment(abort.encode()) if may_be_segment else abort

    # What an abort leaves

    @property
    def waits_for_segments(self) -> bool:
        """Whether the server's latest response asks for segments of a block download."""
        return isinstance(self.answered, BlockDownloadInitiateResponse | BlockAck)

    @property
    def is_abandoned(self) -> bool:
        """Whether the client has aborted a block download, and nothing has come since."""
        return self._gave_up and self.waits_for_segments


# What the other requests and responses change is nothing but the latest of them.
_REQUESTS: dict[type, Callable[[Line, Any], None]] = {
    Abort: Line._abort,
    BlockEndResponse: Line._confirm_end,
    DownloadInitiate: Line._begin_download,
    BlockDownloadInitiate: Line._begin_download,
    DownloadSegment: Line._download_segment,
    BlockUploadInitiate: Line._begin_block_upload,
    BlockUploadStart: Line._start_block_upload,
    BlockAck: Line._acknowledge,
}
_RESPONSES: dict[type, Callable[[Line, Any], None]] = {
    Abort: Line._aborted,
    BlockEndResponse: Line._complete,
    BlockSegment: Line._receive_segment,
    BlockAck: Line._acknowledged_by,
    UploadSegmentResponse: Line._uploaded_segment,
    DownloadSegmentResponse: Line._confirm_segment,
    DownloadInitiateResponse: Line._confirm_download,
    UploadInitiateResponse: Line._begun,
    BlockDownloadInitiateResponse: Line._begun,
    BlockUploadInitiateResponse: Line._begun,
}


def _one_too_many(number: int, frame: bytes) -> Said:
    return Said(f"block segment {number} [{hex_bytes(frame)}]", kind_of(BlockSegment).name)
