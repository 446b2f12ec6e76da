"""Servers that are wrong in what they refuse in a block download: CRC, access, sizes."""

from conformance.faults.block_downloads import StoresOtherwise
from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    Request,
    Response,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.segmented_server import SEGMENT_LENGTH
from conformance.sdo.server import LARGEST_BLOCK, BlockDownload, Server

ABORT = DefectClass.ABORT
ACCESS = DefectClass.ACCESS_OR_SIZE
CRC = DefectClass.CRC
FULL_BLOCK = LARGEST_BLOCK * SEGMENT_LENGTH


class _OwnCrc(Server):
    """Holds block downloads to a CRC of its own."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Compare with ``crc_of`` where there is a CRC."""
        if transfer.crc and request.crc != self.crc_of(transfer, data):
            raise Refusal(AbortCode.CRC_ERROR)

    def crc_of(self, transfer: BlockDownload, data: bytes) -> int:
        """Return the CRC that is due."""
        del transfer
        return crc16(data)


@fault("block-download-crc-starts-at-ffff", CRC, "block-download.size")
class CrcStartsAtFfff(_OwnCrc):
    """Starts the CRC of a block download with FFFFh."""

    def crc_of(self, transfer: BlockDownload, data: bytes) -> int:
        """Start wrongly."""
        return crc16(data, 0xFFFF)


@fault("block-download-crc-with-fillers", CRC, "block-download.size[1]")
class CrcWithFillers(_OwnCrc):
    """Sums up the fillers of the last segment of a block download as well."""

    def crc_of(self, transfer: BlockDownload, data: bytes) -> int:
        """Do not look at n."""
        return crc16(bytes(transfer.data))


@fault("block-download-crc-of-last-sub-block", CRC, "block-download.size[1777]")
class CrcOfLastSubBlock(_OwnCrc):
    """Sums up the last sub-block of a block download only."""

    def crc_of(self, transfer: BlockDownload, data: bytes) -> int:
        """Start again with each sub-block."""
        return crc16(data[max(len(data) - 1, 0) // FULL_BLOCK * FULL_BLOCK :])


@fault("block-download-crc-bytes-swapped", CRC, "block-download.size")
class CrcSwapped(_OwnCrc):
    """Expects the high byte of the CRC first."""

    def crc_of(self, transfer: BlockDownload, data: bytes) -> int:
        """Turn it round."""
        return int.from_bytes(crc16(data).to_bytes(2, "big"), "little")


@fault("block-download-crc-not-checked", CRC, "block-download.crc[")
class CrcNotChecked(Server):
    """Offers a CRC and does not check it."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Believe everything."""


@fault("block-download-crc-low-byte", CRC, "block-download.crc[")
class CrcLowByte(Server):
    """Compares the low byte of the CRC only."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Ignore the high byte."""
        if transfer.crc and request.crc & 0xFF != crc16(data) & 0xFF:
            raise Refusal(AbortCode.CRC_ERROR)


@fault("block-download-crc-always-checked", CRC, "block-download.without-crc")
class CrcAlwaysChecked(Server):
    """Checks the CRC of a client that has none."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Do not look at cc."""
        if request.crc != crc16(data):
            raise Refusal(AbortCode.CRC_ERROR)


@fault("block-download-crc-unused-checked", CRC, "block-download.crc-unused")
class CrcUnusedChecked(Server):
    """Checks the CRC of a client that has none, unless the field is 0."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Do not look at cc."""
        if (transfer.crc or request.crc) and request.crc != crc16(data):
            raise Refusal(AbortCode.CRC_ERROR)


@fault("block-download-crc-error-and-stored", CRC, "block-download.number-kept")
class CrcErrorStored(Server):
    """Refuses a wrong CRC after it has stored the data."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Store first."""
        self.store(transfer.entry, data)
        super().check_crc(transfer, request, data)


@fault("block-download-crc-error-confirmed", ABORT, "block-download.crc[")
class CrcErrorConfirmed(Server):
    """Sends the confirmation behind the abort for a wrong CRC."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Add A1h."""
        responses = super().refuse(request, code)
        return [*responses, BlockEndResponse()] if code is AbortCode.CRC_ERROR else responses


class _Codes(Server):
    """Aborts block downloads with other codes."""

    codes: dict[AbortCode, AbortCode] = {}  # noqa: RUF012 - subclasses replace it

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Replace the code."""
        if isinstance(request, BlockDownloadInitiate | BlockSegment | BlockEnd):
            code = self.codes.get(code, code)
        return super().refuse(request, code)


@fault("block-download-crc-code-wrong", CRC, "block-download.crc[")
class CrcCodeWrong(_Codes):
    """Calls a wrong CRC a wrong sequence number."""

    codes = {AbortCode.CRC_ERROR: AbortCode.INVALID_SEQUENCE_NUMBER}  # noqa: RUF012


@fault("block-download-read-only-code-wrong", ACCESS, "block-download.read-only")
class ReadOnlyCodeWrong(_Codes):
    """Says write-only where a block download meets a read-only object."""

    codes = {AbortCode.WRITE_OF_READ_ONLY: AbortCode.READ_OF_WRITE_ONLY}  # noqa: RUF012


@fault("block-download-missing-object-code-wrong", ACCESS, "block-download.object-missing")
class MissingCodeWrong(_Codes):
    """Calls the object read-only where a block download meets none."""

    codes = {AbortCode.OBJECT_MISSING: AbortCode.WRITE_OF_READ_ONLY}  # noqa: RUF012


@fault("block-download-missing-sub-index-code-wrong", ACCESS, "block-download.sub-index-missing")
class MissingSubIndexCodeWrong(_Codes):
    """Says that the object is missing where a block download meets no sub-index."""

    codes = {AbortCode.SUB_INDEX_MISSING: AbortCode.OBJECT_MISSING}  # noqa: RUF012


@fault("block-download-length-codes-swapped", ACCESS, "block-download.number-too-long")
class LengthCodesSwapped(_Codes):
    """Says too low for too high in block downloads, and the other way round."""

    codes = {  # noqa: RUF012
        AbortCode.LENGTH_TOO_HIGH: AbortCode.LENGTH_TOO_LOW,
        AbortCode.LENGTH_TOO_LOW: AbortCode.LENGTH_TOO_HIGH,
    }


@fault("block-download-sub-index-ignored", ACCESS, "block-download.sub-index-missing")
class SubIndexIgnored(Server):
    """Writes to the object itself where a block download meets no sub-index."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        """Fall back to sub-index 0, where that can be written."""
        try:
            return super().entry_to_write_in_blocks(request)
        except Refusal as refusal:
            if refusal.code is not AbortCode.SUB_INDEX_MISSING:
                raise
            return self.objects.writable(Multiplexer(request.mux.index))


@fault("block-download-read-only-written", ACCESS, "block-download.read-only")
class ReadOnlyWritten(Server):
    """Accepts block downloads to read-only objects."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        """Forget the access."""
        return self.objects.find(request.mux)


@fault("block-download-read-only-refused-and-written", ACCESS, "block-download.read-only")
class ReadOnlyRefusedAndWritten(Server):
    """Refuses a block download to 1018h:01 and changes the object all the same."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        """Write before the check."""
        if request.mux == Multiplexer(0x1018, 1):
            entry = self.objects.find(request.mux)
            entry.value = bytes([entry.value[0] ^ 1]) + entry.value[1:]
        return super().entry_to_write_in_blocks(request)


@fault("block-download-write-only-refused", ACCESS, "block-download.write-only")
class WriteOnlyRefused(Server):
    """Refuses block downloads to what cannot be read."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        """Ask for read access, wrongly."""
        self.objects.readable(request.mux)
        return super().entry_to_write_in_blocks(request)


class _NoLengths(StoresOtherwise):
    """Makes the data of a block download as long as the type is."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Take any size for numbers."""
        if entry.data_type.length is None:
            super().check_announced_size(entry, size)


@fault("block-download-number-too-long-accepted", ACCESS, "block-download.number-too-long")
class TooLongAccepted(_NoLengths):
    """Cuts a block download that is too long for the type."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        """Take what fits."""
        return data[: transfer.entry.longest]


@fault("block-download-number-too-short-accepted", ACCESS, "block-download.number-too-short")
class TooShortAccepted(_NoLengths):
    """Pads a block download that is too short for the type."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        """Fill up with 0."""
        return data.ljust(transfer.entry.shortest, b"\0")


@fault("block-download-too-many-accepted", ACCESS, "block-download.too-many")
class TooManyAccepted(Server):
    """Takes more bytes than a block download has announced."""

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        """Take everything."""
        transfer.data += request.payload

    def check_block_size(self, transfer: BlockDownload, data: bytes) -> None:
        """Mind fewer bytes only."""
        if transfer.size is None or len(data) < transfer.size:
            super().check_block_size(transfer, data)


@fault("block-download-too-few-accepted", ACCESS, "block-download.too-few")
class TooFewAccepted(Server):
    """Takes fewer bytes than a block download has announced."""

    def check_block_size(self, transfer: BlockDownload, data: bytes) -> None:
        """Mind more bytes only."""
        if transfer.size is None or len(data) > transfer.size:
            super().check_block_size(transfer, data)


@fault("block-download-too-many-refused-and-stored", ACCESS, "block-download.too-many", soft=True)
class TooManyStored(Server):
    """Refuses more bytes than a block download has announced, and stores them."""

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        """Write through."""
        try:
            super().take_block_segment(transfer, request)
        except Refusal:
            transfer.entry.value = bytes(transfer.data)
            raise
