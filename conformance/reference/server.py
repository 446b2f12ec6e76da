"""The reference server: expedited, segmented and block transfers.

In a block download it chooses sub-blocks of 127 segments, discards what follows a gap and
acknowledges at the end of the sub-block; in a block upload it repeats what was not acknowledged.
It can compute the CRC, and says so whether or not the client can. Where the client allows it
(pst), a short object goes as an ordinary upload.
"""

from dataclasses import dataclass, field

from conformance.reference.segmented_server import SegmentedServer
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.decoding import decode_segment
from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    Request,
    Response,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.objects import Entry, Refusal


@dataclass(slots=True)
class BlockDownload:
    """A block download: what came in sequence, and which segment is due.

    ``broken`` says that a segment was lost: what follows in this sub-block is discarded.
    ``ended`` says that the last segment was acknowledged and the end frame is due.
    ``limit`` is the most bytes that may come, fillers of the last segment included.
    """

    mux: Multiplexer
    entry: Entry
    size: int | None
    crc: bool
    block_size: int
    due: int = 1
    broken: bool = False
    ended: bool = False
    data: bytearray = field(default_factory=bytearray)
    limit: int = field(init=False)

    def __post_init__(self) -> None:
        size = self.entry.longest if self.size is None else self.size
        self.limit = max(-(-size // SEGMENT_LENGTH), 1) * SEGMENT_LENGTH


@dataclass(slots=True)
class BlockUpload:
    """A block upload: what is acknowledged, and how many segments are on their way.

    ``sent`` is 0 until the client has started; ``ended`` says that the end frame was sent.
    """

    mux: Multiplexer
    data: bytes
    crc: bool
    block_size: int
    offset: int = 0
    sent: int = 0
    ended: bool = False


class Server(SegmentedServer):
    """One SDO server on an object dictionary, with all three protocols."""

    def decode(self, frame: bytes) -> Request:
        """Read a request; within a sub-block it is a segment whatever its bits say."""
        if isinstance(self.transfer, BlockDownload) and not self.transfer.ended:
            return decode_segment(frame)
        return super().decode(frame)

    def react(self, request: Request) -> list[Response]:
        """Choose the reaction by the kind of the request."""
        match request:
            case BlockSegment():
                return self.on_block_segment(request)
            case BlockDownloadInitiate():
                return self.on_block_download_initiate(request)
            case BlockEnd():
                return self.on_block_end(request)
            case BlockUploadInitiate():
                return self.on_block_upload_initiate(request)
            case BlockUploadStart():
                return self.on_block_upload_start(request)
            case BlockAck():
                return self.on_block_ack(request)
            case BlockEndResponse():
                return self.on_block_end_response(request)
            case _:
                return super().react(request)

    # Block download

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        """Get ready for the first sub-block."""
        self.transfer = None
        entry = self.entry_to_write_in_blocks(request)
        self.check_announced_size(entry, request.size)
        crc = self.can_compute_crc(request)
        transfer = BlockDownload(
            request.mux, entry, request.size, crc and request.crc_supported, self.next_block_size()
        )
        self.transfer = transfer
        return [BlockDownloadInitiateResponse(request.mux, transfer.block_size, crc)]

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        """Find the entry, or refuse."""
        return self.objects.writable(request.mux)

    def can_compute_crc(
        self,
        request: BlockDownloadInitiate | BlockUploadInitiate,
    ) -> bool:
        """Say whether the answer to an initiate offers a CRC."""
        del request
        return True

    def next_block_size(self) -> int:
        """Return how many segments the next sub-block of a download may have."""
        return LARGEST_BLOCK

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Take a segment that is in sequence; acknowledge at the end of the sub-block."""
        transfer = self.transfer
        if not isinstance(transfer, BlockDownload):
            return self.on_unexpected(request)
        if not 1 <= request.sequence <= transfer.block_size:
            raise Refusal(AbortCode.INVALID_SEQUENCE_NUMBER)
        in_sequence = request.sequence == transfer.due and not transfer.broken
        if in_sequence:
            self.take_block_segment(transfer, request)
            transfer.due += 1
        elif request.sequence > transfer.due:
            transfer.broken = True
        if request.last or request.sequence == transfer.block_size:
            transfer.ended = request.last and in_sequence
            return [self.acknowledge(transfer)]
        return []

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        """Store a segment, unless it is more than was announced."""
        transfer.data += request.payload
        if len(transfer.data) > transfer.limit:
            raise Refusal(AbortCode.LENGTH_TOO_HIGH)

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        """Say what came in sequence, and how long the next sub-block may be."""
        sequence = transfer.due - 1
        transfer.due = 1
        transfer.broken = False
        transfer.block_size = self.next_block_size()
        return BlockAck(sequence, transfer.block_size)

    def on_block_end(self, request: BlockEnd) -> list[Response]:
        """Check what came against its CRC and its size, and write it."""
        transfer = self.transfer
        if not isinstance(transfer, BlockDownload) or not transfer.ended:
            return self.on_unexpected(request)
        data = bytes(transfer.data[: len(transfer.data) - request.unused])
        self.check_crc(transfer, request, data)
        self.check_block_size(transfer, data)
        self.store(transfer.entry, data)
        self.transfer = None
        return [BlockEndResponse()]

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Refuse data that do not match the CRC, where there is one."""
        if transfer.crc and request.crc != crc16(data):
            raise Refusal(AbortCode.CRC_ERROR)

    def check_block_size(self, transfer: BlockDownload, data: bytes) -> None:
        """Refuse data that are not as many as announced."""
        if transfer.size is not None and len(data) > transfer.size:
            raise Refusal(AbortCode.LENGTH_TOO_HIGH)
        if transfer.size is not None and len(data) < transfer.size:
            raise Refusal(AbortCode.LENGTH_TOO_LOW)

    # Block upload

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Announce the size, or switch to an ordinary upload where the client allows it."""
        self.transfer = None
        data = self.value_to_read(self.objects.readable(request.mux))
        if not 1 <= request.block_size <= LARGEST_BLOCK:
            raise Refusal(AbortCode.INVALID_BLOCK_SIZE)
        if self.switches_protocol(request, len(data)):
            return [self.start_upload(request.mux, data)]
        crc = self.can_compute_crc(request)
        self.transfer = BlockUpload(
            request.mux, data, crc and request.crc_supported, request.block_size
        )
        return [self.announce_block(request, len(data), crc)]

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        """Build the answer to a block upload initiate."""
        return BlockUploadInitiateResponse.with_size(request.mux, size, crc_supported=crc)

    def switches_protocol(self, request: BlockUploadInitiate, size: int) -> bool:
        """Say whether an object goes as an ordinary upload; pst = 0 forbids it."""
        return request.threshold > 0 and size <= request.threshold

    def on_block_upload_start(self, request: BlockUploadStart) -> list[Response]:
        """Send the first sub-block."""
        transfer = self.transfer
        if not isinstance(transfer, BlockUpload) or transfer.sent:
            return self.on_unexpected(request)
        return self.sub_block(transfer)

    def sub_block(self, transfer: BlockUpload) -> list[Response]:
        """Return the segments of the next sub-block, numbered from 1; mark the very last."""
        left = len(transfer.data) - transfer.offset
        segments = max(-(-left // SEGMENT_LENGTH), 1)
        transfer.sent = min(segments, transfer.block_size)
        responses: list[Response] = []
        for number in range(transfer.sent):
            start = transfer.offset + number * SEGMENT_LENGTH
            data = self.block_data(transfer, start)
            last = number == segments - 1
            responses.append(BlockSegment.with_data(number + 1, data, last=last))
        return responses

    def block_data(self, transfer: BlockUpload, start: int) -> bytes:
        """Return the bytes of one segment."""
        return transfer.data[start : start + SEGMENT_LENGTH]

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Send what comes next, or what was lost, or the end."""
        transfer = self.transfer
        if not isinstance(transfer, BlockUpload) or not transfer.sent or transfer.ended:
            return self.on_unexpected(request)
        if request.sequence > transfer.sent:
            raise Refusal(AbortCode.INVALID_SEQUENCE_NUMBER)
        if not 1 <= request.block_size <= LARGEST_BLOCK:
            raise Refusal(AbortCode.INVALID_BLOCK_SIZE)
        transfer.offset += request.sequence * SEGMENT_LENGTH
        transfer.block_size = request.block_size
        if request.sequence and transfer.offset >= len(transfer.data):
            transfer.ended = True
            return [self.block_end(transfer)]
        return self.sub_block(transfer)

    def block_end(self, transfer: BlockUpload) -> BlockEnd:
        """Say how many bytes of the last segment do not count, and the CRC."""
        unused = transfer.offset - len(transfer.data)
        return BlockEnd(unused, crc16(transfer.data) if transfer.crc else 0)

    def on_block_end_response(self, request: BlockEndResponse) -> list[Response]:
        """Be idle; the client has everything."""
        if not isinstance(self.transfer, BlockUpload) or not self.transfer.ended:
            return self.on_unexpected(request)
        self.transfer = None
        return []
