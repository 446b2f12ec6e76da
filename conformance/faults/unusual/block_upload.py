"""Servers that are right in block uploads in their own way."""

from dataclasses import replace

from conformance.faults.block_servers import ReadsAcknowledgements
from conformance.faults.own_clock import AnswersLater
from conformance.faults.registry import About, unusual
from conformance.reference.node import Node
from conformance.reference.server import BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    Request,
    Response,
)
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
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


@unusual("block-upload-numbering-goes-on", soft=True)
class NumberingGoesOn(Server):
    """Numbers what it sends again behind the acknowledged number, up to 127."""

    before = 0

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        self.before = 0
        return super().on_block_upload_initiate(request)

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        transfer = self.transfer
        if not isinstance(transfer, BlockUpload) or not transfer.sent or transfer.ended:
            return super().on_block_ack(request)
        count = max(request.sequence - self.before, 0)
        again = count < transfer.sent
        self.before = request.sequence if again else 0
        return super().on_block_ack(replace(request, sequence=count))

    def sub_block(self, transfer: BlockUpload) -> list[Response]:
        transfer.block_size = min(transfer.block_size, LARGEST_BLOCK - self.before)
        return [
            replace(segment, sequence=segment.sequence + self.before)
            if isinstance(segment, BlockSegment)
            else segment
            for segment in super().sub_block(transfer)
        ]


class _OneByOne(AnswersLater):
    """Sends the segments of a sub-block one by one, and stops with an abort of the client."""

    apart = 0.0011
    """Seconds from one segment to the next."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if self.is_addressed(frame) and self.stops(frame.data):
            self.held.clear()
        frames = Node.receive(self, frame)
        for number, segment in enumerate(frames[1:], 1):
            self.held.append((self.now + self.apart * number, segment))
        return frames[:1]

    def stops(self, data: bytes) -> bool:
        """Say whether a request ends what is being sent."""
        return Abort.matches(data[0]) if data else False


@unusual("block-upload-segments-one-by-one", about=About.TIME)
class OneByOne(_OneByOne):
    """Sends the segments of a sub-block one by one, and none behind an abort of the client."""


@unusual("block-upload-early-acknowledgement-starts-over", about=About.TIME)
class EarlyStartsOver(_OneByOne):
    """Leaves a sub-block that it is sending for the next one when an acknowledgement comes."""

    def stops(self, data: bytes) -> bool:
        return super().stops(data) or BlockAck.matches(data[0] if data else 0)
