"""Servers that are right, and lose some of the segments that come without a pause.

They say so in their acknowledgements, and take what is sent again.
"""

from dataclasses import replace

from conformance.faults.registry import unusual
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.frames import BlockAck, BlockDownloadInitiate, BlockSegment, Response
from conformance.sdo.limits import SEGMENT_LENGTH


class _LosesSegments(Server):
    """Loses segments of a sub-block; its end it recognises all the same."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        transfer = self.transfer
        due = isinstance(transfer, BlockDownload) and 1 <= request.sequence <= transfer.block_size
        if not isinstance(transfer, BlockDownload) or not due or not self.loses(transfer, request):
            return super().on_block_segment(request)
        transfer.broken = True
        return super().on_block_segment(request) if ends(transfer, request) else []

    def loses(self, transfer: BlockDownload, request: BlockSegment) -> bool:
        """Say whether a segment gets lost."""
        raise NotImplementedError


def ends(transfer: BlockDownload, request: BlockSegment) -> bool:
    """Say whether a segment is the last one of its sub-block."""
    return request.last or request.sequence == transfer.block_size


@unusual("burst-buffer-of-3", soft=True)
class BufferOf3(_LosesSegments):
    """Asks for 127 segments at once, and has a buffer for three."""

    most = 3

    def loses(self, transfer: BlockDownload, request: BlockSegment) -> bool:
        return request.sequence > self.most


@unusual("burst-buffer-of-3-blocks-of-4", soft=True)
class BufferOf3BlocksOf4(BufferOf3):
    """Asks for 4 segments at once, and has a buffer for three: no sub-block is taken whole."""

    def next_block_size(self) -> int:
        return 4


@unusual("burst-first-lost", soft=True)
class FirstLost(_LosesSegments):
    """Takes nothing of every other sub-block, as when it was busy with something else."""

    busy = False

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        self.busy = True
        return super().on_block_download_initiate(request)

    def loses(self, transfer: BlockDownload, request: BlockSegment) -> bool:
        return self.busy

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        self.busy = not self.busy
        return super().acknowledge(transfer)


@unusual("burst-last-lost", soft=True)
class LastLost(_LosesSegments):
    """Loses the last segment of the first sub-block of a transfer, and notices that."""

    left = False

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        self.left = True
        return super().on_block_download_initiate(request)

    def loses(self, transfer: BlockDownload, request: BlockSegment) -> bool:
        left = self.left and ends(transfer, request)
        self.left &= not left
        return left


@unusual("gap-has-whole-sub-block-repeated", soft=True)
class RepeatsWhole(Server):
    """Keeps nothing of a sub-block in which a segment is lost, and asks for all of it again."""

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        broken = transfer.broken
        ack = super().acknowledge(transfer)
        if not broken:
            return ack
        del transfer.data[len(transfer.data) - ack.sequence * SEGMENT_LENGTH :]
        return replace(ack, sequence=0)
