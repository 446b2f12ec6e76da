"""Servers that are right in block downloads in their own way: block sizes, refusals."""

from conformance.faults.block_servers import HearsLastRepeated
from conformance.faults.registry import unusual
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockSegment,
    DownloadInitiate,
    Request,
    Response,
)
from conformance.sdo.objects import DEFAULT_CAPACITY, DataType, Entry, Refusal


@unusual("blocks-of-1-segment")
class BlocksOf1(Server):
    """Asks for sub-blocks of 1 segment."""

    def next_block_size(self) -> int:
        return 1


@unusual("blocks-of-7-segments")
class BlocksOf7(Server):
    """Asks for sub-blocks of 7 segments."""

    def next_block_size(self) -> int:
        return 7


@unusual("blocks-of-21-segments")
class BlocksOf21(Server):
    """Asks for sub-blocks of 21 segments."""

    def next_block_size(self) -> int:
        return 21


@unusual("block-size-changes")
class BlockSizeChanges(Server):
    """Asks for another number of segments with each acknowledgement."""

    position = 0

    def next_block_size(self) -> int:
        sizes = (127, 3, 64, 1, 20, 2)
        self.position = (self.position + 1) % len(sizes)
        return sizes[self.position]


@unusual("sequence-zero-ignored")
class SequenceZeroIgnored(Server):
    """Discards a segment with a number that cannot be, and goes on."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        transfer = self.transfer
        largest = transfer.block_size if isinstance(transfer, BlockDownload) else 0
        if largest and not 1 <= request.sequence <= largest:
            return []
        return super().on_block_segment(request)


@unusual("no-block-download")
class NoBlockDownload(Server):
    """Has block uploads and no block downloads."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        return self.on_block_initiate(request)


@unusual("block-sequence-code-generic")
class SequenceCodeGeneric(Server):
    """Calls a wrong sequence number in a block transfer a command that is not valid."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        if code is AbortCode.INVALID_SEQUENCE_NUMBER:
            code = AbortCode.COMMAND_NOT_VALID
        return super().refuse(request, code)


@unusual("block-sizes-checked-at-the-end")
class BlockSizesCheckedLate(Server):
    """Takes any data in a block download and looks at their length with the end frame only."""

    in_blocks = False

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        self.in_blocks = True
        try:
            return super().on_block_download_initiate(request)
        finally:
            self.in_blocks = False

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if not self.in_blocks:
            super().check_announced_size(entry, size)

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        transfer.data += request.payload


@unusual("block-access-checked-at-the-end")
class BlockAccessCheckedLate(Server):
    """Takes a block download to a read-only object and refuses it with the end frame."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        return self.objects.find(request.mux)

    def check_block_size(self, transfer: BlockDownload, data: bytes) -> None:
        self.objects.writable(transfer.mux)
        super().check_block_size(transfer, data)


@unusual("domain-keeps-part-of-aborted-block")
class DomainKeepsPart(Server):
    """Has stored in a domain what came of a block download when it is aborted."""

    def react(self, request: Request) -> list[Response]:
        responses = super().react(request)
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and transfer.entry.data_type is DataType.DOMAIN:
            transfer.entry.value = bytes(transfer.data)
        return responses


@unusual("block-download-refused-inside")
class RefusedInside(Server):
    """Refuses what is longer than 300 bytes in mid-sub-block, and is idle for what still comes."""

    most = 300

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        entry = super().entry_to_write(request)
        entry.capacity = self.most
        return entry

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        entry = super().entry_to_write_in_blocks(request)
        entry.capacity = DEFAULT_CAPACITY
        return entry

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        super().take_block_segment(transfer, request)
        if transfer.entry.data_type.length is None and len(transfer.data) > self.most:
            raise Refusal(AbortCode.OUT_OF_MEMORY)


@unusual("last-segment-repeated-ignored")
class LastRepeatedIgnored(HearsLastRepeated):
    """Ignores a last segment that comes again where the end is due."""


@unusual("last-segment-repeated-acknowledged")
class LastRepeatedAcknowledged(HearsLastRepeated):
    """Acknowledges a last segment again that comes again where the end is due."""

    def on_repeated(self, transfer: BlockDownload, request: BlockSegment) -> list[Response]:
        return [BlockAck(request.sequence, transfer.block_size)]


@unusual("last-segment-repeated-refused")
class LastRepeatedRefused(HearsLastRepeated):
    """Refuses a last segment that comes again where the end is due."""

    def on_repeated(self, transfer: BlockDownload, request: BlockSegment) -> list[Response]:
        raise Refusal(AbortCode.COMMAND_NOT_VALID)


@unusual("old-numbers-refused")
class OldNumbersRefused(Server):
    """Ends a block download whose client goes on behind a gap with the old numbers, from 3 on."""

    old_number = 0

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        """Remember what would be next if the numbers went on."""
        self.old_number = transfer.due if transfer.broken else 0
        return super().acknowledge(transfer)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        old_number, self.old_number = self.old_number, 0
        if isinstance(self.transfer, BlockDownload) and request.sequence == old_number > 2:
            raise Refusal(AbortCode.INVALID_SEQUENCE_NUMBER)
        return super().on_block_segment(request)


@unusual("largest-size-taken")
class LargestSizeTaken(Server):
    """Takes FFFFFFFFh as the size of a block download for one that is not known."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        super().check_announced_size(entry, None if size == 0xFFFF_FFFF else size)


@unusual("size-checked-before-crc")
class SizeBeforeCrc(Server):
    """Looks at the size of a block download before its CRC."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        self.check_block_size(transfer, data)
        super().check_crc(transfer, request, data)
