"""Servers that are wrong in block uploads about access, aborts, and what belongs where."""

from dataclasses import replace

from conformance.faults.block_servers import KnowsBlockUploads
from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockEnd,
    BlockEndResponse,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.segmented_server import SEGMENT_LENGTH, Upload
from conformance.sdo.server import BlockUpload, Server

ABORT = DefectClass.ABORT
ACCESS = DefectClass.ACCESS_OR_SIZE
STATE = DefectClass.STATE


@fault("block-upload-threshold-0-switches", STATE, "block-upload.threshold[0]")
class Threshold0Switches(Server):
    """Sends up to 20 bytes as an ordinary upload though pst is 0."""

    def switches_protocol(self, request: BlockUploadInitiate, size: int) -> bool:
        """Take 0 for no limit."""
        return (not request.threshold and size <= 20) or super().switches_protocol(request, size)


@fault("block-upload-threshold-not-compared", STATE, "block-upload.threshold[5]")
class ThresholdNotCompared(Server):
    """Sends everything as an ordinary upload when pst is not 0."""

    def switches_protocol(self, request: BlockUploadInitiate, size: int) -> bool:
        """Look at no size."""
        return request.threshold > 0


@fault("block-upload-threshold-counts-segments", STATE, "block-upload.threshold[13]")
class ThresholdInSegments(Server):
    """Rounds pst up to whole segments."""

    def switches_protocol(self, request: BlockUploadInitiate, size: int) -> bool:
        """Compare segments."""
        return 0 < -(-size // SEGMENT_LENGTH) <= -(-request.threshold // SEGMENT_LENGTH)


@fault("block-upload-switched-stuck", STATE, "block-upload.threshold[14]")
class SwitchedStuck(Server):
    """Refuses the segments of an ordinary upload that a block upload became."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Forget the upload."""
        responses = super().on_block_upload_initiate(request)
        if isinstance(self.transfer, Upload):
            self.transfer = None
        return responses


class _Serves(Server):
    """Serves a block upload that has to be refused."""

    code = AbortCode.GENERAL_ERROR

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Make something up."""
        try:
            return super().on_block_upload_initiate(request)
        except Refusal as refusal:
            if refusal.code is not self.code:
                raise
            data = self.made_up(request.mux)
            self.transfer = BlockUpload(
                request.mux, data, request.crc_supported, request.block_size
            )
            return [self.announce_block(request, len(data), crc=True)]

    def made_up(self, mux: Multiplexer) -> bytes:
        """Return what is sent."""
        del mux
        return bytes(4)


@fault("block-upload-write-only-read", ACCESS, "block-upload.write-only")
class WriteOnlyRead(_Serves):
    """Serves block uploads of write-only objects."""

    code = AbortCode.READ_OF_WRITE_ONLY

    def made_up(self, mux: Multiplexer) -> bytes:
        """Read it."""
        return self.objects.find(mux).value


@fault("block-upload-missing-object-zero", ACCESS, "block-upload.object-missing")
class MissingObjectZero(_Serves):
    """Serves block uploads of objects that do not exist, with 0."""

    code = AbortCode.OBJECT_MISSING


@fault("block-upload-sub-index-ignored", ACCESS, "block-upload.sub-index-missing")
class SubIndexIgnored(_Serves):
    """Serves sub-index 0 where a block upload meets no sub-index."""

    code = AbortCode.SUB_INDEX_MISSING

    def made_up(self, mux: Multiplexer) -> bytes:
        """Fall back."""
        return self.objects.find(Multiplexer(mux.index)).value


@fault("block-upload-abort-echoed", ABORT, "block-upload.client-abort")
class AbortEchoed(Server):
    """Sends the abort of a block upload back."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Echo it."""
        running = isinstance(self.transfer, BlockUpload)
        return [*super().on_abort(request), *([request] if running else [])]


@fault("block-upload-abort-ignored", ABORT, "block-upload.client-abort-then-ack")
class AbortIgnored(Server):
    """Goes on with a block upload that the client has aborted."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Ignore it."""
        return [] if isinstance(self.transfer, BlockUpload) else super().on_abort(request)


@fault("block-upload-abort-repeats-end", ABORT, "block-upload.client-abort[before-the-end]")
class AbortRepeatsEnd(Server):
    """Sends the end frame again when the client aborts because of it."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Take it for a wrong CRC."""
        transfer = self.transfer
        super().on_abort(request)
        if isinstance(transfer, BlockUpload) and transfer.ended:
            return [self.block_end(transfer)]
        return []


@fault("block-upload-refused-and-continued", ABORT, "block-upload.acknowledges-too-many")
class RefusedAndContinued(Server):
    """Sends the next sub-block behind the abort for a wrong acknowledgement."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Go on."""
        transfer = self.transfer
        responses = super().refuse(request, code)
        if isinstance(request, BlockAck) and isinstance(transfer, BlockUpload):
            responses += self.sub_block(transfer)
        return responses


@fault("block-upload-end-response-answered", STATE, "block-upload.next-request")
class EndResponseAnswered(Server):
    """Answers the end of a block upload, which is no request."""

    def on_block_end_response(self, request: BlockEndResponse) -> list[Response]:
        """Confirm the confirmation."""
        return [*super().on_block_end_response(request), BlockEndResponse()]


@fault("block-upload-started-by-acknowledgement", STATE, "block-upload.not-started[A2h]")
class StartedByAck(Server):
    """Takes an acknowledgement before the start for the start."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Send the first sub-block."""
        if isinstance(self.transfer, BlockUpload) and not self.transfer.sent:
            return self.sub_block(self.transfer)
        return super().on_block_ack(request)


@fault("block-upload-ended-too-early", STATE, "block-upload.foreign[A1h]")
class EndedEarly(Server):
    """Ends a block upload in silence when its end is confirmed too early."""

    def on_block_end_response(self, request: BlockEndResponse) -> list[Response]:
        """Be idle."""
        self.transfer = None
        return []


@fault("block-upload-started-twice", STATE, "block-upload.foreign[A3h]")
class StartedTwice(Server):
    """Sends the sub-block again when the start comes twice."""

    def on_block_upload_start(self, request: BlockUploadStart) -> list[Response]:
        """Start again."""
        if isinstance(self.transfer, BlockUpload):
            return self.sub_block(self.transfer)
        return super().on_block_upload_start(request)


@fault("block-upload-segments-served", STATE, "block-upload.not-started[60h]")
class SegmentsServed(Server):
    """Serves upload segment requests in a block upload."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Send the first bytes."""
        if isinstance(self.transfer, BlockUpload):
            data = self.transfer.data[:SEGMENT_LENGTH]
            return [UploadSegmentResponse.with_data(data, toggle=request.toggle)]
        return super().on_upload_segment(request)


@fault("block-upload-download-segment-confirmed", STATE, "block-upload.not-started[00h]")
class DownloadSegmentConfirmed(Server):
    """Confirms a download segment in a block upload."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Confirm it."""
        if isinstance(self.transfer, BlockUpload):
            return [DownloadSegmentResponse(request.toggle)]
        return super().on_download_segment(request)


@fault("block-upload-foreign-ignored", STATE, "block-upload.foreign")
class ForeignIgnored(Server):
    """Ignores requests of other services in a block upload."""

    def on_unexpected(self, request: Request) -> list[Response]:
        """Keep silent."""
        return [] if isinstance(self.transfer, BlockUpload) else super().on_unexpected(request)


@fault("block-upload-next-request-lost", DefectClass.BACK_TO_BACK, "block-upload.next-request")
class NextRequestLost(Server):
    """Loses the request right behind the end of a block upload."""

    busy = False

    def receive(self, frame: bytes) -> list[bytes]:
        """Drop one."""
        if self.busy:
            self.busy = False
            return []
        return super().receive(frame)

    def on_block_end_response(self, request: BlockEndResponse) -> list[Response]:
        """Be busy for a while."""
        responses = super().on_block_end_response(request)
        self.busy = True
        return responses


@fault("block-upload-empty-hangs", DefectClass.ZERO_LENGTH, "block-upload.empty")
class EmptyHangs(Server):
    """Announces an object without data and never sends a segment."""

    def on_block_upload_start(self, request: BlockUploadStart) -> list[Response]:
        """Find nothing to send."""
        transfer = self.transfer
        responses = super().on_block_upload_start(request)
        return responses if isinstance(transfer, BlockUpload) and transfer.data else []


@fault("block-upload-byte-for-empty", DefectClass.ZERO_LENGTH, "block-upload.empty")
class ByteForEmpty(Server):
    """Announces no bytes for an object without data and sends one."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        """Count at least one."""
        end = super().block_end(transfer)
        return end if transfer.data else replace(end, unused=SEGMENT_LENGTH - 1)


@fault("block-upload-empty-as-4-bytes", DefectClass.ZERO_LENGTH, "block-upload.empty")
class EmptyAs4BytesInBlocks(KnowsBlockUploads):
    """Uploads an empty object in blocks as 4 bytes 0."""

    def value_to_read(self, entry: Entry) -> bytes:
        """Fill it."""
        value = super().value_to_read(entry)
        return value or bytes(4 * self.in_blocks)
