"""Servers that are wrong in block uploads: CRC, widths, reserved bits and bytes."""

from dataclasses import replace

from conformance.faults.block_servers import KnowsBlockUploads
from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    BlockEnd,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.segmented_server import SEGMENT_LENGTH
from conformance.sdo.server import LARGEST_BLOCK, BlockDownload, BlockUpload, Server

CRC = DefectClass.CRC
SHAPE = DefectClass.FRAME_SHAPE
WIDTH = DefectClass.FIELD_WIDTH
FULL_BLOCK = LARGEST_BLOCK * SEGMENT_LENGTH


class _OwnCrc(Server):
    """Sends a CRC of its own."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        """Replace a CRC that is used."""
        end = super().block_end(transfer)
        return replace(end, crc=self.crc_of(transfer, end)) if transfer.crc else end

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        """Return what is sent."""
        del transfer
        return end.crc


@fault("block-upload-crc-with-fillers", CRC, "block-upload.size[1]")
class CrcWithFillers(_OwnCrc):
    """Sums up the fillers of the last segment of a block upload as well."""

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        """Sum up whole segments."""
        return crc16(transfer.data + bytes(end.unused))


@fault("block-upload-crc-of-last-sub-block", CRC, "block-upload.block-size")
class CrcOfLastSubBlock(_OwnCrc):
    """Sums up the last sub-block of a block upload only."""

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        """Start again with each sub-block."""
        return crc16(transfer.data[transfer.offset - transfer.sent * SEGMENT_LENGTH :])


@fault("block-upload-crc-bytes-swapped", CRC, "block-upload.size")
class CrcSwapped(_OwnCrc):
    """Sends the high byte of the CRC first."""

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        """Turn it round."""
        return int.from_bytes(end.crc.to_bytes(2, "big"), "little")


@fault("block-upload-crc-zero", CRC, "block-upload.size")
class CrcZero(_OwnCrc):
    """Offers a CRC and sends 0."""

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        """Leave it out."""
        return 0


@fault("block-upload-crc-though-unused", CRC, "block-upload.without-crc")
class CrcThoughUnused(Server):
    """Sends a CRC to a client that has none."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        """Do not look at cc."""
        return replace(super().block_end(transfer), crc=crc16(transfer.data))


@fault("block-crc-starts-at-ffff", CRC, "block-upload.size")
class CrcStartsAtFfff(_OwnCrc):
    """Starts the CRC with FFFFh in both directions."""

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        """Start wrongly."""
        return crc16(transfer.data, 0xFFFF)

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Start wrongly."""
        if transfer.crc and request.crc != crc16(data, 0xFFFF):
            raise Refusal(AbortCode.CRC_ERROR)


@fault("block-upload-size-8-bit", WIDTH, "block-upload.size[448]")
class SizeOf8Bits(Server):
    """Announces the low byte of the size only."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        """Cut the size."""
        return super().announce_block(request, size & 0xFF, crc)


@fault("block-upload-size-of-segments", WIDTH, "block-upload.size[1]")
class SizeOfSegments(Server):
    """Announces the size with the fillers of the last segment."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        """Round up."""
        return super().announce_block(request, -(-size // SEGMENT_LENGTH) * SEGMENT_LENGTH, crc)


@fault("block-upload-offset-wraps", WIDTH, "block-upload.size[1777]")
class OffsetWraps(Server):
    """Sends the first 889 bytes again behind them."""

    def block_data(self, transfer: BlockUpload, start: int) -> bytes:
        """Wrap the offset."""
        return super().block_data(transfer, start % FULL_BLOCK)[: len(transfer.data) - start]


@fault("block-upload-text-ends-in-zero", WIDTH, "block-upload.same-as-segmented")
class TextLongerInBlocks(KnowsBlockUploads):
    """Adds a 00h to long strings in block uploads and in no others."""

    def value_to_read(self, entry: Entry) -> bytes:
        """Append it."""
        long = self.in_blocks and len(entry.value) > 7
        return super().value_to_read(entry) + bytes(long)


@fault("block-upload-multiplexer-missing", SHAPE, "block-upload.size")
class MultiplexerMissing(Server):
    """Answers a block upload initiate with multiplexer 0."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        """Forget the object."""
        return replace(super().announce_block(request, size, crc), mux=Multiplexer(0))


@fault("block-upload-size-without-flag", SHAPE, "block-upload.reserved")
class SizeWithoutFlag(Server):
    """Sends the size and does not say so."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        """Clear s."""
        return replace(super().announce_block(request, size, crc), sized=False)


@fault("block-upload-reserved-bit", SHAPE, "block-upload.reserved")
class ReservedBit(Server):
    """Sets a reserved bit in C6h."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        """Set it."""
        return replace(super().announce_block(request, size, crc), reserved_bits=1)


@fault("block-upload-end-echoes-size", SHAPE, "block-upload.reserved")
class EndEchoesSize(Server):
    """Sends the size in the reserved bytes of the end frame."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        """Leave it in the buffer."""
        size = len(transfer.data).to_bytes(5, "little")
        return replace(super().block_end(transfer), reserved=size)


@fault("block-upload-filler-leaks", SHAPE, "block-upload.filler", soft=True)
class FillerLeaks(Server):
    """Fills the last segment with FFh."""

    def block_data(self, transfer: BlockUpload, start: int) -> bytes:
        """Fill it up."""
        return super().block_data(transfer, start).ljust(SEGMENT_LENGTH, b"\xff")
