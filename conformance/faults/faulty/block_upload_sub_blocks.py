"""Servers that are wrong about the sub-blocks of an upload: lengths, losses, the last one."""

from dataclasses import replace

from conformance.faults.block_servers import ReadsAcknowledgements
from conformance.faults.registry import Defect, fault
from conformance.reference.server import BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    BlockAck,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    Response,
)
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.objects import ObjectDictionary, Refusal


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


@fault("block-upload-last-at-full-block-not-marked", Defect.LAST_FLAG, "block-upload.block-size[1]")
class FullBlockNotMarked(_Marks):
    """Does not mark the last segment when it is the last one of a full sub-block."""

    def marked(self, transfer: BlockUpload, segment: BlockSegment) -> bool:
        return segment.last and segment.sequence < transfer.block_size


@fault("block-upload-marked-one-early", Defect.LAST_FLAG, "block-upload.size[8]")
class OneEarly(_Marks):
    """Marks the last segment but one as well."""

    def marked(self, transfer: BlockUpload, segment: BlockSegment) -> bool:
        behind = transfer.offset + segment.sequence * SEGMENT_LENGTH
        return segment.last or behind + SEGMENT_LENGTH >= len(transfer.data)


@fault("block-upload-each-sub-block-marked", Defect.LAST_FLAG, "block-upload.block-size")
class EachMarked(_Marks):
    """Marks the last segment of each sub-block."""

    def marked(self, transfer: BlockUpload, segment: BlockSegment) -> bool:
        return segment.last or segment.sequence == transfer.block_size


@fault("block-upload-repeated-not-marked", Defect.LAST_FLAG, "block-upload.acknowledged")
class RepeatedNotMarked(_Marks):
    """Marks the last segment the first time it is sent only."""

    done: BlockUpload | None = None

    def marked(self, transfer: BlockUpload, segment: BlockSegment) -> bool:
        if not segment.last or self.done is transfer:
            return False
        self.done = transfer
        return True


@fault(
    "block-upload-full-block-ends-with-A1h", Defect.LAST_FLAG, "block-upload.ends-with-sub-block"
)
class FullBlockEndsWrongly(FullBlockNotMarked):
    """Does not mark the last segment of a full sub-block, and answers its acknowledgement by A1h.

    That is the answer to the end of a block download.
    """

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        transfer = self.transfer
        full = isinstance(transfer, BlockUpload) and transfer.sent == transfer.block_size
        responses = super().on_block_ack(request)
        ended = full and isinstance(self.transfer, BlockUpload) and self.transfer.ended
        return [BlockEndResponse()] if ended else responses


@fault(
    "block-upload-unacknowledged-skipped", Defect.LOST_SEGMENTS, "block-upload.acknowledged[first]"
)
class Skipped(ReadsAcknowledgements):
    """Goes on behind a sub-block of which some segments are acknowledged."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        some = 0 < request.sequence < transfer.sent
        return replace(request, sequence=transfer.sent) if some else request


@fault(
    "block-upload-later-unacknowledged-skipped",
    Defect.LOST_SEGMENTS,
    "block-upload.acknowledged-later",
)
class LaterSkipped(Skipped):
    """Goes on behind a later sub-block than the first of which some segments are acknowledged."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        return super().read(transfer, request) if transfer.offset else request


@fault(
    "block-upload-ackseq-0-taken-for-all", Defect.LOST_SEGMENTS, "block-upload.acknowledged[none]"
)
class NoneIsAll(ReadsAcknowledgements):
    """Goes on behind a sub-block of which nothing is acknowledged."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        return request if request.sequence else replace(request, sequence=transfer.sent)


@fault(
    "block-upload-last-lost-ends", Defect.LOST_SEGMENTS, "block-upload.acknowledged[all-but-last]"
)
class LastLostEnds(ReadsAcknowledgements):
    """Sends the end frame though the very last segment is not acknowledged."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        sent = transfer.offset + transfer.sent * SEGMENT_LENGTH
        lost = sent >= len(transfer.data) and request.sequence == transfer.sent - 1
        return replace(request, sequence=transfer.sent) if lost else request


@fault("block-upload-repeats-whole", Defect.LOST_SEGMENTS, "block-upload.acknowledged[first]")
class RepeatsWhole(ReadsAcknowledgements):
    """Repeats the whole sub-block when a segment of it is lost."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        return replace(request, sequence=0) if request.sequence < transfer.sent else request


@fault("block-upload-repeats-from-ackseq", Defect.LOST_SEGMENTS, "block-upload.acknowledged[first]")
class RepeatsFromAckseq(ReadsAcknowledgements):
    """Repeats the last acknowledged segment as well when one behind it is lost."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        some = 0 < request.sequence < transfer.sent
        return replace(request, sequence=request.sequence - 1) if some else request


@fault("block-upload-numbers-from-0", Defect.LOST_SEGMENTS, "block-upload.acknowledged[first]")
class NumbersFrom0(Server):
    """Numbers what it sends again from 0."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        sent = self.transfer.sent if isinstance(self.transfer, BlockUpload) else 0
        again = request.sequence < sent
        return [
            replace(segment, sequence=segment.sequence - again)
            if isinstance(segment, BlockSegment)
            else segment
            for segment in super().on_block_ack(request)
        ]


@fault("block-upload-crc-of-repeated", Defect.LOST_SEGMENTS, "block-upload.acknowledged")
class CrcOfRepeated(Server):
    """Sums up segments that are sent twice twice."""

    def __init__(self, objects: ObjectDictionary) -> None:
        super().__init__(objects)
        self.summed = bytearray()

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        self.summed.clear()
        return super().on_block_upload_initiate(request)

    def block_data(self, transfer: BlockUpload, start: int) -> bytes:
        data = super().block_data(transfer, start)
        self.summed += data
        return data

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        end = super().block_end(transfer)
        return replace(end, crc=crc16(bytes(self.summed))) if transfer.crc else end


@fault(
    "block-upload-third-loss-aborted", Defect.LOST_SEGMENTS, "block-upload.acknowledged-repeatedly"
)
class ThirdLossAborted(ReadsAcknowledgements):
    """Gives a block upload up when segments are lost a third time."""

    losses = 0

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        self.losses = 0
        return super().on_block_upload_initiate(request)

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        self.losses += request.sequence < transfer.sent
        if self.losses > 2:
            raise Refusal(AbortCode.TIMED_OUT)
        return request


class _BlockSizes(ReadsAcknowledgements):
    """Reads the block size of an acknowledgement otherwise, where it is one."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Ask ``size``."""
        if not 1 <= request.block_size <= LARGEST_BLOCK:
            return request
        repeated = request.sequence < transfer.sent
        size = self.size(transfer.block_size, request.block_size, repeated=repeated)
        return replace(request, block_size=size)

    def size(self, old: int, new: int, *, repeated: bool) -> int:
        """Return the size of the next sub-block."""
        del new, repeated
        return old


@fault("block-upload-new-block-size-ignored", Defect.BLOCK_SIZE, "block-upload.block-size-changes")
class NewSizeIgnored(_BlockSizes):
    """Keeps to the block size of the initiate."""


@fault(
    "block-upload-smaller-block-size-ignored", Defect.BLOCK_SIZE, "block-upload.block-size-changes"
)
class SmallerIgnored(_BlockSizes):
    """Ignores a block size in an acknowledgement that is smaller than the last."""

    def size(self, old: int, new: int, *, repeated: bool) -> int:
        return max(old, new)


@fault(
    "block-upload-larger-block-size-ignored", Defect.BLOCK_SIZE, "block-upload.block-size-changes"
)
class LargerIgnored(_BlockSizes):
    """Ignores a block size in an acknowledgement that is larger than the last."""

    def size(self, old: int, new: int, *, repeated: bool) -> int:
        return min(old, new)


@fault(
    "block-upload-block-size-of-retransmission-ignored",
    Defect.BLOCK_SIZE,
    "block-upload.block-size-with-retransmission",
)
class SizeIgnoredWithLoss(_BlockSizes):
    """Ignores the block size of an acknowledgement that reports a loss."""

    def size(self, old: int, new: int, *, repeated: bool) -> int:
        return old if repeated else new


@fault("block-upload-one-segment-more", Defect.BLOCK_SIZE, "block-upload.block-size")
class OneMore(Server):
    """Sends one segment more than the client asked for in the first sub-block."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        responses = super().on_block_upload_initiate(request)
        if isinstance(self.transfer, BlockUpload):
            self.transfer.block_size = min(request.block_size + 1, LARGEST_BLOCK)
        return responses


@fault(
    "block-upload-threshold-in-block-size",
    Defect.BLOCK_SIZE,
    "block-upload.threshold-and-block-size",
)
class ThresholdInBlockSize(Server):
    """Reads the block size of an initiate as 16 bits, with pst for the high byte."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        responses = super().on_block_upload_initiate(request)
        if isinstance(self.transfer, BlockUpload) and request.threshold:
            self.transfer.block_size = LARGEST_BLOCK
        return responses


@fault("block-upload-block-size-kept", Defect.LEAK, "block-upload.block-size[")
class BlockSizeKept(Server):
    """Takes the block size of the block upload before for the first sub-block."""

    size = 0

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        responses = super().on_block_upload_initiate(request)
        if isinstance(self.transfer, BlockUpload):
            self.transfer.block_size = self.size or request.block_size
            self.size = request.block_size
        return responses


@fault("block-upload-all-at-once", Defect.BLOCK_SIZE, "block-upload.block-size")
class AllAtOnce(Server):
    """Sends all segments at once, however few are asked for, and takes no part of them as read."""

    def sub_block(self, transfer: BlockUpload) -> list[Response]:
        transfer.offset, transfer.block_size = 0, LARGEST_BLOCK
        return super().sub_block(transfer)

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockUpload) and request.sequence != transfer.sent:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().on_block_ack(request)
