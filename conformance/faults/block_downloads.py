"""Servers that are wrong in block downloads: counts, flags, widths, block sizes, frames."""

from dataclasses import replace

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    Request,
    Response,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry
from conformance.sdo.segmented_server import SEGMENT_LENGTH
from conformance.sdo.server import BlockDownload, Server

COUNT = DefectClass.UNUSED_COUNT
BLOCK_SIZE = DefectClass.BLOCK_SIZE
WIDTH = DefectClass.FIELD_WIDTH
SHAPE = DefectClass.FRAME_SHAPE
STATE = DefectClass.STATE
FULL_BLOCK = 127 * SEGMENT_LENGTH


class StoresOtherwise(Server):
    """Stores something else than what came in blocks; its CRC and its size are checked before."""

    ending: tuple[BlockDownload, BlockEnd] | None = None

    def on_block_end(self, request: BlockEnd) -> list[Response]:
        """Remember what ends."""
        if isinstance(self.transfer, BlockDownload):
            self.ending = (self.transfer, request)
        try:
            return super().on_block_end(request)
        finally:
            self.ending = None

    def store(self, entry: Entry, data: bytes) -> None:
        """Change the data of block downloads."""
        super().store(entry, self.stored(data, *self.ending) if self.ending else data)

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        """Return what is stored."""
        del transfer, request
        return data


@fault("block-download-n-ignored-without-size", COUNT, "block-download.size-not-indicated")
class UnusedIgnored(StoresOtherwise):
    """Stores the fillers of the last segment as well when no size was indicated."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        """Do not look at n."""
        return bytes(transfer.data) if transfer.size is None else data


@fault("block-download-n-off-by-one", COUNT, "block-download.size")
class UnusedOffByOne(Server):
    """Cuts one byte too many off a last segment that is not full."""

    def on_block_end(self, request: BlockEnd) -> list[Response]:
        """Add 1 to n."""
        return super().on_block_end(
            replace(request, unused=min(request.unused + (request.unused > 0), 7))
        )


@fault("block-download-full-last-segment-lost", COUNT, "block-download.size[7]")
class FullSegmentLost(StoresOtherwise):
    """Takes n = 0 for a last segment without data."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        """Cut a whole segment."""
        return data if request.unused else data[:-SEGMENT_LENGTH]


@fault("block-download-n-not-compared", COUNT, "block-download.unused-too-many")
class UnusedNotCompared(StoresOtherwise):
    """Stores as many bytes as were announced though n says that fewer count."""

    def check_block_size(self, transfer: BlockDownload, data: bytes) -> None:
        """Do not mind."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        """Look at the size instead."""
        return data if transfer.size is None else bytes(transfer.data[: transfer.size])


@fault(
    "block-download-last-at-full-block-missed",
    DefectClass.LAST_FLAG,
    "block-download.size[1777]",
)
class LastMissed(Server):
    """Expects another sub-block when the last segment is the last one of a full sub-block."""

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        """Go on after blksize segments."""
        if transfer.due > transfer.block_size:
            transfer.ended = False
        return super().acknowledge(transfer)


class _Taken(Server):
    """Takes some segments for something else."""

    commands: range = range(0)

    def decode(self, frame: bytes) -> Request:
        """Look at byte 0 only."""
        if len(frame) == 8 and frame[0] in self.commands:
            return decode_request(frame)
        return super().decode(frame)


@fault("block-download-segment-64-as-upload", STATE, "block-download.size[490]")
class SegmentAsUpload(_Taken):
    """Takes segment 64, 40h, for an upload initiate."""

    commands = range(0x40, 0x41)


@fault("block-download-last-segment-64-as-initiate", STATE, "block-download.size[448]")
class SegmentAsInitiate(_Taken):
    """Takes C0h to DFh, last segments 64 to 95, for block download requests."""

    commands = range(0xC0, 0xE0)


@fault("block-download-last-segment-96-unknown", STATE, "block-download.size[672]")
class SegmentUnknown(_Taken):
    """Takes E0h to FFh, last segments 96 to 127, for an unknown command specifier."""

    commands = range(0xE0, 0x100)


@fault("block-download-segment-beyond-70-refused", WIDTH, "block-download.size")
class SixBits(Server):
    """Counts segments with 6 bits."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Mask the number."""
        return super().on_block_segment(replace(request, sequence=request.sequence & 0x3F))


@fault("block-download-101st-segment-lost", DefectClass.BACK_TO_BACK, "block-download.size[1777]")
class QueueOverflows(Server):
    """Loses the segments 101 to 110 of a long burst once in each transfer."""

    room = 0

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        """Lose the next ten."""
        self.room = 10
        return super().on_block_download_initiate(request)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Drop what does not fit."""
        if request.sequence > 100 and self.room:
            self.room -= 1
            return []
        return super().on_block_segment(request)


@fault("block-download-block-size-128", BLOCK_SIZE, "block-download.size")
class BlockSize128(Server):
    """Asks for 128 segments."""

    def next_block_size(self) -> int:
        """Be off by one."""
        return 128


@fault("block-download-last-acknowledgement-block-size-0", BLOCK_SIZE, "block-download.size")
class BlockSize0(Server):
    """Asks for 0 segments behind the last one."""

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        """Need no more."""
        ack = super().acknowledge(transfer)
        return replace(ack, block_size=0) if transfer.ended else ack


@fault("block-download-waits-for-more-than-asked", BLOCK_SIZE, "block-download.size[448]")
class WaitsForMore(Server):
    """Asks for sub-blocks of 10 segments and acknowledges after 20."""

    def next_block_size(self) -> int:
        """Wait for 20."""
        return 20

    def react(self, request: Request) -> list[Response]:
        """Ask for 10."""
        return [
            replace(response, block_size=10)
            if isinstance(response, BlockDownloadInitiateResponse | BlockAck)
            else response
            for response in super().react(request)
        ]


@fault("block-download-size-8-bit", WIDTH, "block-download.size[448]")
class SizeOf8Bits(Server):
    """Looks at the low byte of the announced size only."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        """Cut the size."""
        payload = request.payload[:1] + bytes(3)
        return super().on_block_download_initiate(replace(request, payload=payload))


@fault("block-download-offset-wraps", WIDTH, "block-download.size[1777]")
class OffsetWraps(StoresOtherwise):
    """Writes the second full sub-block over the first."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        """Start again at 0 after 889 bytes."""
        over = data[FULL_BLOCK:][:FULL_BLOCK]
        return over + data[len(over) :]


@fault("block-download-number-four-bytes", WIDTH, "block-download.number[8]")
class NumberOfFourBytes(StoresOtherwise):
    """Stores the low 4 bytes of a number only."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        """Clear the others."""
        number = transfer.entry.data_type.length is not None
        return data[:4].ljust(len(data), b"\0") if number else data


@fault("block-download-multiplexer-missing", SHAPE, "block-download.size")
class MultiplexerMissing(Server):
    """Confirms a block download initiate with multiplexer 0."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        """Forget the object."""
        return [
            replace(response, mux=Multiplexer(0))
            if isinstance(response, BlockDownloadInitiateResponse)
            else response
            for response in super().on_block_download_initiate(request)
        ]


class _Reserved(Server):
    """Fills reserved bytes or bits of its responses."""

    def react(self, request: Request) -> list[Response]:
        """Pass each response through ``filled``."""
        return [self.filled(request, response) for response in super().react(request)]

    def filled(self, request: Request, response: Response) -> Response:
        """Return what is sent instead."""
        del request
        return response


@fault("block-download-initiate-response-filled", SHAPE, "block-download.reserved")
class InitiateFilled(_Reserved):
    """Leaves 14h in the last reserved byte of A4h."""

    def filled(self, request: Request, response: Response) -> Response:
        """Leave it in the buffer."""
        if isinstance(response, BlockDownloadInitiateResponse):
            return replace(response, reserved=b"\0\0\x14")
        return response


@fault("block-download-acknowledgement-echoes-data", SHAPE, "block-download.reserved")
class AcknowledgementEchoes(_Reserved):
    """Sends data of the last segment back in the reserved bytes of A2h."""

    def filled(self, request: Request, response: Response) -> Response:
        """Leave them in the buffer."""
        if isinstance(response, BlockAck) and isinstance(request, BlockSegment):
            return replace(response, reserved=request.payload[2:])
        return response


@fault("block-download-end-response-echoes-n", SHAPE, "block-download.reserved")
class EndResponseEchoes(_Reserved):
    """Sends n back in the reserved bits of A1h."""

    def filled(self, request: Request, response: Response) -> Response:
        """Leave them in the buffer."""
        if isinstance(response, BlockEndResponse) and isinstance(request, BlockEnd):
            return replace(response, reserved_bits=request.unused)
        return response


@fault("block-download-empty-hangs", DefectClass.ZERO_LENGTH, "block-download.empty")
class EmptyHangs(Server):
    """Never confirms a block download without data."""

    def on_block_end(self, request: BlockEnd) -> list[Response]:
        """Find nothing to write."""
        responses = super().on_block_end(request)
        return [] if request.unused == SEGMENT_LENGTH else responses
