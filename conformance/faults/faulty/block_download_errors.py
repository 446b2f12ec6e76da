"""Servers that refuse block downloads wrongly."""

from conformance.faults.block_servers import StoresOtherwise
from conformance.faults.registry import Defect, fault
from conformance.reference.server import BlockDownload, Server
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


@fault("block-download-n-not-compared", Defect.UNUSED_COUNT, "block-download.unused-too-many")
class UnusedNotCompared(StoresOtherwise):
    """Stores as many bytes as were announced though n says that fewer count."""

    def check_block_size(self, transfer: BlockDownload, data: bytes) -> None:
        """Do not mind."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        return data if transfer.size is None else bytes(transfer.data[: transfer.size])


@fault("block-download-crc-not-checked", Defect.CRC, "block-download.crc[")
class CrcNotChecked(Server):
    """Offers a CRC and does not check it."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Believe everything."""


@fault("block-download-crc-low-byte", Defect.CRC, "block-download.crc[")
class CrcLowByte(Server):
    """Compares the low byte of the CRC only."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        if transfer.crc and request.crc & 0xFF != crc16(data) & 0xFF:
            raise Refusal(AbortCode.CRC_ERROR)


@fault("block-download-crc-error-and-stored", Defect.CRC, "block-download.number-kept")
class CrcErrorStored(Server):
    """Refuses a wrong CRC after it has stored the data."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        self.store(transfer.entry, data)
        super().check_crc(transfer, request, data)


@fault("block-download-crc-error-confirmed", Defect.ABORT, "block-download.crc[")
class CrcErrorConfirmed(Server):
    """Sends the confirmation behind the abort for a wrong CRC."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        responses = super().refuse(request, code)
        return [*responses, BlockEndResponse()] if code is AbortCode.CRC_ERROR else responses


class _Codes(Server):
    """Aborts block downloads with other codes."""

    codes: dict[AbortCode, AbortCode] = {}

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        if isinstance(request, BlockDownloadInitiate | BlockSegment | BlockEnd):
            code = self.codes.get(code, code)
        return super().refuse(request, code)


@fault("block-download-crc-code-wrong", Defect.CRC, "block-download.crc[")
class CrcCodeWrong(_Codes):
    """Calls a wrong CRC a wrong sequence number."""

    codes = {AbortCode.CRC_ERROR: AbortCode.INVALID_SEQUENCE_NUMBER}


@fault("block-download-read-only-code-wrong", Defect.ACCESS_OR_SIZE, "block-download.read-only")
class ReadOnlyCodeWrong(_Codes):
    """Says write-only where a block download meets a read-only object."""

    codes = {AbortCode.WRITE_OF_READ_ONLY: AbortCode.READ_OF_WRITE_ONLY}


@fault(
    "block-download-missing-object-code-wrong",
    Defect.ACCESS_OR_SIZE,
    "block-download.object-missing",
)
class MissingCodeWrong(_Codes):
    """Calls the object read-only where a block download meets none."""

    codes = {AbortCode.OBJECT_MISSING: AbortCode.WRITE_OF_READ_ONLY}


@fault(
    "block-download-missing-sub-index-code-wrong",
    Defect.ACCESS_OR_SIZE,
    "block-download.sub-index-missing",
)
class MissingSubIndexCodeWrong(_Codes):
    """Says that the object is missing where a block download meets no sub-index."""

    codes = {AbortCode.SUB_INDEX_MISSING: AbortCode.OBJECT_MISSING}


@fault(
    "block-download-length-codes-swapped", Defect.ACCESS_OR_SIZE, "block-download.number-too-long"
)
class LengthCodesSwapped(_Codes):
    """Says too low for too high in block downloads, and the other way round."""

    codes = {
        AbortCode.LENGTH_TOO_HIGH: AbortCode.LENGTH_TOO_LOW,
        AbortCode.LENGTH_TOO_LOW: AbortCode.LENGTH_TOO_HIGH,
    }


@fault(
    "block-download-sub-index-ignored", Defect.ACCESS_OR_SIZE, "block-download.sub-index-missing"
)
class SubIndexIgnored(Server):
    """Writes to the object itself where a block download meets no sub-index."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        try:
            return super().entry_to_write_in_blocks(request)
        except Refusal as refusal:
            if refusal.code is not AbortCode.SUB_INDEX_MISSING:
                raise
            return self.objects.writable(Multiplexer(request.mux.index))


@fault("block-download-read-only-written", Defect.ACCESS_OR_SIZE, "block-download.read-only")
class ReadOnlyWritten(Server):
    """Accepts block downloads to read-only objects."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        return self.objects.find(request.mux)


@fault(
    "block-download-read-only-refused-and-written",
    Defect.ACCESS_OR_SIZE,
    "block-download.read-only",
)
class ReadOnlyRefusedAndWritten(Server):
    """Refuses a block download to 1018h:01 and changes the object all the same."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        if request.mux == Multiplexer(0x1018, 1):
            entry = self.objects.find(request.mux)
            entry.value = bytes([entry.value[0] ^ 1]) + entry.value[1:]
        return super().entry_to_write_in_blocks(request)


@fault(
    "block-download-read-only-written-unsized",
    Defect.ACCESS_OR_SIZE,
    "block-download.read-only-size-not-indicated",
)
class ReadOnlyWrittenUnsized(Server):
    """Looks at who may write only where a block download says its size."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        if request.size is None:
            return self.objects.find(request.mux)
        return super().entry_to_write_in_blocks(request)


class _NoLengths(StoresOtherwise):
    """Makes the data of a block download as long as the type is."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if entry.data_type.length is None:
            super().check_announced_size(entry, size)


@fault(
    "block-download-number-too-long-accepted",
    Defect.ACCESS_OR_SIZE,
    "block-download.number-too-long",
)
class TooLongAccepted(_NoLengths):
    """Cuts a block download that is too long for the type."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        return data[: transfer.entry.longest]


@fault(
    "block-download-number-too-short-accepted",
    Defect.ACCESS_OR_SIZE,
    "block-download.number-too-short",
)
class TooShortAccepted(_NoLengths):
    """Pads a block download that is too short for the type."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        return data.ljust(transfer.entry.shortest, b"\0")


@fault("block-download-too-many-accepted", Defect.ACCESS_OR_SIZE, "block-download.too-many")
class TooManyAccepted(Server):
    """Takes more bytes than a block download has announced."""

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        transfer.data += request.payload

    def check_block_size(self, transfer: BlockDownload, data: bytes) -> None:
        if transfer.size is None or len(data) < transfer.size:
            super().check_block_size(transfer, data)


@fault("block-download-too-few-accepted", Defect.ACCESS_OR_SIZE, "block-download.too-few")
class TooFewAccepted(Server):
    """Takes fewer bytes than a block download has announced."""

    def check_block_size(self, transfer: BlockDownload, data: bytes) -> None:
        if transfer.size is None or len(data) > transfer.size:
            super().check_block_size(transfer, data)


@fault(
    "block-download-too-many-refused-and-stored",
    Defect.ACCESS_OR_SIZE,
    "block-download.too-many",
    soft=True,
)
class TooManyStored(Server):
    """Refuses more bytes than a block download has announced, and stores them."""

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        try:
            super().take_block_segment(transfer, request)
        except Refusal:
            transfer.entry.value = bytes(transfer.data)
            raise


class _DuringDownload(Server):
    """Reacts to a request of another service in a block download, but not by an abort."""

    def on_unexpected(self, request: Request) -> list[Response]:
        """Ask ``on_foreign`` within a block download."""
        if isinstance(self.transfer, BlockDownload):
            return self.on_foreign()
        return super().on_unexpected(request)

    def on_foreign(self) -> list[Response]:
        return []


@fault("block-download-foreign-ignored", Defect.STATE, "block-download.foreign-at-end")
class ForeignIgnored(_DuringDownload):
    """Ignores a request of another service where the end of a block download is due."""


@fault("block-download-foreign-taken-for-end", Defect.STATE, "block-download.foreign-at-end")
class ForeignAsEnd(_DuringDownload):
    """Confirms a block download on any request where its end is due."""

    def on_foreign(self) -> list[Response]:
        self.transfer = None
        return [BlockEndResponse()]
