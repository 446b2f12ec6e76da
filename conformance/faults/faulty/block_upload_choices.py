"""Servers that are wrong in block uploads where CiA 301 leaves a choice, but not that one."""

from dataclasses import replace

from conformance.faults.registry import Defect, fault
from conformance.reference.server import BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    INITIATES,
    Abort,
    BlockAck,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    Request,
    Response,
)
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.objects import Refusal


@fault(
    "block-upload-threshold-hides-block-size",
    Defect.BLOCK_SIZE,
    "block-upload.threshold-without-block-size",
)
class ThresholdHidesBlockSize(Server):
    """Serves blocks of 0 segments where pst would allow an ordinary upload."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        if request.block_size or not request.threshold:
            return super().on_block_upload_initiate(request)
        return super().on_block_upload_initiate(replace(request, block_size=127, threshold=0))


@fault(
    "block-upload-acknowledgement-reserved-bit-unanswered",
    Defect.STATE,
    "block-upload.acknowledgement-reserved-bits",
)
class ReservedBitUnanswered(Server):
    """Ignores an acknowledgement with reserved bits, and waits for another."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        return [] if request.reserved_bits else super().on_block_ack(request)


@fault(
    "block-upload-acknowledgement-a6h-skips",
    Defect.LOST_SEGMENTS,
    "block-upload.acknowledgement-reserved-bits",
)
class ReservedBitSkips(Server):
    """Takes reserved bits of an acknowledgement for the number of the first segment to send."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        return [
            replace(response, sequence=response.sequence + request.reserved_bits)
            if isinstance(response, BlockSegment)
            else response
            for response in super().on_block_ack(request)
        ]


@fault(
    "block-upload-abort-in-retransmission-ignored",
    Defect.ABORT,
    "block-upload.early-acknowledgement",
)
class AbortInRetransmissionIgnored(Server):
    """Does not hear an abort while it sends segments again, and sends them once more."""

    repeating = False

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        transfer = self.transfer
        self.repeating = isinstance(transfer, BlockUpload) and request.sequence < transfer.sent
        return super().on_block_ack(request)

    def on_abort(self, request: Abort) -> list[Response]:
        repeating, self.repeating = self.repeating, False
        if repeating and isinstance(self.transfer, BlockUpload):
            return [*self.sub_block(self.transfer), BlockEndResponse()]
        return super().on_abort(request)


@fault(
    "block-upload-acknowledged-at-end-sends-segments",
    Defect.STATE,
    "block-upload.acknowledged-at-end",
)
class SendsSegmentsAtEnd(Server):
    """Sends the last sub-block again when its acknowledgement comes again."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockUpload) and transfer.ended:
            transfer.offset = max(len(transfer.data) - 7, 0)
            return self.sub_block(transfer)
        return super().on_block_ack(request)


@fault("block-upload-crc-abort-repeats", Defect.CRC, "block-upload.crc-refused-by-client")
class CrcAbortRepeats(Server):
    """Sends the end frame again when the client finds the CRC wrong."""

    def on_abort(self, request: Abort) -> list[Response]:
        transfer = self.transfer
        wrong = request.code == AbortCode.CRC_ERROR
        if wrong and isinstance(transfer, BlockUpload) and transfer.ended:
            return [self.block_end(transfer)]
        return super().on_abort(request)


class _OnInitiate(Server):
    """Reacts otherwise to a new initiate in a block upload."""

    def react(self, request: Request) -> list[Response]:
        transfer = self.transfer
        if isinstance(request, INITIATES) and isinstance(transfer, BlockUpload):
            return self.on_initiate(transfer, request)
        return super().react(request)

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        del transfer
        return super().react(request)


@fault("block-upload-new-initiate-unanswered", Defect.STATE, "block-upload.new-initiate-at-start")
class NewInitiateUnanswered(_OnInitiate):
    """Keeps silent on an initiate before a block upload is started."""

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        return super().on_initiate(transfer, request) if transfer.sent else []


@fault(
    "block-upload-new-initiate-confirmed-only",
    Defect.STATE,
    "block-upload.new-initiate-in-the-middle",
)
class ConfirmedOnly(_OnInitiate):
    """Answers a new initiate in the middle of a block upload, and goes on with that."""

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        responses = super().on_initiate(transfer, request)
        if transfer.sent and not transfer.ended:
            self.transfer = transfer
        return responses


@fault("block-upload-end-refuses-initiates", Defect.STATE, "block-upload.new-initiate-at-end")
class EndRefusesInitiates(_OnInitiate):
    """Refuses every initiate until the end of a block upload is confirmed."""

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        if not transfer.ended:
            return super().on_initiate(transfer, request)
        return [Abort(transfer.mux, AbortCode.COMMAND_NOT_VALID)]


@fault("block-upload-same-again-goes-on", Defect.LEAK, "block-upload.same-again")
class SameAgainGoesOn(_OnInitiate):
    """Goes on behind what was sent when the same block upload is initiated again."""

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        responses = super().on_initiate(transfer, request)
        new = self.transfer
        if isinstance(new, BlockUpload) and new.mux == transfer.mux and not transfer.ended:
            last_segment = max(len(new.data) - 1, 0) // SEGMENT_LENGTH * SEGMENT_LENGTH
            new.offset = min(transfer.sent * SEGMENT_LENGTH, last_segment)
        return responses


@fault(
    "block-upload-initiate-at-end-refused-unsaid", Defect.ABORT, "block-upload.new-initiate-at-end"
)
class RefusedOfNothing(_OnInitiate):
    """Refuses an initiate at the end of a block upload with multiplexer 0."""

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        if transfer.ended:
            self.transfer = None
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().on_initiate(transfer, request)

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        responses = super().refuse(request, code)
        if isinstance(request, INITIATES) and code is AbortCode.COMMAND_NOT_VALID:
            return [replace(self.aborted(responses), mux=request.mux._replace(index=0))]
        return responses

    def aborted(self, responses: list[Response]) -> Abort:
        """Return the abort among the responses."""
        (abort,) = (response for response in responses if isinstance(response, Abort))
        return abort
