"""Servers that are wrong in block uploads: counts, widths, frames."""

from dataclasses import replace

from conformance.faults.block_servers import KnowsBlockUploads
from conformance.faults.registry import About, Defect, fault
from conformance.reference.server import BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    Response,
    Unknown,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.objects import Entry

FULL_BLOCK = LARGEST_BLOCK * SEGMENT_LENGTH


class _Unused(Server):
    """Sends another n in the end frame."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        end = super().block_end(transfer)
        return replace(end, unused=self.unused(end.unused))

    def unused(self, right: int) -> int:
        """Return what is sent as n."""
        return right


@fault("block-upload-n-off-by-one", Defect.UNUSED_COUNT, "block-upload.size")
class UnusedOffByOne(_Unused):
    """States one byte too few in n when the last segment is not full."""

    def unused(self, right: int) -> int:
        return max(right - 1, 0)


@fault("block-upload-n-7-for-full-segment", Defect.UNUSED_COUNT, "block-upload.size[7]")
class SevenForFull(_Unused):
    """Sends n = 7 behind a full last segment."""

    def unused(self, right: int) -> int:
        return right or SEGMENT_LENGTH


@fault("block-upload-n-is-count", Defect.UNUSED_COUNT, "block-upload.size")
class UnusedIsCount(_Unused):
    """States in n how many bytes of the last segment count."""

    def unused(self, right: int) -> int:
        return SEGMENT_LENGTH - right


@fault(
    "block-upload-n-always-zero",
    Defect.UNUSED_COUNT,
    "block-upload.size[1]",
    "block-upload.constant",
    "random.block-transfers",
)
class UnusedZero(_Unused):
    """Leaves n at 0: the size was announced."""

    def unused(self, right: int) -> int:
        return 0


@fault("block-upload-size-8-bit", Defect.FIELD_WIDTH, "block-upload.size[889]")
class SizeOf8Bits(Server):
    """Announces the low byte of the size only."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        return super().announce_block(request, size & 0xFF, crc)


@fault("block-upload-size-of-segments", Defect.FIELD_WIDTH, "block-upload.size[1]")
class SizeOfSegments(Server):
    """Announces the size with the fillers of the last segment."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        return super().announce_block(request, -(-size // SEGMENT_LENGTH) * SEGMENT_LENGTH, crc)


@fault("block-upload-offset-wraps", Defect.FIELD_WIDTH, "block-upload.size[1777]")
class OffsetWraps(Server):
    """Sends the first 889 bytes again behind them."""

    def block_data(self, transfer: BlockUpload, start: int) -> bytes:
        return super().block_data(transfer, start % FULL_BLOCK)[: len(transfer.data) - start]


@fault("block-upload-text-ends-in-zero", Defect.FIELD_WIDTH, "block-upload.same-as-segmented")
class TextLongerInBlocks(KnowsBlockUploads):
    """Adds a 00h to long strings in block uploads and in no others."""

    def value_to_read(self, entry: Entry) -> bytes:
        long = self.in_blocks and len(entry.value) > 7
        return super().value_to_read(entry) + bytes(long)


@fault("block-upload-multiplexer-missing", Defect.FRAME_SHAPE, "block-upload.size")
class MultiplexerMissing(Server):
    """Answers a block upload initiate with multiplexer 0."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        return replace(super().announce_block(request, size, crc), mux=Multiplexer(0))


@fault("block-upload-size-without-flag", Defect.FRAME_SHAPE, "block-upload.reserved")
class SizeWithoutFlag(Server):
    """Sends the size and does not say so."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        return replace(super().announce_block(request, size, crc), sized=False)


@fault("block-upload-reserved-bit", Defect.FRAME_SHAPE, "block-upload.reserved")
class ReservedBit(Server):
    """Sets a reserved bit in C6h."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        return replace(super().announce_block(request, size, crc), reserved_bits=1)


@fault("block-upload-end-echoes-size", Defect.FRAME_SHAPE, "block-upload.reserved")
class EndEchoesSize(Server):
    """Sends the size in the reserved bytes of the end frame."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        size = len(transfer.data).to_bytes(5, "little")
        return replace(super().block_end(transfer), reserved=size)


@fault("block-upload-filler-leaks", Defect.FRAME_SHAPE, "block-upload.filler", soft=True)
class FillerLeaks(Server):
    """Fills the last segment with FFh."""

    def block_data(self, transfer: BlockUpload, start: int) -> bytes:
        return super().block_data(transfer, start).ljust(SEGMENT_LENGTH, b"\xff")


@fault("block-upload-end-response-answered", Defect.STATE, "block-upload.next-request")
class EndResponseAnswered(Server):
    """Answers the end of a block upload, which is no request."""

    def on_block_end_response(self, request: BlockEndResponse) -> list[Response]:
        return [*super().on_block_end_response(request), BlockEndResponse()]


@fault("block-upload-end-response-refused", Defect.STATE, "block-upload.next-request")
class EndResponseRefused(Server):
    """Is idle when the end of a block upload is confirmed, and refuses that."""

    def on_block_end_response(self, request: BlockEndResponse) -> list[Response]:
        refusal = Abort(Multiplexer(0), AbortCode.COMMAND_NOT_VALID)
        return [*super().on_block_end_response(request), refusal]


@fault("block-upload-next-request-lost", Defect.BACK_TO_BACK, "block-upload.next-request")
class NextRequestLost(Server):
    """Loses the request right behind the end of a block upload."""

    busy = False

    def receive(self, frame: bytes) -> list[bytes]:
        if self.busy:
            self.busy = False
            return []
        return super().receive(frame)

    def on_block_end_response(self, request: BlockEndResponse) -> list[Response]:
        responses = super().on_block_end_response(request)
        self.busy = True
        return responses


@fault("block-upload-empty-hangs", Defect.ZERO_LENGTH, "block-upload.empty")
class EmptyHangs(Server):
    """Announces an object without data and never sends a segment."""

    def on_block_upload_start(self, request: BlockUploadStart) -> list[Response]:
        transfer = self.transfer
        responses = super().on_block_upload_start(request)
        return responses if isinstance(transfer, BlockUpload) and transfer.data else []


@fault("block-upload-byte-for-empty", Defect.ZERO_LENGTH, "block-upload.empty")
class ByteForEmpty(Server):
    """Announces no bytes for an object without data and sends one."""

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        end = super().block_end(transfer)
        return end if transfer.data else replace(end, unused=SEGMENT_LENGTH - 1)


@fault("block-upload-empty-as-4-bytes", Defect.ZERO_LENGTH, "block-upload.empty")
class EmptyAs4BytesInBlocks(KnowsBlockUploads):
    """Uploads an empty object in blocks as 4 bytes 0."""

    def value_to_read(self, entry: Entry) -> bytes:
        value = super().value_to_read(entry)
        return value or bytes(4 * self.in_blocks)


@fault("second-block-upload-zero", Defect.LEAK, "block-upload.again")
class SecondUploadZero(Server):
    """Delivers zeros in the second of two block uploads of one object."""

    last: Multiplexer | None = None

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        responses = super().on_block_upload_initiate(request)
        if isinstance(self.transfer, BlockUpload) and request.mux == self.last:
            self.transfer.data = bytes(len(self.transfer.data))
        return responses

    def on_block_end_response(self, request: BlockEndResponse) -> list[Response]:
        self.last = self.transfer.mux if self.transfer else None
        return super().on_block_end_response(request)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        self.last = None
        return super().start_upload(mux, data)


@fault(
    "block-upload-offset-16-bit",
    Defect.FIELD_WIDTH,
    "block-upload.beyond-16-bits",
    about=About.LENGTHS,
)
class UploadOffsetOf16Bits(Server):
    """Starts again at 0 after 65,536 bytes of a block upload; it has no block downloads."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        self.transfer = None
        return self.on_unexpected(request)

    def block_data(self, transfer: BlockUpload, start: int) -> bytes:
        return super().block_data(transfer, start & 0xFFFF)


@fault("threshold-read-as-block-size", Defect.BLOCK_SIZE, "block-upload.threshold")
class ThresholdAsBlockSize(Server):
    """Reads blksize and pst as one number of 16 bits, and numbers segments from 80h on as well."""

    high_byte = 0

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
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


@fault("block-uploads-endless", Defect.LAST_FLAG, "block-upload.size")
class BlockUploadsEndless(Server):
    """Sends the bytes of a block upload over and over, says no size and marks no last segment."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        del size
        return BlockUploadInitiateResponse.with_size(request.mux, None, crc_supported=crc)

    def sub_block(self, transfer: BlockUpload) -> list[Response]:
        segments = [BlockSegment(number + 1, bytes(7)) for number in range(transfer.block_size)]
        transfer.sent = transfer.block_size
        transfer.data += bytes(transfer.block_size * SEGMENT_LENGTH)
        return [*segments]
