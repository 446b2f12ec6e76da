"""Servers that are wrong about long values: more than 65,535 bytes, or no end at all."""

from conformance.faults.block_downloads import StoresOtherwise
from conformance.faults.registry import DefectClass, fault
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    BlockEnd,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    Response,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry
from conformance.sdo.segmented_server import Upload
from conformance.sdo.server import BlockDownload, BlockUpload, Server

WIDTH = DefectClass.FIELD_WIDTH
ENDLESS_AT = 4097
LARGEST_SIZE = 0xFFFF_FFFF


@fault("upload-endless", DefectClass.LAST_FLAG, "segmented-upload.size[4097]")
class UploadEndless(Server):
    """Announces FFFFFFFFh bytes for 4097, sends them over and over, and never marks a last one."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Announce too much."""
        response = super().start_upload(mux, data)
        if len(data) == ENDLESS_AT:
            return UploadInitiateResponse.with_size(mux, LARGEST_SIZE)
        return response

    def next_upload_data(self, transfer: Upload) -> bytes:
        """Start again before the end."""
        if len(transfer.data) == ENDLESS_AT and transfer.offset + 7 >= ENDLESS_AT:
            transfer.offset = 0
        return super().next_upload_data(transfer)


@fault("block-upload-size-16-bit", WIDTH, "block-download.beyond-16-bits")
class UploadSizeOf16Bits(Server):
    """Announces the low 16 bits of the size of a block upload."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        """Mask it."""
        return super().announce_block(request, size & 0xFFFF, crc)


@fault("block-download-offset-16-bit", WIDTH, "block-download.beyond-16-bits")
class OffsetOf16Bits(StoresOtherwise):
    """Starts again at 0 after 65,529 bytes of a block download, 9361 segments."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        """Write over the beginning."""
        over = data[0xFFF9:]
        return over + data[len(over) : 0xFFF9]


@fault("segmented-download-offset-16-bit", WIDTH, "segmented-download.beyond-16-bits")
class SegmentedOffsetOf16Bits(Server):
    """Keeps the last 65,535 bytes of any download."""

    def store(self, entry: Entry, data: bytes) -> None:
        """Cut the beginning off."""
        super().store(entry, data[-0xFFFF:])


@fault("block-upload-offset-16-bit", WIDTH, "block-upload.beyond-16-bits")
class UploadOffsetOf16Bits(Server):
    """Starts again at 0 after 65,536 bytes of a block upload; it has no block downloads."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        """Refuse."""
        self.transfer = None
        return self.on_unexpected(request)

    def block_data(self, transfer: BlockUpload, start: int) -> bytes:
        """Wrap."""
        return super().block_data(transfer, start & 0xFFFF)
