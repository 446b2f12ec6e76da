"""What servers that deviate in block transfers have in common: they look where others do not."""

from conformance.reference.server import BlockDownload, BlockUpload, Server
from conformance.sdo.decoding import decode_segment
from conformance.sdo.frames import (
    BlockAck,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    Request,
    Response,
)
from conformance.sdo.objects import Entry


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


class ReadsAcknowledgements(Server):
    """Reads acknowledgements otherwise."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Pass each through ``read`` while segments are on their way."""
        transfer = self.transfer
        if isinstance(transfer, BlockUpload) and transfer.sent and not transfer.ended:
            request = self.read(transfer, request)
        return super().on_block_ack(request)

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Return what is made of it."""
        del transfer
        return request


class KnowsBlockUploads(Server):
    """Knows whether a value is read in blocks."""

    in_blocks = False

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Say so while the value is taken."""
        self.in_blocks = True
        try:
            return super().on_block_upload_initiate(request)
        finally:
            self.in_blocks = False


class HearsLastRepeated(Server):
    """Knows the last segment when it comes again where the end is due."""

    last_segment = b""

    def decode(self, frame: bytes) -> Request:
        """Take the same 8 bytes for the same segment."""
        at_end = isinstance(self.transfer, BlockDownload) and self.transfer.ended
        if at_end and frame == self.last_segment:
            return decode_segment(frame)
        return super().decode(frame)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Pass it to ``on_repeated`` there."""
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and transfer.ended:
            return self.on_repeated(transfer, request)
        if request.last:
            self.last_segment = request.encode()
        return super().on_block_segment(request)

    def on_repeated(self, transfer: BlockDownload, request: BlockSegment) -> list[Response]:
        """Ignore it."""
        del transfer, request
        return []
