"""Servers that are wrong in block uploads about access, aborts, and what belongs where."""

from dataclasses import replace

from conformance.faults.block_servers import ReadsAcknowledgements
from conformance.faults.own_clock import AnswersLater
from conformance.faults.registry import Defect, fault
from conformance.reference.node import Node
from conformance.reference.server import BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    INITIATES,
    Abort,
    BlockAck,
    BlockEndResponse,
    BlockSegment,
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
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.objects import Refusal


@fault("block-upload-ackseq-clipped", Defect.LOST_SEGMENTS, "block-upload.acknowledges-too-many")
class AckseqClipped(ReadsAcknowledgements):
    """Takes an acknowledgement of more segments than were sent for one of all."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        return replace(request, sequence=min(request.sequence, transfer.sent))


@fault(
    "block-upload-ackseq-7-bits", Defect.LOST_SEGMENTS, "block-upload.acknowledges-too-many[128]"
)
class AckseqMasked(ReadsAcknowledgements):
    """Takes ackseq 128 for 0."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        return replace(request, sequence=request.sequence & 0x7F)


class _InitiateSizes(Server):
    """Makes a block size that is none right in the initiate."""

    wrong: tuple[int, ...] = ()

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        if request.block_size in self.wrong:
            request = replace(request, block_size=LARGEST_BLOCK)
        return super().on_block_upload_initiate(request)


@fault(
    "block-upload-block-size-0-accepted", Defect.BLOCK_SIZE, "block-upload.invalid-block-size[0]"
)
class Size0Accepted(_InitiateSizes):
    """Takes block size 0 of an initiate for 127."""

    wrong = (0,)


@fault(
    "block-upload-block-size-128-accepted",
    Defect.BLOCK_SIZE,
    "block-upload.invalid-block-size[128]",
)
class Size128Accepted(_InitiateSizes):
    """Takes block sizes beyond 127 of an initiate for 127."""

    wrong = tuple(range(128, 256))


@fault("block-upload-block-size-code-wrong", Defect.BLOCK_SIZE, "block-upload.invalid-block-size")
class SizeCodeWrong(Server):
    """Calls a block size that is none an invalid value."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        wrong = code is AbortCode.INVALID_BLOCK_SIZE
        return super().refuse(request, AbortCode.VALUE_INVALID if wrong else code)


class _AckSizes(ReadsAcknowledgements):
    """Makes a block size that is none right in an acknowledgement."""

    wrong: tuple[int, ...] = ()

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        wrong = request.block_size in self.wrong
        return replace(request, block_size=transfer.block_size) if wrong else request


@fault(
    "block-upload-acknowledged-block-size-0-accepted",
    Defect.BLOCK_SIZE,
    "block-upload.acknowledges-block-size[0]",
)
class AckSize0Accepted(_AckSizes):
    """Keeps the old block size when an acknowledgement states 0."""

    wrong = (0,)


@fault(
    "block-upload-acknowledged-block-size-128-accepted",
    Defect.BLOCK_SIZE,
    "block-upload.acknowledges-block-size[128]",
)
class AckSize128Accepted(_AckSizes):
    """Keeps the old block size when an acknowledgement states more than 127."""

    wrong = tuple(range(128, 256))


class _Serves(Server):
    """Serves a block upload that has to be refused."""

    code = AbortCode.GENERAL_ERROR

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
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
        del mux
        return bytes(4)


@fault("block-upload-write-only-read", Defect.ACCESS_OR_SIZE, "block-upload.write-only")
class WriteOnlyRead(_Serves):
    """Serves block uploads of write-only objects."""

    code = AbortCode.READ_OF_WRITE_ONLY

    def made_up(self, mux: Multiplexer) -> bytes:
        return self.objects.find(mux).value


@fault("block-upload-missing-object-zero", Defect.ACCESS_OR_SIZE, "block-upload.object-missing")
class MissingObjectZero(_Serves):
    """Serves block uploads of objects that do not exist, with 0."""

    code = AbortCode.OBJECT_MISSING


@fault("block-upload-sub-index-ignored", Defect.ACCESS_OR_SIZE, "block-upload.sub-index-missing")
class SubIndexIgnored(_Serves):
    """Serves sub-index 0 where a block upload meets no sub-index."""

    code = AbortCode.SUB_INDEX_MISSING

    def made_up(self, mux: Multiplexer) -> bytes:
        return self.objects.find(Multiplexer(mux.index)).value


@fault("block-upload-abort-echoed", Defect.ABORT, "block-upload.client-abort")
class AbortEchoed(Server):
    """Sends the abort of a block upload back."""

    def on_abort(self, request: Abort) -> list[Response]:
        running = isinstance(self.transfer, BlockUpload)
        return [*super().on_abort(request), *([request] if running else [])]


@fault("block-upload-abort-ignored", Defect.ABORT, "block-upload.client-abort-then-ack")
class AbortIgnored(Server):
    """Goes on with a block upload that the client has aborted."""

    def on_abort(self, request: Abort) -> list[Response]:
        return [] if isinstance(self.transfer, BlockUpload) else super().on_abort(request)


@fault(
    "block-upload-abort-repeats-end", Defect.ABORT, "block-upload.client-abort[block-upload-end]"
)
class AbortRepeatsEnd(Server):
    """Sends the end frame again when the client aborts because of it."""

    def on_abort(self, request: Abort) -> list[Response]:
        transfer = self.transfer
        super().on_abort(request)
        if isinstance(transfer, BlockUpload) and transfer.ended:
            return [self.block_end(transfer)]
        return []


@fault("block-upload-refused-and-continued", Defect.ABORT, "block-upload.acknowledges-too-many")
class RefusedAndContinued(Server):
    """Sends the next sub-block behind the abort for a wrong acknowledgement."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        transfer = self.transfer
        responses = super().refuse(request, code)
        if isinstance(request, BlockAck) and isinstance(transfer, BlockUpload):
            responses += self.sub_block(transfer)
        return responses


@fault("block-upload-started-by-acknowledgement", Defect.STATE, "block-upload.not-started[A2h]")
class StartedByAck(Server):
    """Takes an acknowledgement before the start for the start."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        if isinstance(self.transfer, BlockUpload) and not self.transfer.sent:
            return self.sub_block(self.transfer)
        return super().on_block_ack(request)


@fault("block-upload-ended-too-early", Defect.STATE, "block-upload.foreign[A1h]")
class EndedEarly(Server):
    """Ends a block upload in silence when its end is confirmed too early."""

    def on_block_end_response(self, request: BlockEndResponse) -> list[Response]:
        self.transfer = None
        return []


@fault("block-upload-started-twice", Defect.STATE, "block-upload.foreign[A3h]")
class StartedTwice(Server):
    """Sends the sub-block again when the start comes twice."""

    def on_block_upload_start(self, request: BlockUploadStart) -> list[Response]:
        if isinstance(self.transfer, BlockUpload):
            return self.sub_block(self.transfer)
        return super().on_block_upload_start(request)


@fault("block-upload-segments-served", Defect.STATE, "block-upload.not-started[60h]")
class SegmentsServed(Server):
    """Serves upload segment requests in a block upload."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        if isinstance(self.transfer, BlockUpload):
            data = self.transfer.data[:SEGMENT_LENGTH]
            return [UploadSegmentResponse.with_data(data, toggle=request.toggle)]
        return super().on_upload_segment(request)


@fault("block-upload-download-segment-confirmed", Defect.STATE, "block-upload.not-started[00h]")
class DownloadSegmentConfirmed(Server):
    """Confirms a download segment in a block upload."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        if isinstance(self.transfer, BlockUpload):
            return [DownloadSegmentResponse(request.toggle)]
        return super().on_download_segment(request)


@fault("block-upload-foreign-ignored", Defect.STATE, "block-upload.foreign")
class ForeignIgnored(Server):
    """Ignores requests of other services in a block upload."""

    def on_unexpected(self, request: Request) -> list[Response]:
        return [] if isinstance(self.transfer, BlockUpload) else super().on_unexpected(request)


@fault("any-frame-continues-block-upload", Defect.STATE, "block-upload.not-started")
class AnyFrameContinues(Server):
    """Takes any request in a block upload for the start, the acknowledgement or the confirmation.

    An abort ends it, and an initiate begins another transfer.
    """

    def react(self, request: Request) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockUpload) and not isinstance(request, (Abort, *INITIATES)):
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


@fault(
    "block-upload-start-streams-segments",
    Defect.STATE,
    "segmented-upload.foreign[block-start-A3h]",
)
class StartStreams(AnswersLater):
    """Sends segments one by one when it gets the start of a block upload that there is not.

    Meanwhile it serves what it is asked.
    """

    apart = 0.0011
    """Seconds from one segment to the next."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        is_start = (
            frame.can_id == self.request_id and frame.data[:1] == BlockUploadStart().encode()[:1]
        )
        if not is_start or isinstance(self.server.transfer, BlockUpload):
            return Node.receive(self, frame)
        for sequence in range(1, 31):
            segment = self.respond(BlockSegment(sequence, bytes(SEGMENT_LENGTH)).encode())
            self.held.append((self.now + self.apart * sequence, segment))
        return []
