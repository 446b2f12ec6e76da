"""Servers that are right in every single transfer: it takes a history to see the fault.

Random conversations get them there.
"""

from dataclasses import replace
from functools import partial

from conformance.faults import registry
from conformance.faults.registry import About, Defect
from conformance.reference.segmented_server import Download, Upload
from conformance.reference.server import BlockDownload, BlockUpload, Server
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
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import SEGMENT_LENGTH

fault = partial(registry.fault, about=About.HISTORY)


@fault("third-segmented-upload-late", Defect.LEAK, "random.")
class ThirdUploadLate(Server):
    """Drops the first byte of the third segmented upload in a row."""

    in_a_row = 0

    def react(self, request: Request) -> list[Response]:
        if isinstance(request, DownloadInitiate | BlockDownloadInitiate | BlockUploadInitiate):
            self.in_a_row = 0
        return super().react(request)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        if not isinstance(self.transfer, Upload):
            self.in_a_row = 0
            return response
        self.in_a_row += 1
        if self.in_a_row == 3:
            self.transfer.offset = min(1, len(data))
        return response


@fault("block-upload-count-of-some-sizes", Defect.UNUSED_COUNT, "random.")
class CountOfSomeSizes(Server):
    """Says a wrong n at the end of a block upload of some sizes in short sub-blocks."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        """Count with a byte that is used for something else."""
        end = super().block_end(transfer)
        if 130 <= len(transfer.data) % 256 < 190 and transfer.block_size < 8:
            return replace(end, unused=(end.unused + 1) % SEGMENT_LENGTH)
        return end


@fault("block-download-second-gap", Defect.LOST_SEGMENTS, "random.")
class SecondGap(Server):
    """Acknowledges one segment too many at the second gap of a block download."""

    gaps = 0

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        self.gaps = 0
        return super().on_block_download_initiate(request)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        responses = super().on_block_segment(request)
        if responses and isinstance(self.transfer, BlockDownload):
            response = responses[0]
            if isinstance(response, BlockAck) and response.sequence < request.sequence:
                self.gaps += 1
                if self.gaps == 2:
                    return [replace(response, sequence=response.sequence + 1)]
        return responses


@fault("block-upload-crc-after-long-repetition", Defect.CRC, "random.")
class CrcAfterLongRepetition(Server):
    """Spoils the CRC of a block upload when repetitions take more than one sub-block."""

    spoiled = False

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        self.spoiled = False
        return super().on_block_upload_initiate(request)

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Compare what was lost with what the next sub-block holds."""
        transfer = self.transfer
        if isinstance(transfer, BlockUpload):
            self.spoiled |= transfer.sent - request.sequence > request.block_size
        return super().on_block_ack(request)

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        end = super().block_end(transfer)
        return replace(end, crc=end.crc ^ 1) if self.spoiled and transfer.crc else end


@fault("toggle-after-two-aborts", Defect.LEAK, "random.any-frames")
class ToggleAfterTwoAborts(Server):
    """Expects toggle bit 1 first in a transfer behind two that the client aborted."""

    aborted = 0

    def on_abort(self, request: Abort) -> list[Response]:
        self.aborted += isinstance(self.transfer, Download | Upload)
        return super().on_abort(request)

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        responses = super().on_upload_initiate(request)
        if isinstance(self.transfer, Upload) and self.aborted >= 2:
            self.transfer.toggle, self.aborted = 1, 0
        return responses


@fault("block-ack-kept-from-aborted-upload", Defect.LEAK, "random.")
class AckKept(Server):
    """Acknowledges in a block download what the client did in the block upload it aborted."""

    kept: int | None = None

    def on_abort(self, request: Abort) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockUpload):
            self.kept = transfer.offset // SEGMENT_LENGTH
        return super().on_abort(request)

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        ack = super().acknowledge(transfer)
        kept, self.kept = self.kept, None
        return ack if kept is None else replace(ack, sequence=kept)
