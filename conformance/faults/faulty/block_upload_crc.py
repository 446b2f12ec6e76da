"""Servers that are wrong in the CRC of block uploads."""

from dataclasses import replace

from conformance.faults.registry import Defect, fault
from conformance.reference.server import BlockDownload, BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.frames import BlockDownloadInitiate, BlockEnd, BlockUploadInitiate
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.objects import Refusal


class _OwnCrc(Server):
    """Sends a CRC of its own."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        end = super().block_end(transfer)
        return replace(end, crc=self.crc_of(transfer, end)) if transfer.crc else end

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        del transfer
        return end.crc


@fault("block-upload-crc-with-fillers", Defect.CRC, "block-upload.size[1]")
class CrcWithFillers(_OwnCrc):
    """Sums up the fillers of the last segment of a block upload as well."""

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        return crc16(transfer.data + bytes(end.unused))


@fault("block-upload-crc-of-last-sub-block", Defect.CRC, "block-upload.block-size")
class CrcOfLastSubBlock(_OwnCrc):
    """Sums up the last sub-block of a block upload only."""

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        return crc16(transfer.data[transfer.offset - transfer.sent * SEGMENT_LENGTH :])


@fault("block-upload-crc-bytes-swapped", Defect.CRC, "block-upload.size")
class CrcSwapped(_OwnCrc):
    """Sends the high byte of the CRC first."""

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        return int.from_bytes(end.crc.to_bytes(2, "big"), "little")


@fault("block-upload-crc-zero", Defect.CRC, "block-upload.size")
class CrcZero(_OwnCrc):
    """Offers a CRC and sends 0."""

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        return 0


@fault("block-upload-crc-though-unused", Defect.CRC, "block-upload.without-crc")
class CrcThoughUnused(Server):
    """Sends a CRC to a client that has none."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        return replace(super().block_end(transfer), crc=crc16(transfer.data))


@fault("block-crc-starts-at-ffff", Defect.CRC, "block-upload.size")
class CrcStartsAtFfff(_OwnCrc):
    """Starts the CRC with FFFFh in both directions."""

    def crc_of(self, transfer: BlockUpload, end: BlockEnd) -> int:
        return crc16(transfer.data, 0xFFFF)

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        if transfer.crc and request.crc != crc16(data, 0xFFFF):
            raise Refusal(AbortCode.CRC_ERROR)


@fault("block-upload-crc-goes-on", Defect.LEAK, "block-upload.again")
class UploadCrcGoesOn(Server):
    """Starts the CRC of a block upload where that of the last one ended."""

    crc = 0

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        end = super().block_end(transfer)
        if transfer.crc:
            self.crc = crc16(transfer.data, self.crc)
            end = replace(end, crc=self.crc)
        return end


@fault("block-upload-crc-not-offered", Defect.CRC, "block-upload.size")
class CrcNotOffered(Server):
    """Says that it computes no CRC and sends one at the end of a block upload."""

    def can_compute_crc(self, request: BlockDownloadInitiate | BlockUploadInitiate) -> bool:
        return False

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        return replace(super().block_end(transfer), crc=crc16(transfer.data))


@fault("block-upload-crc-of-nothing", Defect.CRC, "block-upload.empty")
class CrcOfNothing(Server):
    """Sends FFFFh for the CRC of a block upload without data."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        end = super().block_end(transfer)
        return end if transfer.data else replace(end, crc=0xFFFF)
