"""Servers in which one state of a transfer leaves something that only one other transfer finds."""

from conformance.faults.registry import About, Defect, fault
from conformance.reference.node import Node, ServerChannel
from conformance.reference.segmented_server import Upload
from conformance.reference.server import BlockDownload, BlockUpload, Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    Request,
    Response,
)


@fault("block-download-over-at-once", Defect.LEAK, "pairs.behind-abort", thorough=True)
class OverAtOnce(Server):
    """Takes a block download for complete at its beginning if a block upload was aborted so.

    The flag that all segments went is one for both; what ends or begins otherwise clears it.
    """

    complete = False

    def react(self, request: Request) -> list[Response]:
        running, complete = self.transfer, self.complete
        self.complete = False
        responses = super().react(request)
        if isinstance(request, Abort):
            self.complete = isinstance(running, BlockUpload) and running.ended
        elif isinstance(request, BlockDownloadInitiate) and isinstance(
            self.transfer, BlockDownload
        ):
            self.transfer.ended = complete
        return responses


@fault("block-upload-goes-on-from-upload", Defect.LEAK, "pairs.superseded", thorough=True)
class GoesOnFromUpload(Server):
    """Begins a block upload at the position of the upload in segments that it supersedes."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        running = self.transfer
        responses = super().on_block_upload_initiate(request)
        if isinstance(running, Upload) and isinstance(self.transfer, BlockUpload):
            self.transfer.offset = min(running.offset, len(self.transfer.data) - 1)
        return responses


@fault(
    "channels-share-segment-number",
    Defect.LEAK,
    "pairs.on-two-channels",
    about=About.CHANNELS,
    thorough=True,
)
class ShareSegmentNumber(Node):
    """Counts the segments of a sub-block with one counter for the block downloads of all channels.

    It shows where the sub-block of one channel comes between two segments of another.
    """

    due = 1

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        running = channel.server.transfer
        if isinstance(running, BlockDownload):
            running.due = self.due
        responses = super().serve(channel, frame)
        if isinstance(channel.server.transfer, BlockDownload):
            self.due = channel.server.transfer.due
        return responses
