"""The reference server as a node on the bus: which CAN frames reach it, which it sends.

Without I/O and without a clock: ``advance`` is told what time it is, in seconds on any scale, and
``wake_at`` says when that has to happen next although no frame came.
"""

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.segmented_server import SegmentedServer

REQUEST_BASE = 0x600
RESPONSE_BASE = 0x580
ERROR_CONTROL_BASE = 0x700
BOOT_UP = bytes(1)


class Node:
    """A server behind the default SDO channel: 600h and 580h plus node-ID (CiA 301, 7.3.5)."""

    def __init__(
        self, node_id: int, server: SegmentedServer, *, server_timeout: float | None = None
    ) -> None:
        """Take the node-ID, 1 to 127, and after how many seconds a silent client is given up."""
        self.node_id = node_id
        self.server = server
        self.server_timeout = server_timeout
        self.now = 0.0
        self._deadline: float | None = None
        self.request_id = REQUEST_BASE + node_id
        self.response_id = RESPONSE_BASE + node_id

    def start(self) -> list[CanFrame]:
        """Return what the node sends on its own when it starts: the boot-up message."""
        return [CanFrame(ERROR_CONTROL_BASE + self.node_id, BOOT_UP)]

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Take one frame from the bus; return the frames that answer it."""
        if not self.is_addressed(frame):
            return []
        frames = [self.respond(data) for data in self.server.receive(frame.data)]
        if self.server_timeout is not None:
            running = self.server.transfer is not None
            self._deadline = self.now + self.server_timeout if running else None
        return frames

    def is_addressed(self, frame: CanFrame) -> bool:
        """Say whether a frame is a request on this node's channel."""
        return frame.can_id == self.request_id and not frame.extended and not frame.remote

    def respond(self, data: bytes) -> CanFrame:
        """Put the data bytes of a response into a frame."""
        return CanFrame(self.response_id, data)

    @property
    def wake_at(self) -> float | None:
        """When ``advance`` has to be called at the latest; None as long as nothing is due."""
        return self._deadline

    def advance(self, now: float) -> list[CanFrame]:
        """Let it be ``now`` (seconds, never less than before); return what was due by then."""
        self.now = now
        if self._deadline is None or now < self._deadline:
            return []
        self._deadline = None
        return [self.respond(data) for data in self.server.expire()]
