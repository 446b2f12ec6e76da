"""Servers that are wrong in block downloads: counts, widths, block sizes, CRC, frames."""

from dataclasses import replace

from conformance.faults.block_servers import StoresOtherwise
from conformance.faults.registry import About, Defect, fault
from conformance.reference.segmented_server import NO_MULTIPLEXER
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    Request,
    Response,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.objects import Entry, Refusal

FULL_BLOCK = LARGEST_BLOCK * SEGMENT_LENGTH
# The segment of a sub-block for which a server has no room.
NO_ROOM_FROM = 9


@fault(
    "block-download-n-ignored-without-size",
    Defect.UNUSED_COUNT,
    "block-download.size-not-indicated",
)
class UnusedIgnored(StoresOtherwise):
    """Stores the fillers of the last segment as well when no size was indicated."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        return bytes(transfer.data) if transfer.size is None else data


@fault("block-download-n-off-by-one", Defect.UNUSED_COUNT, "block-download.size")
class UnusedOffByOne(Server):
    """Cuts one byte too many off a last segment that is not full."""

    def on_block_end(self, request: BlockEnd) -> list[Response]:
        return super().on_block_end(
            replace(request, unused=min(request.unused + (request.unused > 0), 7))
        )


@fault("block-download-full-last-segment-lost", Defect.UNUSED_COUNT, "block-download.size[7]")
class FullSegmentLost(StoresOtherwise):
    """Takes n = 0 for a last segment without data."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        return data if request.unused else data[:-SEGMENT_LENGTH]


@fault("block-download-last-at-full-block-missed", Defect.LAST_FLAG, "block-download.size[1777]")
class LastMissed(Server):
    """Expects another sub-block when the last segment is the last one of a full sub-block."""

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        if transfer.due > transfer.block_size:
            transfer.ended = False
        return super().acknowledge(transfer)


class _Taken(Server):
    """Takes some segments for something else."""

    commands: range = range(0)

    def decode(self, frame: bytes) -> Request:
        if len(frame) == 8 and frame[0] in self.commands:
            return decode_request(frame)
        return super().decode(frame)


@fault("block-download-segment-64-as-upload", Defect.STATE, "block-download.size[490]")
class SegmentAsUpload(_Taken):
    """Takes segment 64, 40h, for an upload initiate."""

    commands = range(0x40, 0x41)


@fault("block-download-last-segment-64-as-initiate", Defect.STATE, "block-download.size[448]")
class SegmentAsInitiate(_Taken):
    """Takes C0h to DFh, last segments 64 to 95, for block download requests."""

    commands = range(0xC0, 0xE0)


@fault("block-download-last-segment-96-unknown", Defect.STATE, "block-download.size[672]")
class SegmentUnknown(_Taken):
    """Takes E0h to FFh, last segments 96 to 127, for an unknown command specifier."""

    commands = range(0xE0, 0x100)


@fault("block-download-segment-beyond-70-refused", Defect.FIELD_WIDTH, "block-download.size")
class SixBits(Server):
    """Counts segments with 6 bits."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        return super().on_block_segment(replace(request, sequence=request.sequence & 0x3F))


@fault(
    "block-download-101st-segment-lost",
    Defect.BACK_TO_BACK,
    "block-download.whole-sub-block",
    soft=True,
)
class QueueOverflows(Server):
    """Loses the segments 101 to 110 of a long burst once in each transfer."""

    room = 0

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        self.room = 10
        return super().on_block_download_initiate(request)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        if request.sequence > 100 and self.room:
            self.room -= 1
            return []
        return super().on_block_segment(request)


@fault("block-download-block-size-128", Defect.BLOCK_SIZE, "block-download.size")
class BlockSize128(Server):
    """Asks for 128 segments."""

    def next_block_size(self) -> int:
        return 128


@fault("block-download-last-acknowledgement-block-size-0", Defect.BLOCK_SIZE, "block-download.size")
class BlockSize0(Server):
    """Asks for 0 segments behind the last one."""

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        ack = super().acknowledge(transfer)
        return replace(ack, block_size=0) if transfer.ended else ack


@fault("block-download-waits-for-more-than-asked", Defect.BLOCK_SIZE, "block-download.size[448]")
class WaitsForMore(Server):
    """Asks for sub-blocks of 10 segments and acknowledges after 20."""

    def next_block_size(self) -> int:
        return 20

    def react(self, request: Request) -> list[Response]:
        return [
            replace(response, block_size=10)
            if isinstance(response, BlockDownloadInitiateResponse | BlockAck)
            else response
            for response in super().react(request)
        ]


@fault("block-download-size-8-bit", Defect.FIELD_WIDTH, "block-download.size[448]")
class SizeOf8Bits(Server):
    """Looks at the low byte of the announced size only."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        payload = request.payload[:1] + bytes(3)
        return super().on_block_download_initiate(replace(request, payload=payload))


@fault("block-download-offset-wraps", Defect.FIELD_WIDTH, "block-download.size[1777]")
class OffsetWraps(StoresOtherwise):
    """Writes the second full sub-block over the first."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        over = data[FULL_BLOCK:][:FULL_BLOCK]
        return over + data[len(over) :]


@fault("block-download-number-four-bytes", Defect.FIELD_WIDTH, "block-download.number[8]")
class NumberOfFourBytes(StoresOtherwise):
    """Stores the low 4 bytes of a number only."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        number = transfer.entry.data_type.length is not None
        return data[:4].ljust(len(data), b"\0") if number else data


@fault("block-download-multiplexer-missing", Defect.FRAME_SHAPE, "block-download.size")
class MultiplexerMissing(Server):
    """Confirms a block download initiate with multiplexer 0."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
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


@fault("block-download-initiate-response-filled", Defect.FRAME_SHAPE, "block-download.reserved")
class InitiateFilled(_Reserved):
    """Leaves 14h in the last reserved byte of A4h."""

    def filled(self, request: Request, response: Response) -> Response:
        if isinstance(response, BlockDownloadInitiateResponse):
            return replace(response, reserved=b"\0\0\x14")
        return response


@fault("block-download-acknowledgement-echoes-data", Defect.FRAME_SHAPE, "block-download.reserved")
class AcknowledgementEchoes(_Reserved):
    """Sends data of the last segment back in the reserved bytes of A2h."""

    def filled(self, request: Request, response: Response) -> Response:
        if isinstance(response, BlockAck) and isinstance(request, BlockSegment):
            return replace(response, reserved=request.payload[2:])
        return response


@fault("block-download-end-response-echoes-n", Defect.FRAME_SHAPE, "block-download.reserved")
class EndResponseEchoes(_Reserved):
    """Sends n back in the reserved bits of A1h."""

    def filled(self, request: Request, response: Response) -> Response:
        if isinstance(response, BlockEndResponse) and isinstance(request, BlockEnd):
            return replace(response, reserved_bits=request.unused)
        return response


@fault("block-download-empty-hangs", Defect.ZERO_LENGTH, "block-download.empty")
class EmptyHangs(Server):
    """Never confirms a block download without data."""

    def on_block_end(self, request: BlockEnd) -> list[Response]:
        responses = super().on_block_end(request)
        return [] if request.unused == SEGMENT_LENGTH else responses


class _OwnCrc(Server):
    """Holds block downloads to a CRC of its own."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Compare with ``crc_of`` where there is a CRC."""
        if transfer.crc and request.crc != self.crc_of(transfer, data):
            raise Refusal(AbortCode.CRC_ERROR)

    def crc_of(self, transfer: BlockDownload, data: bytes) -> int:
        """Return the CRC that is due."""
        del transfer
        return crc16(data)


@fault("block-download-crc-starts-at-ffff", Defect.CRC, "block-download.size")
class CrcStartsAtFfff(_OwnCrc):
    """Starts the CRC of a block download with FFFFh."""

    def crc_of(self, transfer: BlockDownload, data: bytes) -> int:
        return crc16(data, 0xFFFF)


@fault("block-download-crc-with-fillers", Defect.CRC, "block-download.size[1]")
class CrcWithFillers(_OwnCrc):
    """Sums up the fillers of the last segment of a block download as well."""

    def crc_of(self, transfer: BlockDownload, data: bytes) -> int:
        return crc16(bytes(transfer.data))


@fault("block-download-crc-of-last-sub-block", Defect.CRC, "block-download.size[1777]")
class CrcOfLastSubBlock(_OwnCrc):
    """Sums up the last sub-block of a block download only."""

    def crc_of(self, transfer: BlockDownload, data: bytes) -> int:
        return crc16(data[max(len(data) - 1, 0) // FULL_BLOCK * FULL_BLOCK :])


@fault("block-download-crc-bytes-swapped", Defect.CRC, "block-download.size")
class CrcSwapped(_OwnCrc):
    """Expects the high byte of the CRC first."""

    def crc_of(self, transfer: BlockDownload, data: bytes) -> int:
        return int.from_bytes(crc16(data).to_bytes(2, "big"), "little")


@fault("block-download-crc-always-checked", Defect.CRC, "block-download.without-crc")
class CrcAlwaysChecked(Server):
    """Checks the CRC of a client that has none."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        if request.crc != crc16(data):
            raise Refusal(AbortCode.CRC_ERROR)


@fault("block-download-crc-unused-checked", Defect.CRC, "block-download.crc-unused")
class CrcUnusedChecked(Server):
    """Checks the CRC of a client that has none, unless the field is 0."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        if (transfer.crc or request.crc) and request.crc != crc16(data):
            raise Refusal(AbortCode.CRC_ERROR)


@fault("block-download-write-only-refused", Defect.ACCESS_OR_SIZE, "block-download.write-only")
class WriteOnlyRefused(Server):
    """Refuses block downloads to what cannot be read."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        self.objects.readable(request.mux)
        return super().entry_to_write_in_blocks(request)


@fault("block-download-crc-goes-on", Defect.LEAK, "block-download.again")
class CrcGoesOn(Server):
    """Starts the CRC of a block download where that of the last one ended."""

    crc = 0

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        before, self.crc = self.crc, 0
        if transfer.crc and request.crc != crc16(data, before):
            raise Refusal(AbortCode.CRC_ERROR)
        self.crc = request.crc


@fault(
    "block-upload-size-16-bit",
    Defect.FIELD_WIDTH,
    "block-download.beyond-16-bits",
    about=About.LENGTHS,
)
class UploadSizeOf16Bits(Server):
    """Announces the low 16 bits of the size of a block upload."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        return super().announce_block(request, size & 0xFFFF, crc)


@fault(
    "block-download-offset-16-bit",
    Defect.FIELD_WIDTH,
    "block-download.beyond-16-bits",
    about=About.LENGTHS,
)
class OffsetOf16Bits(StoresOtherwise):
    """Starts again at 0 after 65,529 bytes of a block download, 9361 segments."""

    def stored(self, data: bytes, transfer: BlockDownload, request: BlockEnd) -> bytes:
        over = data[0xFFF9:]
        return over + data[len(over) : 0xFFF9]


@fault("aborts-inside-sub-block", Defect.ABORT, "block-download.size")
class AbortsInsideSubBlock(Server):
    """Has room for 8 segments of each sub-block, and aborts with 0000h:00 when the ninth comes."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Run out of room; what is still on its way finds the server idle."""
        if isinstance(self.transfer, BlockDownload) and request.sequence >= NO_ROOM_FROM:
            self.transfer = None
            return [Abort(NO_MULTIPLEXER, AbortCode.OUT_OF_MEMORY)]
        return super().on_block_segment(request)
