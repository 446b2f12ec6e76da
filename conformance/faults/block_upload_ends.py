"""Servers that are wrong about where a block upload ends: n in the end frame, the last flag."""

from dataclasses import replace

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.frames import BlockAck, BlockEnd, BlockEndResponse, BlockSegment, Response
from conformance.sdo.segmented_server import SEGMENT_LENGTH
from conformance.sdo.server import BlockUpload, Server

COUNT = DefectClass.UNUSED_COUNT
FLAG = DefectClass.LAST_FLAG


class _Unused(Server):
    """Sends another n in the end frame."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        """Replace n."""
        end = super().block_end(transfer)
        return replace(end, unused=self.unused(end.unused))

    def unused(self, right: int) -> int:
        """Return what is sent as n."""
        return right


@fault("block-upload-n-off-by-one", COUNT, "block-upload.size")
class UnusedOffByOne(_Unused):
    """States one byte too few in n when the last segment is not full."""

    def unused(self, right: int) -> int:
        """Subtract 1."""
        return max(right - 1, 0)


@fault("block-upload-n-7-for-full-segment", COUNT, "block-upload.size[7]")
class SevenForFull(_Unused):
    """Sends n = 7 behind a full last segment."""

    def unused(self, right: int) -> int:
        """Mistake a full segment for an empty one."""
        return right or SEGMENT_LENGTH


@fault("block-upload-n-is-count", COUNT, "block-upload.size")
class UnusedIsCount(_Unused):
    """States in n how many bytes of the last segment count."""

    def unused(self, right: int) -> int:
        """Turn it round."""
        return SEGMENT_LENGTH - right


@fault("block-upload-n-always-zero", COUNT, "block-upload.size[1]")
class UnusedZero(_Unused):
    """Leaves n at 0: the size was announced."""

    def unused(self, right: int) -> int:
        """Leave it out."""
        return 0


class _Marks(Server):
    """Marks other segments as the last."""

    def sub_block(self, transfer: BlockUpload) -> list[Response]:
        """Ask ``marked`` for each segment."""
        return [
            replace(segment, last=self.marked(transfer, segment))
            for segment in super().sub_block(transfer)
            if isinstance(segment, BlockSegment)
        ]

    def marked(self, transfer: BlockUpload, segment: BlockSegment) -> bool:
        """Say whether a segment is marked."""
        del transfer
        return segment.last


@fault("block-upload-last-at-full-block-not-marked", FLAG, "block-upload.block-size[1]")
class FullBlockNotMarked(_Marks):
    """Does not mark the last segment when it is the last one of a full sub-block."""

    def marked(self, transfer: BlockUpload, segment: BlockSegment) -> bool:
        """Look at the number first."""
        return segment.last and segment.sequence < transfer.block_size


@fault("block-upload-marked-one-early", FLAG, "block-upload.size[8]")
class OneEarly(_Marks):
    """Marks the last segment but one as well."""

    def marked(self, transfer: BlockUpload, segment: BlockSegment) -> bool:
        """Be off by one."""
        behind = transfer.offset + segment.sequence * SEGMENT_LENGTH
        return segment.last or behind + SEGMENT_LENGTH >= len(transfer.data)


@fault("block-upload-each-sub-block-marked", FLAG, "block-upload.block-size")
class EachMarked(_Marks):
    """Marks the last segment of each sub-block."""

    def marked(self, transfer: BlockUpload, segment: BlockSegment) -> bool:
        """Look at the sub-block only."""
        return segment.last or segment.sequence == transfer.block_size


@fault("block-upload-repeated-not-marked", FLAG, "block-upload.acknowledged")
class RepeatedNotMarked(_Marks):
    """Marks the last segment the first time it is sent only."""

    done: BlockUpload | None = None

    def marked(self, transfer: BlockUpload, segment: BlockSegment) -> bool:
        """Mark once."""
        if not segment.last or self.done is transfer:
            return False
        self.done = transfer
        return True


@fault("block-upload-full-block-ends-with-A1h", FLAG, "block-upload.ends-with-sub-block")
class FullBlockEndsWrongly(FullBlockNotMarked):
    """Does not mark the last segment of a full sub-block, and answers its acknowledgement by A1h.

    That is the answer to the end of a block download.
    """

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Mistake the direction."""
        transfer = self.transfer
        full = isinstance(transfer, BlockUpload) and transfer.sent == transfer.block_size
        responses = super().on_block_ack(request)
        ended = full and isinstance(self.transfer, BlockUpload) and self.transfer.ended
        return [BlockEndResponse()] if ended else responses
