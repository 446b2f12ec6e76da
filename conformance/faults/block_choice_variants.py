"""Servers that are unusual and right where a block transfer is repeated, restarted or refused."""

from conformance.faults.registry import variant
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    DownloadInitiate,
    Request,
    Response,
    UploadInitiate,
    decode_segment,
)
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.server import BlockDownload, BlockUpload, Server


class _HearsLastRepeated(Server):
    """Knows the last segment when it comes again where the end is due."""

    def decode(self, frame: bytes) -> Request:
        """Take byte 0 with bit 7 set for a last segment, but for 80h and the end itself."""
        at_end = isinstance(self.transfer, BlockDownload) and self.transfer.ended
        if at_end and len(frame) == 8 and 0x80 < frame[0] < 0xA0:
            return decode_segment(frame)
        return super().decode(frame)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """React to it."""
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and transfer.ended:
            return self.on_repeated(transfer, request)
        return super().on_block_segment(request)

    def on_repeated(self, transfer: BlockDownload, request: BlockSegment) -> list[Response]:
        """Ignore it."""
        del transfer, request
        return []


@variant("last-segment-repeated-ignored")
class LastRepeatedIgnored(_HearsLastRepeated):
    """Ignores a last segment that comes again where the end is due."""


@variant("last-segment-repeated-acknowledged")
class LastRepeatedAcknowledged(_HearsLastRepeated):
    """Acknowledges a last segment again that comes again where the end is due."""

    def on_repeated(self, transfer: BlockDownload, request: BlockSegment) -> list[Response]:
        """Repeat the answer."""
        return [BlockAck(request.sequence, transfer.block_size)]


@variant("last-segment-repeated-refused")
class LastRepeatedRefused(_HearsLastRepeated):
    """Refuses a last segment that comes again where the end is due."""

    def on_repeated(self, transfer: BlockDownload, request: BlockSegment) -> list[Response]:
        """Refuse it."""
        raise Refusal(AbortCode.COMMAND_NOT_VALID)


@variant("old-numbers-refused")
class OldNumbersRefused(Server):
    """Ends a block download whose next sub-block begins with segment 3 or a later one."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Refuse any other number there, once something is stored."""
        transfer = self.transfer
        begins = isinstance(transfer, BlockDownload) and transfer.data and transfer.due == 1
        if begins and request.sequence > 2:
            raise Refusal(AbortCode.INVALID_SEQUENCE_NUMBER)
        return super().on_block_segment(request)


@variant("threshold-before-block-size")
class ThresholdFirst(Server):
    """Answers a block upload with an ordinary one where pst allows it, whatever the block size."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Look at pst first."""
        data = self.value_to_read(self.objects.readable(request.mux))
        if self.switches_protocol(request, len(data)):
            self.transfer = None
            return [self.start_upload(request.mux, data)]
        return super().on_block_upload_initiate(request)


@variant("largest-size-taken")
class LargestSizeTaken(Server):
    """Takes FFFFFFFFh as the size of a block download for one that is not known."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """See later."""
        super().check_announced_size(entry, None if size == 0xFFFF_FFFF else size)


@variant("size-checked-before-crc")
class SizeBeforeCrc(Server):
    """Looks at the size of a block download before its CRC."""

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        """Let the size go first."""
        self.check_block_size(transfer, data)
        super().check_crc(transfer, request, data)


@variant("new-initiate-at-block-end-refused")
class NewInitiateAtEndRefused(Server):
    """Refuses an initiate where the end of a block transfer is due, in the initiate's own name."""

    def react(self, request: Request) -> list[Response]:
        """Refuse it; the transfer ends."""
        transfer = self.transfer
        at_end = isinstance(transfer, BlockDownload | BlockUpload) and transfer.ended
        if at_end and isinstance(
            request, UploadInitiate | DownloadInitiate | BlockUploadInitiate | BlockDownloadInitiate
        ):
            self.transfer = None
            return [Abort(request.mux, AbortCode.DEVICE_STATE)]
        return super().react(request)
