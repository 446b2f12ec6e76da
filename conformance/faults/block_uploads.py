"""Servers that are wrong in block uploads: counts, flags, lost segments, block sizes."""

from dataclasses import replace

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    BlockAck,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    Request,
    Response,
)
from conformance.sdo.objects import ObjectDictionary, Refusal
from conformance.sdo.segmented_server import SEGMENT_LENGTH
from conformance.sdo.server import LARGEST_BLOCK, BlockUpload, Server

COUNT = DefectClass.UNUSED_COUNT
FLAG = DefectClass.LAST_FLAG
LOST = DefectClass.LOST_SEGMENTS
BLOCK_SIZE = DefectClass.BLOCK_SIZE


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


class _Acks(Server):
    """Reads acknowledgements otherwise."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Pass each through ``read`` while segments are on their way."""
        transfer = self.transfer
        if isinstance(transfer, BlockUpload) and transfer.sent and not transfer.ended:
            request = self.read(transfer, request)
        return super().on_block_ack(request)

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Return what is made of it."""
        del transfer
        return request


@fault("block-upload-unacknowledged-skipped", LOST, "block-upload.acknowledged[first]")
class Skipped(_Acks):
    """Goes on behind a sub-block of which some segments are acknowledged."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Take some for all."""
        some = 0 < request.sequence < transfer.sent
        return replace(request, sequence=transfer.sent) if some else request


@fault("block-upload-ackseq-0-taken-for-all", LOST, "block-upload.acknowledged[none]")
class NoneIsAll(_Acks):
    """Goes on behind a sub-block of which nothing is acknowledged."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Take none for all."""
        return request if request.sequence else replace(request, sequence=transfer.sent)


@fault("block-upload-last-lost-ends", LOST, "block-upload.acknowledged[all-but-last]")
class LastLostEnds(_Acks):
    """Sends the end frame though the very last segment is not acknowledged."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Look at what was sent."""
        sent = transfer.offset + transfer.sent * SEGMENT_LENGTH
        lost = sent >= len(transfer.data) and request.sequence == transfer.sent - 1
        return replace(request, sequence=transfer.sent) if lost else request


@fault("block-upload-repeats-whole", LOST, "block-upload.acknowledged[first]")
class RepeatsWhole(_Acks):
    """Repeats the whole sub-block when a segment of it is lost."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Take less than all for nothing."""
        return replace(request, sequence=0) if request.sequence < transfer.sent else request


@fault("block-upload-repeats-from-ackseq", LOST, "block-upload.acknowledged[first]")
class RepeatsFromAckseq(_Acks):
    """Repeats the last acknowledged segment as well when one behind it is lost."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Be off by one."""
        some = 0 < request.sequence < transfer.sent
        return replace(request, sequence=request.sequence - 1) if some else request


@fault("block-upload-numbering-goes-on", LOST, "block-upload.acknowledged[first]")
class NumberingGoesOn(Server):
    """Repeats lost segments under their old numbers."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Do not start at 1 again."""
        sent = self.transfer.sent if isinstance(self.transfer, BlockUpload) else 0
        first = request.sequence if request.sequence < sent else 0
        return [
            replace(segment, sequence=segment.sequence + first)
            if isinstance(segment, BlockSegment)
            else segment
            for segment in super().on_block_ack(request)
            if not isinstance(segment, BlockSegment) or segment.sequence + first <= LARGEST_BLOCK
        ]


@fault("block-upload-crc-of-repeated", LOST, "block-upload.acknowledged")
class CrcOfRepeated(Server):
    """Sums up segments that are sent twice twice."""

    def __init__(self, objects: ObjectDictionary) -> None:
        """Have sent nothing."""
        super().__init__(objects)
        self.summed = bytearray()

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Sum up anew."""
        self.summed.clear()
        return super().on_block_upload_initiate(request)

    def block_data(self, transfer: BlockUpload, start: int) -> bytes:
        """Sum up what is sent."""
        data = super().block_data(transfer, start)
        self.summed += data
        return data

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        """Send the sum."""
        end = super().block_end(transfer)
        return replace(end, crc=crc16(bytes(self.summed))) if transfer.crc else end


@fault("block-upload-third-loss-aborted", LOST, "block-upload.acknowledged-repeatedly")
class ThirdLossAborted(_Acks):
    """Gives a block upload up when segments are lost a third time."""

    losses = 0

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Count anew."""
        self.losses = 0
        return super().on_block_upload_initiate(request)

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Count."""
        self.losses += request.sequence < transfer.sent
        if self.losses > 2:
            raise Refusal(AbortCode.TIMED_OUT)
        return request


class _BlockSizes(_Acks):
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


@fault("block-upload-new-block-size-ignored", BLOCK_SIZE, "block-upload.block-size-changes")
class NewSizeIgnored(_BlockSizes):
    """Keeps to the block size of the initiate."""


@fault("block-upload-smaller-block-size-ignored", BLOCK_SIZE, "block-upload.block-size-changes")
class SmallerIgnored(_BlockSizes):
    """Ignores a block size in an acknowledgement that is smaller than the last."""

    def size(self, old: int, new: int, *, repeated: bool) -> int:
        """Keep the larger."""
        return max(old, new)


@fault("block-upload-larger-block-size-ignored", BLOCK_SIZE, "block-upload.block-size-changes")
class LargerIgnored(_BlockSizes):
    """Ignores a block size in an acknowledgement that is larger than the last."""

    def size(self, old: int, new: int, *, repeated: bool) -> int:
        """Keep the smaller."""
        return min(old, new)


@fault(
    "block-upload-block-size-of-retransmission-ignored",
    BLOCK_SIZE,
    "block-upload.block-size-with-retransmission",
)
class SizeIgnoredWithLoss(_BlockSizes):
    """Ignores the block size of an acknowledgement that reports a loss."""

    def size(self, old: int, new: int, *, repeated: bool) -> int:
        """Keep the old one for what is sent again."""
        return old if repeated else new


@fault("block-upload-one-segment-more", BLOCK_SIZE, "block-upload.block-size")
class OneMore(Server):
    """Sends one segment more than the client asked for in the first sub-block."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Be off by one."""
        responses = super().on_block_upload_initiate(request)
        if isinstance(self.transfer, BlockUpload):
            self.transfer.block_size = min(request.block_size + 1, LARGEST_BLOCK)
        return responses


class _InitiateSizes(Server):
    """Makes a block size that is none right in the initiate."""

    wrong: tuple[int, ...] = ()

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Take 127 for it."""
        if request.block_size in self.wrong:
            request = replace(request, block_size=LARGEST_BLOCK)
        return super().on_block_upload_initiate(request)


@fault("block-upload-block-size-0-accepted", BLOCK_SIZE, "block-upload.invalid-block-size[0]")
class Size0Accepted(_InitiateSizes):
    """Takes block size 0 of an initiate for 127."""

    wrong = (0,)


@fault("block-upload-block-size-128-accepted", BLOCK_SIZE, "block-upload.invalid-block-size[128]")
class Size128Accepted(_InitiateSizes):
    """Takes block sizes beyond 127 of an initiate for 127."""

    wrong = tuple(range(128, 256))


@fault("block-upload-block-size-code-wrong", BLOCK_SIZE, "block-upload.invalid-block-size")
class SizeCodeWrong(Server):
    """Calls a block size that is none an invalid value."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Replace the code."""
        wrong = code is AbortCode.INVALID_BLOCK_SIZE
        return super().refuse(request, AbortCode.VALUE_INVALID if wrong else code)


class _AckSizes(_Acks):
    """Makes a block size that is none right in an acknowledgement."""

    wrong: tuple[int, ...] = ()

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Keep the old one for it."""
        wrong = request.block_size in self.wrong
        return replace(request, block_size=transfer.block_size) if wrong else request


@fault(
    "block-upload-acknowledged-block-size-0-accepted",
    BLOCK_SIZE,
    "block-upload.acknowledges-block-size[0]",
)
class AckSize0Accepted(_AckSizes):
    """Keeps the old block size when an acknowledgement states 0."""

    wrong = (0,)


@fault(
    "block-upload-acknowledged-block-size-128-accepted",
    BLOCK_SIZE,
    "block-upload.acknowledges-block-size[128]",
)
class AckSize128Accepted(_AckSizes):
    """Keeps the old block size when an acknowledgement states more than 127."""

    wrong = tuple(range(128, 256))


@fault("block-upload-ackseq-clipped", LOST, "block-upload.acknowledges-too-many")
class AckseqClipped(_Acks):
    """Takes an acknowledgement of more segments than were sent for one of all."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Clip it."""
        return replace(request, sequence=min(request.sequence, transfer.sent))


@fault("block-upload-ackseq-7-bits", LOST, "block-upload.acknowledges-too-many[128]")
class AckseqMasked(_Acks):
    """Takes ackseq 128 for 0."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Look at 7 bits."""
        return replace(request, sequence=request.sequence & 0x7F)
