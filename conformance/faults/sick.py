"""Servers that keep a client waiting: without an answer, without an end, or with each answer."""

from collections import deque

from conformance.faults.registry import DefectClass, fault, variant
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    Response,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NMT_ID
from conformance.sdo.node import Node
from conformance.sdo.segmented_server import SEGMENT_LENGTH, SegmentedServer, Upload
from conformance.sdo.server import BlockUpload, Server

DROPPED = 3
# Requests that are answered before the device is gone: it dies while it is got to know.
ANSWERED = 12
# In seconds: below the usual time-out of 1 s.
SLOW = 0.9


@fault("third-request-unanswered", DefectClass.ROBUSTNESS, "upload.")
class ThirdUnanswered(Node):
    """Does not answer every third request."""

    count = 0

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Drop it."""
        if self.state.serves_sdo and self.is_addressed(frame):
            self.count += 1
            if self.count % DROPPED == 0:
                return []
        return super().receive(frame)


@fault("dies-at-once", DefectClass.ROBUSTNESS, "upload.")
class DiesAtOnce(Node):
    """Does not answer any more after the first twelve requests."""

    left = ANSWERED

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Be gone."""
        if self.is_addressed(frame):
            self.left -= 1
        return super().receive(frame) if self.left >= 0 else []


@fault("uploads-endless", DefectClass.LAST_FLAG, "segmented-upload.size")
class UploadsEndless(Server):
    """Sends the bytes of an upload in segments over and over, says no size and marks no last."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Say nothing of the size."""
        response = super().start_upload(mux, data)
        return response if response.expedited else UploadInitiateResponse.with_size(mux, None)

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Start again at the end."""
        transfer = self.transfer
        if not isinstance(transfer, Upload):
            return super().on_upload_segment(request)
        self.check_toggle(transfer, request.toggle)
        transfer.toggle ^= 1
        data = (transfer.data or b"\0") * SEGMENT_LENGTH
        return [UploadSegmentResponse(data[:SEGMENT_LENGTH], toggle=request.toggle)]


@fault("block-uploads-endless", DefectClass.LAST_FLAG, "block-upload.size")
class BlockUploadsEndless(Server):
    """Sends the bytes of a block upload over and over, says no size and marks no last segment."""

    def announce_block(
        self, request: BlockUploadInitiate, size: int, crc: bool
    ) -> BlockUploadInitiateResponse:
        """Say nothing of the size."""
        del size
        return BlockUploadInitiateResponse.with_size(request.mux, None, crc_supported=crc)

    def sub_block(self, transfer: BlockUpload) -> list[Response]:
        """Have more behind it."""
        segments = [BlockSegment(number + 1, bytes(7)) for number in range(transfer.block_size)]
        transfer.sent = transfer.block_size
        transfer.data += bytes(transfer.block_size * SEGMENT_LENGTH)
        return [*segments]


@variant("answers-after-900-ms")
class AnswersSlowly(Node):
    """Takes 0.9 s for each answer, which is less than what a client waits by default."""

    def __init__(
        self, node_id: int, *servers: SegmentedServer, server_timeout: float | None = None
    ) -> None:
        """Have nothing to answer."""
        super().__init__(node_id, *servers, server_timeout=server_timeout)
        self.held: deque[tuple[float, CanFrame]] = deque()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Hold back what answers a request."""
        frames = super().receive(frame)
        if frame.can_id == NMT_ID:
            return frames
        self.held.extend((self.now + SLOW, answer) for answer in frames)
        return []

    @property
    def wake_at(self) -> float | None:
        """Also look at the answers."""
        times = (super().wake_at, self.held[0][0] if self.held else None)
        due = [time for time in times if time is not None]
        return min(due, default=None)

    def advance(self, now: float) -> list[CanFrame]:
        """Answer what is due."""
        frames = super().advance(now)
        while self.held and self.held[0][0] <= now:
            frames.append(self.held.popleft()[1])
        return frames
