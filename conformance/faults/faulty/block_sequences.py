"""Servers in which something of one block transfer shows in the next."""

from conformance.faults.block_servers import KnowsBlockUploads, StoresOtherwise
from conformance.faults.registry import Defect, fault
from conformance.reference.segmented_server import Upload
from conformance.reference.server import BlockDownload, BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockUploadStart,
    Response,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal


@fault("block-upload-buffer-in-block-download", Defect.LEAK, "block-sequence.pairs")
class SharedBuffer(StoresOtherwise):
    """Stores the first bytes of the last block upload with the next block download."""

    read = b""

    def on_block_end_response(self, request: BlockEndResponse) -> list[Response]:
        if isinstance(self.transfer, BlockUpload):
            self.read = self.transfer.data[:2]
        return super().on_block_end_response(request)

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        if transfer.entry.data_type.length is not None:
            return data
        read, self.read = self.read[: len(data)], b""
        return read + data[len(read) :]


@fault("block-download-aborted-kept", Defect.LEAK, "block-sequence.abandoned-download")
class AbortedKept(Server):
    """Puts the first bytes of an aborted block download into the next value of a string."""

    kept = b""

    def on_abort(self, request: Abort) -> list[Response]:
        if isinstance(self.transfer, BlockDownload) and self.transfer.data:
            self.kept = bytes(self.transfer.data[:2])
        return super().on_abort(request)

    def store(self, entry: Entry, data: bytes) -> None:
        if entry.data_type.length is None:
            data, self.kept = self.kept + data[len(self.kept) :], b""
        super().store(entry, data)


@fault("block-download-size-kept", Defect.LEAK, "block-sequence.pairs")
class SizeKept(Server):
    """Holds the size of the last sized block download against one that indicates none."""

    size: int | None = None

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        responses = super().on_block_download_initiate(request)
        transfer = self.transfer
        if isinstance(transfer, BlockDownload):
            transfer.size = self.size if request.size is None else request.size
            self.size = request.size
        return responses


@fault("block-download-aborted-crc-goes-on", Defect.LEAK, "block-sequence.abandoned-download")
class AbortedCrcGoesOn(Server):
    """Starts the CRC of a block download where that of an aborted one was."""

    crc = 0

    def on_abort(self, request: Abort) -> list[Response]:
        if isinstance(self.transfer, BlockDownload):
            self.crc = crc16(bytes(self.transfer.data))
        return super().on_abort(request)

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        before, self.crc = self.crc, 0
        if transfer.crc and request.crc != crc16(data, before):
            raise Refusal(AbortCode.CRC_ERROR)


@fault(
    "block-download-aborted-number-goes-on",
    Defect.LEAK,
    "block-sequence.abandoned-download",
    "block-download.restart",
)
class AbortedNumberGoesOn(Server):
    """Expects the segments of a block download to count on behind those of an aborted one."""

    due = 1

    def on_abort(self, request: Abort) -> list[Response]:
        self.due = self.transfer.due if isinstance(self.transfer, BlockDownload) else 1
        return super().on_abort(request)

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        responses = super().on_block_download_initiate(request)
        if isinstance(self.transfer, BlockDownload):
            self.transfer.due, self.due = self.due, 1
        return responses


@fault("block-download-spoils-segmented-upload", Defect.LEAK, "block-sequence.pairs")
class SpoilsSegmentedUpload(Server):
    """Starts the upload in segments after a block download with its second byte."""

    spoiled = False

    def on_block_end(self, request: BlockEnd) -> list[Response]:
        responses = super().on_block_end(request)
        self.spoiled = True
        return responses

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        if isinstance(self.transfer, Upload):
            self.transfer.offset, self.spoiled = int(self.spoiled), False
        return response


@fault("block-upload-of-old-value", Defect.LEAK, "block-sequence.pairs")
class OldValue(KnowsBlockUploads):
    """Delivers in the block upload behind a block download what was there before."""

    old: tuple[Entry, bytes] | None = None

    def on_block_end(self, request: BlockEnd) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockDownload):
            self.old = (transfer.entry, transfer.entry.value)
        return super().on_block_end(request)

    def value_to_read(self, entry: Entry) -> bytes:
        old, self.old = self.old, None
        if self.in_blocks and old is not None and old[0] is entry:
            return old[1]
        return super().value_to_read(entry)


@fault("block-upload-aborted-goes-on", Defect.LEAK, "block-sequence.abandoned-upload")
class AbortedGoesOn(Server):
    """Starts a block upload where the last one was aborted."""

    offset = 0

    def on_abort(self, request: Abort) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockUpload):
            self.offset = transfer.offset + 7 * transfer.sent
        return super().on_abort(request)

    def on_block_upload_start(self, request: BlockUploadStart) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockUpload) and self.offset < len(transfer.data):
            transfer.offset, self.offset = self.offset, 0
        return super().on_block_upload_start(request)


@fault("block-download-last-flag-sticks", Defect.LEAK, "block-sequence.abandoned-download")
class LastFlagSticks(Server):
    """Expects the end frame of a block download at once after one was aborted."""

    sticks = False

    def on_abort(self, request: Abort) -> list[Response]:
        if isinstance(self.transfer, BlockDownload):
            self.sticks = bool(self.transfer.data)
        return super().on_abort(request)

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        responses = super().on_block_download_initiate(request)
        if isinstance(self.transfer, BlockDownload):
            self.transfer.ended, self.sticks = self.sticks, False
        return responses
