"""Servers whose one defect is in what they take for the running transfer: it hides much else.

Each was met in servers that others wrote. They leave what they are not about to the class that
follows, so that each can be put together with any other fault.
"""

from dataclasses import replace

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    Request,
    Response,
    Unknown,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
)
from conformance.sdo.segmented_server import EXPEDITED_LENGTH, Download, Transfer, Upload
from conformance.sdo.server import BlockUpload, Server

STATE = DefectClass.STATE
_INITIATES = (DownloadInitiate, UploadInitiate, BlockDownloadInitiate, BlockUploadInitiate)
_OF_DOWNLOADS = (DownloadInitiate, DownloadSegment, BlockDownloadInitiate, BlockEnd)
_OF_UPLOADS = (
    UploadInitiate,
    UploadSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    BlockAck,
    BlockEndResponse,
)


@fault("initiate-joins-running-transfer", STATE, "segmented-download.new-download")
class InitiateJoins(Server):
    """Confirms an initiate in the middle of a segmented transfer, and goes on with the old one."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        """Confirm whatever object it names."""
        if isinstance(self.transfer, Download) and not request.expedited:
            return [DownloadInitiateResponse(request.mux)]
        return super().on_download_initiate(request)

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Announce the object that it names, where segments would follow."""
        running = self.transfer
        if isinstance(running, Upload):
            size = len(self.value_to_read(self.objects.readable(request.mux)))
            if not 1 <= size <= EXPEDITED_LENGTH:
                return [UploadInitiateResponse.with_size(request.mux, size)]
        return super().on_upload_initiate(request)


@fault("upload-and-download-side-by-side", STATE, "segmented-download.new-upload")
class SideBySide(Server):
    """Keeps an upload and a download at the same time, and serves segments of both."""

    parked: Transfer | None = None
    downloads = True

    def react(self, request: Request) -> list[Response]:
        """Turn to the transfer of the direction that the request is of."""
        wanted = isinstance(request, _OF_DOWNLOADS)
        if wanted is not self.downloads and (wanted or isinstance(request, _OF_UPLOADS)):
            self.downloads = wanted
            self.transfer, self.parked = self.parked, self.transfer
        return super().react(request)

    def on_abort(self, request: Abort) -> list[Response]:
        """End both."""
        self.parked = None
        return super().on_abort(request)


@fault("any-frame-continues-block-upload", STATE, "block-upload.not-started")
class AnyFrameContinues(Server):
    """Takes any request in a block upload for the start, the acknowledgement or the confirmation.

    An abort ends it, and an initiate begins another transfer.
    """

    def react(self, request: Request) -> list[Response]:
        """Look at the state alone."""
        transfer = self.transfer
        if isinstance(transfer, BlockUpload) and not isinstance(request, (Abort, *_INITIATES)):
            return super().react(self.due(transfer, request))
        return super().react(request)

    def due(self, transfer: BlockUpload, request: Request) -> Request:
        """Return what is due in the place of anything else."""
        if not transfer.sent:
            return request if isinstance(request, BlockUploadStart) else BlockUploadStart()
        if transfer.ended:
            return request if isinstance(request, BlockEndResponse) else BlockEndResponse()
        if isinstance(request, BlockAck):
            return request
        return BlockAck(transfer.sent, min(transfer.block_size, 127))


@fault("threshold-read-as-block-size", DefectClass.BLOCK_SIZE, "block-upload.threshold")
class ThresholdAsBlockSize(Server):
    """Reads blksize and pst as one number of 16 bits, and numbers segments from 80h on as well."""

    high_byte = 0

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Keep pst for the first sub-block."""
        self.high_byte = request.threshold
        return super().on_block_upload_initiate(replace(request, threshold=0))

    def sub_block(self, transfer: BlockUpload) -> list[Response]:
        """Send more than was asked for at first, and count in all bits of byte 0."""
        asked = transfer.block_size
        if not transfer.sent:
            transfer.block_size |= self.high_byte << 8
        responses = super().sub_block(transfer)
        transfer.block_size = asked
        return [
            Unknown(bytes([response.sequence & 0xFF | response.last << 7]) + response.payload)
            if isinstance(response, BlockSegment)
            else response
            for response in responses
        ]
