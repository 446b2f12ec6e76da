"""Servers that are unusual and right in block transfers: what CiA 301 leaves open there."""

from conformance.faults.registry import variant
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    DownloadInitiate,
    Request,
    Response,
    UploadInitiate,
)
from conformance.sdo.objects import DataType, Entry, Refusal
from conformance.sdo.segmented_server import SegmentedServer
from conformance.sdo.server import BlockDownload, BlockUpload, Server


@variant("blocks-of-1-segment")
class BlocksOf1(Server):
    """Asks for sub-blocks of 1 segment."""

    def next_block_size(self) -> int:
        """Ask for one."""
        return 1


@variant("blocks-of-7-segments")
class BlocksOf7(Server):
    """Asks for sub-blocks of 7 segments."""

    def next_block_size(self) -> int:
        """Ask for seven."""
        return 7


@variant("blocks-of-21-segments")
class BlocksOf21(Server):
    """Asks for sub-blocks of 21 segments."""

    def next_block_size(self) -> int:
        """Ask for 21."""
        return 21


@variant("block-size-changes")
class BlockSizeChanges(Server):
    """Asks for another number of segments with each acknowledgement."""

    position = 0

    def next_block_size(self) -> int:
        """Go round a few sizes."""
        sizes = (127, 3, 64, 1, 20, 2)
        self.position = (self.position + 1) % len(sizes)
        return sizes[self.position]


@variant("no-block-crc")
class NoCrc(Server):
    """Has no CRC: A0h, C0h and C2h."""

    def can_compute_crc(self, request: BlockDownloadInitiate | BlockUploadInitiate) -> bool:
        """Never offer it."""
        return False


@variant("block-crc-mirrored")
class CrcMirrored(Server):
    """Offers a CRC to a client that has one, and to no other."""

    def can_compute_crc(self, request: BlockDownloadInitiate | BlockUploadInitiate) -> bool:
        """Repeat cc."""
        return request.crc_supported


class _BreaksAtOnce(Server):
    """Acknowledges a break at once, and discards what is still to come of that sub-block.

    A number that is not higher than the last one says that the next sub-block has begun.
    """

    seen = 0

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        """Have seen no break."""
        self.seen = 0
        return super().on_block_download_initiate(request)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Look for a break, or discard."""
        transfer = self.transfer
        if not isinstance(transfer, BlockDownload) or not request.sequence:
            return super().on_block_segment(request)
        if self.seen and request.sequence > self.seen:
            self.seen = request.sequence
            return []
        self.seen = 0
        if self.is_break(transfer.due, request.sequence):
            self.seen = request.sequence
            return [self.acknowledge(transfer)]
        return super().on_block_segment(request)

    def is_break(self, due: int, sequence: int) -> bool:
        """Say whether a number breaks the sequence."""
        return sequence > due


@variant("gap-acknowledged-at-once")
class GapAtOnce(_BreaksAtOnce):
    """Acknowledges a gap in a sub-block at once."""


@variant("repeated-segment-breaks")
class RepeatedBreaks(_BreaksAtOnce):
    """Takes a repeated segment for a break, and acknowledges the last good one at once."""

    def is_break(self, due: int, sequence: int) -> bool:
        """Insist on the number that is due."""
        return sequence != due


@variant("sequence-zero-ignored")
class SequenceZeroIgnored(Server):
    """Discards a segment with a number that cannot be, and goes on."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Drop it."""
        transfer = self.transfer
        largest = transfer.block_size if isinstance(transfer, BlockDownload) else 0
        if largest and not 1 <= request.sequence <= largest:
            return []
        return super().on_block_segment(request)


@variant("block-upload-size-not-indicated")
class UnsizedBlockUploads(Server):
    """Never says how long a block upload is (C4h)."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        """Leave the size out."""
        return BlockUploadInitiateResponse.with_size(request.mux, None, crc_supported=crc)


@variant("block-upload-never-switches")
class NeverSwitches(Server):
    """Answers a block upload in blocks whatever pst allows."""

    def switches_protocol(self, request: BlockUploadInitiate, size: int) -> bool:
        """Stay with blocks."""
        return False


@variant("no-block-transfer")
class NoBlockTransfer(SegmentedServer):
    """Has no block transfer."""


@variant("no-block-download")
class NoBlockDownload(Server):
    """Has block uploads and no block downloads."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        """Refuse."""
        return self.on_block_initiate(request)


@variant("no-block-upload")
class NoBlockUpload(Server):
    """Has block downloads and no block uploads."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Refuse."""
        return self.on_block_initiate(request)


@variant("new-initiate-in-block-refused")
class NewInitiateRefused(Server):
    """Refuses an initiate in the middle of a block transfer, which ends."""

    def react(self, request: Request) -> list[Response]:
        """Refuse it with the multiplexer of the running transfer."""
        running = self.transfer
        initiate = isinstance(
            request, UploadInitiate | DownloadInitiate | BlockUploadInitiate | BlockDownloadInitiate
        )
        if initiate and isinstance(running, BlockDownload | BlockUpload):
            self.transfer = None
            return [Abort(running.mux, AbortCode.COMMAND_NOT_VALID)]
        return super().react(request)


@variant("strict-about-block-requests")
class StrictAboutBlocks(Server):
    """Refuses requests of a block transfer with reserved bits set, like A6h."""

    def react(self, request: Request) -> list[Response]:
        """Look at what most servers ignore."""
        match request:
            case (
                BlockDownloadInitiate(reserved_bits=bits)
                | BlockEnd(reserved_bits=bits)
                | BlockUploadInitiate(reserved_bits=bits)
                | BlockUploadStart(reserved_bits=bits)
                | BlockAck(reserved_bits=bits)
                | BlockEndResponse(reserved_bits=bits)
            ) if bits:
                raise Refusal(AbortCode.COMMAND_NOT_VALID)
            case _:
                return super().react(request)


@variant("block-sequence-code-generic")
class SequenceCodeGeneric(Server):
    """Calls a wrong sequence number in a block transfer a command that is not valid."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Replace the code."""
        if code is AbortCode.INVALID_SEQUENCE_NUMBER:
            code = AbortCode.COMMAND_NOT_VALID
        return super().refuse(request, code)


@variant("block-sizes-checked-at-the-end")
class BlockSizesCheckedLate(Server):
    """Takes any data in a block download and looks at their length with the end frame only."""

    in_blocks = False

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        """Look later at block downloads."""
        self.in_blocks = True
        try:
            return super().on_block_download_initiate(request)
        finally:
            self.in_blocks = False

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Look now at others."""
        if not self.in_blocks:
            super().check_announced_size(entry, size)

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        """Take everything."""
        transfer.data += request.payload


@variant("block-access-checked-at-the-end")
class BlockAccessCheckedLate(Server):
    """Takes a block download to a read-only object and refuses it with the end frame."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        """Look later."""
        return self.objects.find(request.mux)

    def check_block_size(self, transfer: BlockDownload, data: bytes) -> None:
        """Look now."""
        self.objects.writable(transfer.mux)
        super().check_block_size(transfer, data)


@variant("strings-of-100-bytes")
class StringsOf100(Server):
    """Has room for 100 bytes in strings and domains, in segments and in blocks."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        """Set the capacity."""
        entry = super().entry_to_write(request)
        entry.capacity = 100
        return entry

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        """Set the capacity."""
        entry = super().entry_to_write_in_blocks(request)
        entry.capacity = 100
        return entry


@variant("domain-keeps-part-of-aborted-block")
class DomainKeepsPart(Server):
    """Has stored in a domain what came of a block download when it is aborted."""

    def react(self, request: Request) -> list[Response]:
        """Write through."""
        responses = super().react(request)
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and transfer.entry.data_type is DataType.DOMAIN:
            transfer.entry.value = bytes(transfer.data)
        return responses


@variant("empty-value-not-read-in-blocks")
class EmptyNotRead(Server):
    """Refuses a block upload of a value without data."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        """Say that there is none."""
        if not size:
            raise Refusal(AbortCode.NO_DATA)
        return super().announce_block(request, size, crc)


@variant("end-of-block-upload-repeated")
class EndRepeated(Server):
    """Sends the end of a block upload again when the acknowledgement before it comes again."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Repeat the answer."""
        if isinstance(self.transfer, BlockUpload) and self.transfer.ended:
            return [self.block_end(self.transfer)]
        return super().on_block_ack(request)
