"""Segments of a block upload that come beyond their sub-block, or behind its last one."""

from conformance.sdo.decoding import as_answer, decode_request, decode_response
from conformance.sdo.describe import hex_bytes
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
)
from conformance.sdo.kinds import kind_of
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.limits import LARGEST_BLOCK
from conformance.sdo.rules import BLOCK_SIZE, Violation
from conformance.sdo.rules.block_upload import ENDS
from conformance.sdo.seen import Said, Seen

LAST = 0x80
# The lowest first byte of an answer with that bit, but for an abort.
ANSWERS = 0xA0


class SubBlocks:
    """Counts the segments of a block upload, and tells which of them are too many.

    They come right behind the sub-block, and would be taken for the answer to whatever the client
    sends next.
    """

    def __init__(self) -> None:
        """Start without a transfer."""
        self._asked = 0
        self._next = 0
        self._beyond = 0
        self._resumed = False
        self._behind_last = 0
        self._superseded = False

    def request(self, frame: bytes) -> None:
        """Take what the client sends."""
        if len(frame) != FRAME_LENGTH or frame[0] < LAST:
            self._superseded = True  # no request of a block upload
            return
        request = decode_request(frame)
        goes_on = isinstance(request, BlockAck) and request.sequence + 1 >= self._behind_last
        self._superseded |= not goes_on
        match request:
            case BlockUploadInitiate():
                self._asked = request.block_size
                self._next = self._beyond = 0
            case BlockUploadStart() if self._asked:
                self._next, self._resumed = 1, False
            case BlockAck() if self._asked:
                # A server that does not begin to count again sends such numbers as well.
                self._asked, self._next, self._resumed = request.block_size, 1, True
            case Abort():
                self._next = 0

    def is_due(self, number: int) -> bool:
        """Say whether this is the number of the segment that is due."""
        return 0 < number == self._next

    def takes(self, frame: bytes) -> bool:
        """Take what the server sent where that is no segment too many for certain.

        So is the segment that is due, and whatever comes as long as none is counted.
        """
        if not (self._next or self._beyond or self._behind_last):
            return True
        first = frame[0] if frame else 0
        number = first & ~LAST
        if not self._next or number != self._next:
            return False
        self._next = 0 if first & LAST or number >= self._asked else number + 1
        self._beyond = number + 1 if not self._next and not first & LAST else 0
        self._behind_last, self._superseded = number + 1 if first & LAST else 0, False
        return True

    def surplus(self, frame: bytes, *, expected: bool) -> Violation | None:
        """Take what the server sent; return what is wrong with a segment too many.

        ``expected``: the device is known to send such segments.
        """
        if self.takes(frame):
            return None
        first = frame[0] if frame else 0
        number = first & ~LAST
        if 0 < number == self._behind_last and not self._may_be_answer(frame, expected=expected):
            self._behind_last += 1
            return Violation(
                ENDS,
                expected="no segment behind the one that is marked as the last",
                actual=_one_too_many(frame),
            )
        if not self._beyond or number != self._beyond or number > LARGEST_BLOCK:
            self._beyond = 0
            return None
        if self._resumed and not expected:
            return None
        self._beyond = 0 if first & LAST else number + 1
        return Violation(
            BLOCK_SIZE,
            expected=f"{self._asked} segments, as asked for",
            actual=_one_too_many(frame),
        )

    def _may_be_answer(self, frame: bytes, *, expected: bool) -> bool:
        """Say whether this may answer what the client has sent since the last segment came.

        No answer but an abort begins as a segment that is marked again.
        """
        if self._superseded:
            return not (expected and LAST < frame[0] < ANSWERS)
        return self._resumed and isinstance(as_answer(decode_response(frame)), BlockEnd)


def _one_too_many(frame: bytes) -> Seen:
    segment = BlockSegment.decode(frame)
    return Said(
        f"block segment {segment.sequence} [{hex_bytes(frame)}]", kind_of(BlockSegment).name
    )
