"""A bus without threads and without time: the built-in device answers while a frame is sent."""

from collections import deque
from collections.abc import Iterable

import can

from conformance.bus.host import HostedNode
from conformance.bus.messages import to_frame, to_message


class SimulatedBus(can.BusABC):
    """A bus with nodes on it, for running all cases against hundreds of servers.

    What a node sends is there when ``send`` returns. When nothing is there, nothing will come:
    ``recv`` returns None at once, however long it was allowed to wait.
    """

    def __init__(self, nodes: Iterable[HostedNode]) -> None:
        """Start the nodes."""
        super().__init__(channel="simulated")
        self._nodes = list(nodes)
        self._incoming: deque[can.Message] = deque()
        for node in self._nodes:
            self._incoming.extend(map(to_message, node.start()))

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Hand a frame to every node and keep what they answer."""
        del timeout
        frame = to_frame(msg)
        for node in self._nodes:
            self._incoming.extend(map(to_message, node.receive(frame)))

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return what was sent first, or None. Nothing is filtered: a filter only saves time."""
        del timeout
        return self._incoming.popleft() if self._incoming else None
