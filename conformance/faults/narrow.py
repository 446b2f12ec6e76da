"""Servers that break one rule where others break several at once."""

from dataclasses import replace

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    Request,
    Response,
    Unknown,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.segmented_server import EXPEDITED_LENGTH, Download, Upload
from conformance.sdo.server import BlockUpload, Server

STATE = DefectClass.STATE
BLOCK_FRAMES = BlockAck | BlockEnd | BlockEndResponse | BlockUploadStart


@fault("unknown-specifier-ignored-in-download", STATE, "segmented-download.foreign[unknown")
class UnknownIgnoredInDownload(Server):
    """Ignores an unknown command specifier in a segmented download."""

    def react(self, request: Request) -> list[Response]:
        """Go on."""
        ignored = isinstance(self.transfer, Download) and isinstance(request, Unknown)
        return [] if ignored else super().react(request)


@fault("unknown-specifier-ignored-in-upload", STATE, "segmented-upload.foreign[unknown")
class UnknownIgnoredInUpload(Server):
    """Ignores an unknown command specifier in a segmented upload."""

    def react(self, request: Request) -> list[Response]:
        """Go on."""
        ignored = isinstance(self.transfer, Upload) and isinstance(request, Unknown)
        return [] if ignored else super().react(request)


@fault("block-frames-ignored-in-download", STATE, "segmented-download.foreign[block")
class BlockFramesIgnoredInDownload(Server):
    """Ignores the inner frames of a block transfer in a segmented download."""

    def react(self, request: Request) -> list[Response]:
        """Go on."""
        ignored = isinstance(self.transfer, Download) and isinstance(request, BLOCK_FRAMES)
        return [] if ignored else super().react(request)


@fault("block-frames-ignored-in-upload", STATE, "segmented-upload.foreign[block")
class BlockFramesIgnoredInUpload(Server):
    """Ignores the inner frames of a block transfer in a segmented upload."""

    def react(self, request: Request) -> list[Response]:
        """Go on."""
        ignored = isinstance(self.transfer, Upload) and isinstance(request, BLOCK_FRAMES)
        return [] if ignored else super().react(request)


@fault("number-empty-accepted", DefectClass.ZERO_LENGTH, "segmented-download.number-empty")
class NumberEmptyAccepted(Server):
    """Confirms a download of 0 bytes to a number, and does nothing."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Let 0 pass."""
        if size != 0:
            super().check_announced_size(entry, size)

    def store(self, entry: Entry, data: bytes) -> None:
        """Keep the value when there is none."""
        if data or not entry.shortest:
            super().store(entry, data)


@fault("short-text-refused", DefectClass.ACCESS_OR_SIZE, "download.text")
class ShortTextRefused(Server):
    """Refuses an expedited download to a string or domain unless it has 4 bytes."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        """Want all 4."""
        data = super().expedited_data(request, entry)
        if not entry.shortest and len(data) < EXPEDITED_LENGTH:
            raise Refusal(AbortCode.LENGTH_TOO_LOW)
        return data


@fault("upload-of-5-bytes-expedited", DefectClass.FIELD_WIDTH, "segmented-upload.size[5]")
class FiveBytesExpedited(Server):
    """Sends an object of 5 bytes in one frame and leaves out the last."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Be off by one."""
        if len(data) == EXPEDITED_LENGTH + 1:
            return UploadInitiateResponse.with_data(mux, data[:EXPEDITED_LENGTH])
        return super().start_upload(mux, data)


@fault("block-upload-crc-not-offered", DefectClass.CRC, "block-upload.size")
class CrcNotOffered(Server):
    """Says that it computes no CRC and sends one at the end of a block upload."""

    def can_compute_crc(self, request: BlockDownloadInitiate | BlockUploadInitiate) -> bool:
        """Offer none."""
        return False

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        """Send one all the same."""
        return replace(super().block_end(transfer), crc=crc16(transfer.data))


@fault("block-upload-crc-of-nothing", DefectClass.CRC, "block-upload.empty")
class CrcOfNothing(Server):
    """Sends FFFFh for the CRC of a block upload without data."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        """Leave the field as it was."""
        end = super().block_end(transfer)
        return end if transfer.data else replace(end, crc=0xFFFF)
