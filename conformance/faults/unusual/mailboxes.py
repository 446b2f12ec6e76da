"""Servers that are written as firmware is: mailboxes, and a main loop that looks at them."""

from collections import deque

from conformance.faults.own_clock import OwnClock
from conformance.faults.registry import About, unusual
from conformance.reference.node import Node
from conformance.reference.segmented_server import SegmentedServer
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.limits import LARGEST_BLOCK
from conformance.sdo.nmt import NMT_ID

# Seconds from one look of the main loop to the next, and of a silence that ends a sub-block.
TICK = 0.001
SILENCE = 0.05


class BlocksOf1(Server):
    """Asks for sub-blocks of 1 segment."""

    def next_block_size(self) -> int:
        return 1


class _Mailboxes(Node):
    """Has a mailbox of ``room`` frames for each of its channels; what does not fit in is lost."""

    room = 1

    def __init__(
        self, node_id: int, *servers: SegmentedServer, server_timeout: float | None = None
    ) -> None:
        super().__init__(node_id, *servers, server_timeout=server_timeout)
        self.boxes: dict[int, deque[CanFrame]] = {}
        self.look_at: float | None = None

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Keep a request until the main loop looks at it."""
        channel = self.channel_of(frame)
        if frame.can_id == NMT_ID or channel is None:
            return super().receive(frame)
        number = self.channels.index(channel)
        box = self.boxes.setdefault(number, deque())
        if len(box) < self.room_of(number):
            box.append(frame)
            self.look_at = self.look_at or self.now + TICK
        return []

    def room_of(self, channel: int) -> int:
        """Return how many frames the mailbox of a channel takes; the default channel is 0."""
        return self.room

    def start(self) -> list[CanFrame]:
        """Forget what has come before."""
        self.boxes.clear()
        return super().start()

    @property
    def wake_at(self) -> float | None:
        """Also when the main loop looks."""
        due = [time for time in (super().wake_at, self.look_at) if time is not None]
        return min(due, default=None)

    def advance(self, now: float) -> list[CanFrame]:
        """Serve what is in the mailboxes."""
        frames = super().advance(now)
        if self.look_at is None or now < self.look_at:
            return frames
        self.look_at = None
        for box in self.boxes.values():
            while box:
                frames += super().receive(box.popleft())
        return frames


@unusual("room-for-one-request", about=About.TIME, server=BlocksOf1)
class RoomForOne(_Mailboxes):
    """Has room for one request, and loses what comes before that is served, a millisecond later."""


@unusual("room-for-three-frames", about=About.TIME, soft=True)
class RoomForThree(_Mailboxes, OwnClock):
    """Has room for three frames: what comes behind them before the next millisecond is lost.

    It asks for 127 segments at once, and acknowledges what it has of them after a silence of 50 ms.
    Its further channels have room for all of them.
    """

    room = 3

    def room_of(self, channel: int) -> int:
        return LARGEST_BLOCK if channel else self.room

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        transfer = self.server.transfer
        if self.is_addressed(frame) and isinstance(transfer, BlockDownload) and not transfer.ended:
            self.own_due = self.now + SILENCE
        return super().receive(frame)

    def when_due(self) -> list[bytes]:
        server, transfer = self.server, self.server.transfer
        waits = isinstance(transfer, BlockDownload) and not transfer.ended
        if isinstance(server, Server) and isinstance(transfer, BlockDownload) and waits:
            return [server.acknowledge(transfer).encode()]
        return []

    def respond(self, data: bytes) -> CanFrame:
        """Start no silence behind an acknowledgement: what was lost is told with it."""
        self.own_due = None
        return super().respond(data)
