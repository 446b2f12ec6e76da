"""Servers that are wrong in block downloads where CiA 301 leaves a choice, but not that one."""

from conformance.faults.block_servers import HearsLastRepeated, StoresOtherwise
from conformance.faults.registry import Defect, fault
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    DownloadInitiate,
    Request,
    Response,
    UploadInitiate,
)
from conformance.sdo.objects import Entry, Refusal

LARGEST_SIZE = 0xFFFF_FFFF


@fault("block-download-largest-size-unanswered", Defect.ROBUSTNESS, "block-download.largest-size")
class LargestSizeUnanswered(Server):
    """Does not answer a block download of FFFFFFFFh bytes."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        super().check_announced_size(entry, None if size == LARGEST_SIZE else size)

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        responses = super().on_block_download_initiate(request)
        return [] if request.size == LARGEST_SIZE else responses


@fault(
    "block-download-old-numbers-acknowledged", Defect.LOST_SEGMENTS, "block-download.old-numbers"
)
class OldNumbersAcknowledged(Server):
    """Acknowledges segments under their old numbers, and has not stored them."""

    last_acknowledged = 0

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        """Remember where the old numbers go on."""
        ack = super().acknowledge(transfer)
        self.last_acknowledged = ack.sequence
        return ack

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        transfer = self.transfer
        if not isinstance(transfer, BlockDownload) or not request.last or transfer.due > 1:
            return super().on_block_segment(request)
        if not 0 < self.last_acknowledged < request.sequence:
            return super().on_block_segment(request)
        transfer.ended = True
        return [BlockAck(request.sequence, transfer.block_size)]


class _SmallBlocks(Server):
    """Asks for sub-blocks of 4 segments."""

    def next_block_size(self) -> int:
        return 4


@fault(
    "block-download-beyond-block-size-stored", Defect.BLOCK_SIZE, "block-download.beyond-block-size"
)
class BeyondBlockSizeStored(_SmallBlocks, StoresOtherwise):
    """Stores a segment with a number beyond the block size in front of the others."""

    beyond = b""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        self.beyond = b""
        return super().on_block_download_initiate(request)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and request.sequence > transfer.block_size:
            self.beyond = request.payload
            return []
        return super().on_block_segment(request)

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        return self.beyond + data[len(self.beyond) :]


@fault("block-download-unoffered-crc-checked", Defect.CRC, "block-download.crc-not-offered")
class UnofferedCrcChecked(Server):
    """Offers no CRC, and takes a field that is not 0 for a wrong one."""

    def can_compute_crc(self, request: BlockDownloadInitiate | BlockUploadInitiate) -> bool:
        return False

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        if request.crc:
            raise Refusal(AbortCode.CRC_ERROR)


@fault("block-download-two-errors-cancel-out", Defect.CRC, "block-download.crc-and-size-wrong")
class TwoErrorsCancelOut(Server):
    """Confirms the end of a block download when both its CRC and its size are wrong."""

    def on_block_end(self, request: BlockEnd) -> list[Response]:
        transfer = self.transfer
        if not isinstance(transfer, BlockDownload) or not transfer.ended:
            return super().on_block_end(request)
        data = bytes(transfer.data[: len(transfer.data) - request.unused])
        if self.is_wrong(transfer, request, data) and len(data) != transfer.size:
            self.transfer = None
            return [BlockEndResponse()]
        return super().on_block_end(request)

    def is_wrong(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> bool:
        """Say whether the CRC does not match."""
        try:
            self.check_crc(transfer, request, data)
        except Refusal:
            return True
        return False


@fault(
    "block-download-last-repeated-stored",
    Defect.LOST_SEGMENTS,
    "block-download.last-segment-repeated",
)
class LastRepeatedStored(HearsLastRepeated, StoresOtherwise):
    """Stores a last segment that comes again where the end is due a second time."""

    repeated = b""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Forget what came in an earlier transfer."""
        self.repeated = b""
        return super().on_block_segment(request)

    def on_repeated(self, transfer: BlockDownload, request: BlockSegment) -> list[Response]:
        self.repeated = request.payload
        return super().on_repeated(transfer, request)

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        return data + self.repeated


@fault("block-download-last-repeated-ends", Defect.STATE, "block-download.last-segment-repeated")
class LastRepeatedEnds(HearsLastRepeated):
    """Acknowledges a last segment that comes again as the first of another sub-block."""

    def on_repeated(self, transfer: BlockDownload, request: BlockSegment) -> list[Response]:
        del request
        return [BlockAck(0, transfer.block_size)]


@fault(
    "block-download-end-reserved-bit-counted",
    Defect.UNUSED_COUNT,
    "block-download.end-reserved-bit",
)
class ReservedBitCounted(StoresOtherwise):
    """Takes the reserved bit of the end frame for a bit of n when it stores the data."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        unused = request.unused << 1 | request.reserved_bits
        return bytes(transfer.data[: len(transfer.data) - unused]) if unused & 1 else data


@fault("block-download-stored-by-new-initiate", Defect.STATE, "block-download.new-initiate-at-end")
class StoredByNewInitiate(Server):
    """Goes on with a block download that a new initiate has ended, when its end comes late."""

    old: BlockDownload | None = None

    def react(self, request: Request) -> list[Response]:
        running = self.transfer
        initiate = isinstance(request, UploadInitiate | DownloadInitiate | BlockUploadInitiate)
        if initiate and isinstance(running, BlockDownload) and running.ended:
            self.old = running
        if isinstance(request, BlockEnd) and self.transfer is None and self.old is not None:
            self.transfer, self.old = self.old, None
        return super().react(request)


@fault("block-download-new-initiate-unanswered", Defect.STATE, "block-download.new-initiate-at-end")
class NewInitiateUnanswered(Server):
    """Keeps silent on an initiate where the end of a block download is due."""

    def react(self, request: Request) -> list[Response]:
        transfer = self.transfer
        initiate = isinstance(
            request, UploadInitiate | DownloadInitiate | BlockUploadInitiate | BlockDownloadInitiate
        )
        if initiate and isinstance(transfer, BlockDownload) and transfer.ended:
            return []
        return super().react(request)
