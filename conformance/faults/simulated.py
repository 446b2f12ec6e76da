"""A bus without threads, on which time passes as fast as it is waited for."""

from collections import deque
from collections.abc import Iterable

import can

from conformance.bus.host import HostedNode
from conformance.bus.messages import to_frame, to_message
from conformance.sdo.can_frame import CanFrame


class SimulatedBus(can.BusABC):
    """A bus with nodes on it, for running all cases against hundreds of servers.

    What a node sends is there when ``send`` returns. When nothing is there, ``recv`` lets pass
    the time that it was allowed to wait, in no time.
    """

    def __init__(self, nodes: Iterable[HostedNode]) -> None:
        """Start the nodes."""
        super().__init__(channel="simulated")
        self._nodes = list(nodes)
        self._now = 0.0
        self._incoming: deque[can.Message] = deque()
        for node in self._nodes:
            self._take(node.advance(self._now))
            self._take(node.start())

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Hand a frame to every node and keep what they answer."""
        del timeout
        frame = to_frame(msg)
        for node in self._nodes:
            self._take(node.advance(self._now))
            self._take(node.receive(frame))

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return what was sent first, or None. Nothing is filtered: a filter only saves time."""
        end = self._now + (timeout or 0.0)
        while not self._incoming and (due := self._next_due()) is not None and due <= end:
            self._now = max(self._now, due)
            for node in self._nodes:
                self._take(node.advance(self._now))
        if self._incoming:
            return self._incoming.popleft()
        self._now = end
        return None

    def _take(self, frames: Iterable[CanFrame]) -> None:
        self._incoming.extend(map(to_message, frames))

    def _next_due(self) -> float | None:
        """Return when a node next has something to do."""
        times = [node.wake_at for node in self._nodes if node.wake_at is not None]
        return min(times, default=None)
