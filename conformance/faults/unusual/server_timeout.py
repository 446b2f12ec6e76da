"""Nodes that are right in time in their own way: slow ones, and those that give up clients."""

from functools import partial

from conformance.faults import registry
from conformance.faults.own_clock import AnswersLater, OwnClock
from conformance.faults.registry import About
from conformance.reference.segmented_server import SegmentedServer
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.can_frame import CanFrame

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
