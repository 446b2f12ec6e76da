"""Servers that are unusual and right where a block transfer is repeated, restarted or refused."""

from dataclasses import replace

from conformance.faults.block_servers import HearsLastRepeated, ReadsAcknowledgements
from conformance.faults.registry import variant
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    DownloadInitiate,
    Request,
    Response,
    UploadInitiate,
)
from conformance.sdo.objects import DEFAULT_CAPACITY, Entry, Refusal
from conformance.sdo.segmented_server import SEGMENT_LENGTH
from conformance.sdo.server import BlockDownload, BlockUpload, Server


@variant("block-download-refused-inside")
class RefusedInside(Server):
    """Refuses what is longer than 300 bytes in mid-sub-block, and is idle for what still comes."""

    most = 300

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        """Have as much room for other downloads."""
        entry = super().entry_to_write(request)
        entry.capacity = self.most
        return entry

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        """Do not mind what is announced."""
        entry = super().entry_to_write_in_blocks(request)
        entry.capacity = DEFAULT_CAPACITY
        return entry

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        """Count what comes."""
        super().take_block_segment(transfer, request)
        if transfer.entry.data_type.length is None and len(transfer.data) > self.most:
            raise Refusal(AbortCode.OUT_OF_MEMORY)


@variant("last-segment-repeated-ignored")
class LastRepeatedIgnored(HearsLastRepeated):
    """Ignores a last segment that comes again where the end is due."""


@variant("last-segment-repeated-acknowledged")
class LastRepeatedAcknowledged(HearsLastRepeated):
    """Acknowledges a last segment again that comes again where the end is due."""

    def on_repeated(self, transfer: BlockDownload, request: BlockSegment) -> list[Response]:
        """Repeat the answer."""
        return [BlockAck(request.sequence, transfer.block_size)]


@variant("last-segment-repeated-refused")
class LastRepeatedRefused(HearsLastRepeated):
    """Refuses a last segment that comes again where the end is due."""

    def on_repeated(self, transfer: BlockDownload, request: BlockSegment) -> list[Response]:
        """Refuse it."""
        raise Refusal(AbortCode.COMMAND_NOT_VALID)


@variant("old-numbers-refused")
class OldNumbersRefused(Server):
    """Ends a block download whose client goes on behind a gap with the old numbers, from 3 on."""

    old_number = 0

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        """Remember what would be next if the numbers went on."""
        self.old_number = transfer.due if transfer.broken else 0
        return super().acknowledge(transfer)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Refuse it where a new sub-block begins."""
        old_number, self.old_number = self.old_number, 0
        if isinstance(self.transfer, BlockDownload) and request.sequence == old_number > 2:
            raise Refusal(AbortCode.INVALID_SEQUENCE_NUMBER)
        return super().on_block_segment(request)


@variant("threshold-before-block-size")
class ThresholdFirst(Server):
    """Answers a block upload with an ordinary one where pst allows it, whatever the block size."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Look at pst first."""
        data = self.value_to_read(self.objects.readable(request.mux))
        if self.switches_protocol(request, len(data)):
            self.transfer = None
            return [self.start_upload(request.mux, data)]
        return super().on_block_upload_initiate(request)


@variant("largest-size-taken")
class LargestSizeTaken(Server):
    """Takes FFFFFFFFh as the size of a block download for one that is not known."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """See later."""
        super().check_announced_size(entry, None if size == 0xFFFF_FFFF else size)


@variant("size-checked-before-crc")
class SizeBeforeCrc(Server):
    """Looks at the size of a block download before its CRC."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Let the size go first."""
        self.check_block_size(transfer, data)
        super().check_crc(transfer, request, data)


@variant("new-initiate-at-block-end-refused")
class NewInitiateAtEndRefused(Server):
    """Refuses an initiate where the end of a block transfer is due, in the initiate's own name."""

    def react(self, request: Request) -> list[Response]:
        """Refuse it; the transfer ends."""
        transfer = self.transfer
        at_end = isinstance(transfer, BlockDownload | BlockUpload) and transfer.ended
        if at_end and isinstance(
            request, UploadInitiate | DownloadInitiate | BlockUploadInitiate | BlockDownloadInitiate
        ):
            self.transfer = None
            return [Abort(request.mux, AbortCode.DEVICE_STATE)]
        return super().react(request)


@variant("last-block-size-ignored")
class LastBlockSizeIgnored(ReadsAcknowledgements):
    """Ignores the block size in the acknowledgement of the last segment of a block upload."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Put a possible one there."""
        end = transfer.offset + request.sequence * SEGMENT_LENGTH
        last = request.sequence == transfer.sent and end >= len(transfer.data)
        return replace(request, block_size=transfer.block_size) if last else request


@variant("block-frames-called-not-valid", soft=True)
class BlockFramesNotValid(Server):
    """Calls a wrong block size in an acknowledgement, or a bad end frame, not valid (05040001h)."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Replace the code."""
        if isinstance(request, BlockAck | BlockEnd):
            code = AbortCode.COMMAND_NOT_VALID
        return super().refuse(request, code)


@variant("superseded-transfer-aborted")
class SupersededAborted(Server):
    """Aborts a transfer that is superseded on the bus, and serves the new initiate."""

    def react(self, request: Request) -> list[Response]:
        """Say both."""
        superseded = self.transfer
        initiate = isinstance(
            request, UploadInitiate | DownloadInitiate | BlockUploadInitiate | BlockDownloadInitiate
        )
        if superseded is None or not initiate:
            return super().react(request)
        abort = Abort(superseded.mux, AbortCode.DEVICE_STATE)
        try:
            return [abort, *super().react(request)]
        except Refusal as refusal:
            return [abort, *self.refuse(request, refusal.code)]
