"""Segments of a block upload that come beyond the sub-block that was asked for."""

from conformance.sdo.decoding import decode_request
from conformance.sdo.describe import hex_bytes
from conformance.sdo.frames import Abort, BlockAck, BlockUploadInitiate, BlockUploadStart, Request
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.limits import LARGEST_BLOCK
from conformance.sdo.rules import BLOCK_SIZE, Violation

LAST = 0x80


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

    def request(self, frame: bytes) -> None:
        """Take what the client sends."""
        request: Request | None = decode_request(frame) if len(frame) == FRAME_LENGTH else None
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

    def surplus(self, frame: bytes, *, expected: bool) -> Violation | None:
        """Take what the server sent; return what is wrong with a segment too many.

        ``expected``: the device is known to send such segments.
        """
        first = frame[0] if frame else 0
        number = first & ~LAST
        if self._next and number == self._next:
            self._next = 0 if first & LAST or number >= self._asked else number + 1
            self._beyond = number + 1 if not self._next and not first & LAST else 0
            return None
        if not self._beyond or number != self._beyond or number > LARGEST_BLOCK:
            self._beyond = 0
            return None
        if self._resumed and not expected:
            return None
        self._beyond = 0 if first & LAST else number + 1
        return Violation(
            BLOCK_SIZE,
            expected=f"{self._asked} segments, as asked for",
            actual=f"block segment {number} [{hex_bytes(frame)}]",
        )
