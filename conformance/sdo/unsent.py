"""What is left to send of a block download (CiA 301, 7.2.4.2.10 and 7.2.4.3.10).

A server acknowledges what it has received in sequence; what is behind that is sent again in the
next sub-block, numbered from 1.
"""

from collections.abc import Sequence

from conformance.sdo.describe import in_words
from conformance.sdo.frames import BlockAck, BlockSegment
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.rules import BLOCK_PROGRESS, Violation
from conformance.sdo.seen import said

# How many sub-blocks in a row may be acknowledged with 0. One that brings a segment is progress.
MOST_STALLED = 64


class Unsent:
    """The segments of a block download that the server has not acknowledged yet.

    ``block_size`` is how many the server takes at once, as it said last. ``position`` counts the
    segments that it has acknowledged, ``repeated`` those that have to be sent again.
    """

    def __init__(self, data: bytes, block_size: int) -> None:
        """Begin with the first segment; no data are one empty segment."""
        self.data = data
        self.block_size = block_size
        self.position = 0
        self.repeated = 0
        self.total = max(-(-len(data) // SEGMENT_LENGTH), 1)
        self._stalled = 0

    @property
    def is_over(self) -> bool:
        """Whether the last segment is acknowledged."""
        return self.position >= self.total

    @property
    def unused(self) -> int:
        """How many bytes of the last segment hold no data: n of the end frame."""
        return self.total * SEGMENT_LENGTH - len(self.data)

    def sub_block(self) -> list[BlockSegment]:
        """Return the next sub-block: as many segments as the server takes, or all that are left."""
        count = min(self.block_size, self.total - self.position)
        begin = self.position * SEGMENT_LENGTH
        ends = range(begin, begin + count * SEGMENT_LENGTH, SEGMENT_LENGTH)
        return [
            BlockSegment.with_data(
                number,
                self.data[at : at + SEGMENT_LENGTH],
                last=self.position + number == self.total,
            )
            for number, at in enumerate(ends, 1)
        ]

    def acknowledged(self, ack: BlockAck, sent: Sequence[BlockSegment]) -> None:
        """Take the acknowledgement of the sub-block that was sent.

        Raises Violation where nothing is taken again and again.
        """
        self.position += ack.sequence
        self.repeated += len(sent) - ack.sequence
        self.block_size = ack.block_size
        self._stalled = 0 if ack.sequence else self._stalled + 1
        if self._stalled > MOST_STALLED:
            raise Violation(
                BLOCK_PROGRESS,
                expected="segments that were sent again to be taken at last",
                actual=said("{} times none", self._stalled).remarking(f"; last {in_words(ack)}"),
            )
