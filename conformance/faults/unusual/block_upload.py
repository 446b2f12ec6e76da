"""Servers that are right in block uploads in their own way."""

from dataclasses import replace

from conformance.faults.block_servers import ReadsAcknowledgements
from conformance.faults.registry import unusual
from conformance.reference.server import BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    BlockAck,
    BlockEndResponse,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    Request,
    Response,
)
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.objects import Refusal

CONFIRMED = b"\xa1"


@unusual("block-upload-size-not-indicated")
class UnsizedBlockUploads(Server):
    """Never says how long a block upload is (C4h)."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        return BlockUploadInitiateResponse.with_size(request.mux, None, crc_supported=crc)


@unusual("block-upload-never-switches")
class NeverSwitches(Server):
    """Answers a block upload in blocks whatever pst allows."""

    def switches_protocol(self, request: BlockUploadInitiate, size: int) -> bool:
        return False


@unusual("no-block-upload")
class NoBlockUpload(Server):
    """Has block downloads and no block uploads."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        return self.on_block_initiate(request)


@unusual("empty-value-not-read-in-blocks")
class EmptyNotRead(Server):
    """Refuses a block upload of a value without data."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        if not size:
            raise Refusal(AbortCode.NO_DATA)
        return super().announce_block(request, size, crc)


@unusual("end-of-block-upload-repeated")
class EndRepeated(Server):
    """Sends the end of a block upload again when the acknowledgement before it comes again."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        if isinstance(self.transfer, BlockUpload) and self.transfer.ended:
            return [self.block_end(self.transfer)]
        return super().on_block_ack(request)


@unusual("threshold-before-block-size")
class ThresholdFirst(Server):
    """Answers a block upload with an ordinary one where pst allows it, whatever the block size."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        data = self.value_to_read(self.objects.readable(request.mux))
        if self.switches_protocol(request, len(data)):
            self.transfer = None
            return [self.start_upload(request.mux, data)]
        return super().on_block_upload_initiate(request)


@unusual("last-block-size-ignored")
class LastBlockSizeIgnored(ReadsAcknowledgements):
    """Ignores the block size in the acknowledgement of the last segment of a block upload."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        end = transfer.offset + request.sequence * SEGMENT_LENGTH
        last = request.sequence == transfer.sent and end >= len(transfer.data)
        return replace(request, block_size=transfer.block_size) if last else request


class _OutOfPlaceAtEnd(Server):
    """Treats A1h to A3h, with or without reserved bits, alike where its end is to be confirmed."""

    def react(self, request: Request) -> list[Response]:
        at_end = isinstance(self.transfer, BlockUpload) and self.transfer.ended
        inner = isinstance(request, BlockAck | BlockEndResponse | BlockUploadStart)
        if not (at_end and inner) or request.encode()[:1] == CONFIRMED:
            return super().react(request)
        return self.out_of_place(request)

    def out_of_place(self, request: Request) -> list[Response]:
        """Keep silent."""
        del request
        return []


@unusual("out-of-place-at-block-upload-end-ignored")
class OutOfPlaceIgnored(_OutOfPlaceAtEnd):
    """Ignores A2h, A3h and A5h to A7h where the end of a block upload is to be confirmed."""


@unusual("out-of-place-at-block-upload-end-not-valid")
class OutOfPlaceNotValid(_OutOfPlaceAtEnd):
    """Calls A2h, A3h and A5h to A7h no valid command where the end is to be confirmed."""

    def out_of_place(self, request: Request) -> list[Response]:
        return self.refuse(request, AbortCode.COMMAND_NOT_VALID)


@unusual("out-of-place-at-block-upload-end-out-of-sequence")
class OutOfPlaceOutOfSequence(_OutOfPlaceAtEnd):
    """Calls A2h, A3h and A5h to A7h out of sequence where the end is to be confirmed."""

    def out_of_place(self, request: Request) -> list[Response]:
        return self.refuse(request, AbortCode.INVALID_SEQUENCE_NUMBER)
