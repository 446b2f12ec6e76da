"""Nodes that are right in time in their own way: slow ones, and those that give up clients."""

from functools import partial

from conformance.faults import registry
from conformance.faults.own_clock import AnswersLater, OwnClock
from conformance.faults.registry import About
from conformance.reference.segmented_server import SegmentedServer
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import UploadInitiate
from conformance.sdo.layout import FRAME_LENGTH

unusual = partial(registry.unusual, about=About.TIME, timed=True)


class _Acknowledging(OwnClock):
    """Acknowledges a sub-block that does not go on, after a part of the time-out."""

    part = 1.0

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        frames = super().receive(frame)
        transfer = self.server.transfer
        waits = isinstance(transfer, BlockDownload) and transfer.due > 1 and not transfer.ended
        timeout = self.server_timeout
        self.own_due = None if timeout is None or not waits else self.now + timeout * self.part
        return frames

    def when_due(self) -> list[bytes]:
        server, transfer = self.server, self.server.transfer
        if isinstance(server, Server) and isinstance(transfer, BlockDownload):
            return [server.acknowledge(transfer).encode()]
        return []


@unusual("sub-block-acknowledged-after-silence")
class AcknowledgesAfterSilence(_Acknowledging):
    """Acknowledges what came of a sub-block soon after the client fell silent."""

    part = 0.05


@unusual("sub-block-acknowledged-before-giving-up")
class AcknowledgesBeforeGivingUp(_Acknowledging):
    """Acknowledges what came of a sub-block shortly before it gives the client up."""

    part = 0.8


@unusual("server-timeout-takes-half-as-long-again")
class HalfAsLongAgain(OwnClock):
    """Gives up somewhat later than declared: its timer is coarse."""

    def __init__(
        self, node_id: int, *servers: SegmentedServer, server_timeout: float | None = None
    ) -> None:
        longer = None if server_timeout is None else server_timeout * 1.5
        super().__init__(node_id, *servers, server_timeout=longer)


@registry.unusual("answers-after-900-ms", about=About.TIME)
class AnswersSlowly(AnswersLater):
    """Takes 0.9 s for each answer, which is less than what a client waits by default."""

    delay = 0.9


@registry.unusual("read-replaces-read-before", about=About.TIME)
class ReadReplacesRead(AnswersLater):
    """Has room for one read: the next one takes the place of one that is not answered yet."""

    delay = 0.001
    reads: int | None = None

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        request = decode_request(frame.data) if len(frame.data) == FRAME_LENGTH else None
        is_read = isinstance(request, UploadInitiate)
        if is_read and self.reads == frame.can_id:
            self.held.clear()
        self.reads = frame.can_id if is_read else None
        return super().receive(frame)
