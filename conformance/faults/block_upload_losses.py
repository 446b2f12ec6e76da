"""Servers that are wrong in block uploads of which segments got lost."""

from dataclasses import replace

from conformance.faults.block_servers import ReadsAcknowledgements
from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.frames import BlockAck, BlockEnd, BlockSegment, BlockUploadInitiate, Response
from conformance.sdo.objects import ObjectDictionary, Refusal
from conformance.sdo.segmented_server import SEGMENT_LENGTH
from conformance.sdo.server import LARGEST_BLOCK, BlockUpload, Server

LOST = DefectClass.LOST_SEGMENTS


@fault("block-upload-unacknowledged-skipped", LOST, "block-upload.acknowledged[first]")
class Skipped(ReadsAcknowledgements):
    """Goes on behind a sub-block of which some segments are acknowledged."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Take some for all."""
        some = 0 < request.sequence < transfer.sent
        return replace(request, sequence=transfer.sent) if some else request


@fault("block-upload-ackseq-0-taken-for-all", LOST, "block-upload.acknowledged[none]")
class NoneIsAll(ReadsAcknowledgements):
    """Goes on behind a sub-block of which nothing is acknowledged."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Take none for all."""
        return request if request.sequence else replace(request, sequence=transfer.sent)


@fault("block-upload-last-lost-ends", LOST, "block-upload.acknowledged[all-but-last]")
class LastLostEnds(ReadsAcknowledgements):
    """Sends the end frame though the very last segment is not acknowledged."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Look at what was sent."""
        sent = transfer.offset + transfer.sent * SEGMENT_LENGTH
        lost = sent >= len(transfer.data) and request.sequence == transfer.sent - 1
        return replace(request, sequence=transfer.sent) if lost else request


@fault("block-upload-repeats-whole", LOST, "block-upload.acknowledged[first]")
class RepeatsWhole(ReadsAcknowledgements):
    """Repeats the whole sub-block when a segment of it is lost."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Take less than all for nothing."""
        return replace(request, sequence=0) if request.sequence < transfer.sent else request


@fault("block-upload-repeats-from-ackseq", LOST, "block-upload.acknowledged[first]")
class RepeatsFromAckseq(ReadsAcknowledgements):
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
class ThirdLossAborted(ReadsAcknowledgements):
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


@fault("block-upload-ackseq-clipped", LOST, "block-upload.acknowledges-too-many")
class AckseqClipped(ReadsAcknowledgements):
    """Takes an acknowledgement of more segments than were sent for one of all."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Clip it."""
        return replace(request, sequence=min(request.sequence, transfer.sent))


@fault("block-upload-ackseq-7-bits", LOST, "block-upload.acknowledges-too-many[128]")
class AckseqMasked(ReadsAcknowledgements):
    """Takes ackseq 128 for 0."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Look at 7 bits."""
        return replace(request, sequence=request.sequence & 0x7F)
