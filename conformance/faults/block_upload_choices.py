"""Servers that are wrong in block uploads where CiA 301 leaves a choice, but not that one."""

from dataclasses import replace

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import LARGEST_BLOCK
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    DownloadInitiate,
    Request,
    Response,
    UploadInitiate,
)
from conformance.sdo.objects import Refusal
from conformance.sdo.server import BlockUpload, Server

STATE = DefectClass.STATE
INITIATES = UploadInitiate | DownloadInitiate | BlockUploadInitiate | BlockDownloadInitiate


@fault(
    "block-upload-threshold-hides-block-size",
    DefectClass.BLOCK_SIZE,
    "block-upload.threshold-without-block-size",
)
class ThresholdHidesBlockSize(Server):
    """Serves blocks of 0 segments where pst would allow an ordinary upload."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Have no need of a block size, and use it."""
        if request.block_size or not request.threshold:
            return super().on_block_upload_initiate(request)
        return super().on_block_upload_initiate(replace(request, block_size=127, threshold=0))


@fault(
    "block-upload-acknowledgement-reserved-bit-unanswered",
    STATE,
    "block-upload.acknowledgement-reserved-bits",
)
class ReservedBitUnanswered(Server):
    """Ignores an acknowledgement with reserved bits, and waits for another."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Compare all of byte 0."""
        return [] if request.reserved_bits else super().on_block_ack(request)


@fault(
    "block-upload-acknowledgement-a6h-skips",
    DefectClass.LOST_SEGMENTS,
    "block-upload.acknowledgement-reserved-bits",
)
class ReservedBitSkips(Server):
    """Takes reserved bits of an acknowledgement for the number of the first segment to send."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Add them."""
        return [
            replace(response, sequence=response.sequence + request.reserved_bits)
            if isinstance(response, BlockSegment)
            else response
            for response in super().on_block_ack(request)
        ]


@fault(
    "block-upload-abort-in-retransmission-ignored",
    DefectClass.ABORT,
    "block-upload.early-acknowledgement",
)
class AbortInRetransmissionIgnored(Server):
    """Does not hear an abort while it sends segments again, and sends them once more."""

    repeating = False

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """See whether something was lost."""
        transfer = self.transfer
        self.repeating = isinstance(transfer, BlockUpload) and request.sequence < transfer.sent
        return super().on_block_ack(request)

    def on_abort(self, request: Abort) -> list[Response]:
        """Be busy."""
        repeating, self.repeating = self.repeating, False
        if repeating and isinstance(self.transfer, BlockUpload):
            return [*self.sub_block(self.transfer), BlockEndResponse()]
        return super().on_abort(request)


@fault(
    "block-upload-acknowledged-at-end-sends-segments",
    STATE,
    "block-upload.acknowledged-at-end",
)
class SendsSegmentsAtEnd(Server):
    """Sends the last sub-block again when its acknowledgement comes again."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Go back."""
        transfer = self.transfer
        if isinstance(transfer, BlockUpload) and transfer.ended:
            transfer.offset = max(len(transfer.data) - 7, 0)
            return self.sub_block(transfer)
        return super().on_block_ack(request)


@fault("block-upload-crc-abort-repeats", DefectClass.CRC, "block-upload.crc-refused-by-client")
class CrcAbortRepeats(Server):
    """Sends the end frame again when the client finds the CRC wrong."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Try again."""
        transfer = self.transfer
        if request.code == AbortCode.CRC_ERROR and isinstance(transfer, BlockUpload):
            return [self.block_end(transfer)]
        return super().on_abort(request)


class _OnInitiate(Server):
    """Reacts otherwise to a new initiate in a block upload."""

    def react(self, request: Request) -> list[Response]:
        """Look for one."""
        transfer = self.transfer
        if isinstance(request, INITIATES) and isinstance(transfer, BlockUpload):
            return self.on_initiate(transfer, request)
        return super().react(request)

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        """React to it."""
        del transfer
        return super().react(request)


@fault(
    "block-upload-new-initiate-unanswered",
    STATE,
    "block-upload.new-initiate-at-start",
)
class NewInitiateUnanswered(_OnInitiate):
    """Keeps silent on an initiate before a block upload is started."""

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        """Wait for the start."""
        return super().on_initiate(transfer, request) if transfer.sent else []


@fault(
    "block-upload-new-initiate-confirmed-only",
    STATE,
    "block-upload.new-initiate-in-the-middle",
)
class ConfirmedOnly(_OnInitiate):
    """Answers a new initiate in the middle of a block upload, and goes on with that."""

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        """Come back to it."""
        responses = super().on_initiate(transfer, request)
        if transfer.sent and not transfer.ended:
            self.transfer = transfer
        return responses


@fault("block-upload-end-refuses-initiates", STATE, "block-upload.new-initiate-at-end")
class EndRefusesInitiates(_OnInitiate):
    """Refuses every initiate until the end of a block upload is confirmed."""

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        """Stay there."""
        if not transfer.ended:
            return super().on_initiate(transfer, request)
        return [Abort(transfer.mux, AbortCode.COMMAND_NOT_VALID)]


@fault("block-upload-same-again-goes-on", DefectClass.LEAK, "block-upload.same-again")
class SameAgainGoesOn(_OnInitiate):
    """Goes on behind what was sent when the same block upload is initiated again."""

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        """Keep the position."""
        responses = super().on_initiate(transfer, request)
        new = self.transfer
        if isinstance(new, BlockUpload) and new.mux == transfer.mux and not transfer.ended:
            new.offset = transfer.sent * 7
        return responses


@fault(
    "block-upload-initiate-at-end-refused-unsaid",
    DefectClass.ABORT,
    "block-upload.new-initiate-at-end",
)
class RefusedOfNothing(_OnInitiate):
    """Refuses an initiate at the end of a block upload with multiplexer 0."""

    def on_initiate(self, transfer: BlockUpload, request: Request) -> list[Response]:
        """Forget what both are about."""
        if transfer.ended:
            self.transfer = None
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().on_initiate(transfer, request)

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Know no object."""
        responses = super().refuse(request, code)
        if isinstance(request, INITIATES) and code is AbortCode.COMMAND_NOT_VALID:
            return [replace(self.aborted(responses), mux=replace(request.mux, index=0))]
        return responses

    def aborted(self, responses: list[Response]) -> Abort:
        """Return the abort among the responses."""
        (abort,) = (response for response in responses if isinstance(response, Abort))
        return abort


@fault("block-upload-all-at-once", DefectClass.BLOCK_SIZE, "block-upload.block-size")
class AllAtOnce(Server):
    """Sends all segments at once, however few are asked for, and takes no part of them as read."""

    def sub_block(self, transfer: BlockUpload) -> list[Response]:
        """Have no sub-blocks."""
        transfer.offset, transfer.block_size = 0, LARGEST_BLOCK
        return super().sub_block(transfer)

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Wait for the number of the last segment."""
        transfer = self.transfer
        if isinstance(transfer, BlockUpload) and request.sequence != transfer.sent:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().on_block_ack(request)
