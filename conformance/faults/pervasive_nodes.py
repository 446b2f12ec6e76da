"""Nodes whose one defect is in frames or in time, and hides what else is wrong.

Each was met in devices that others made. They leave what they are not about to the class that
follows, so that each can be put together with any other fault.
"""

from conformance.faults.registry import DefectClass, fault
from conformance.faults.server_timeouts import OwnClock
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.node import Node

# In seconds.
IMPATIENCE = 0.025
_UPLOAD_INITIATE = 0x40


@fault("answer-as-long-as-request", DefectClass.FRAME_SHAPE, "frame.short")
class AsLongAsRequest(Node):
    """Serves requests of 1 to 7 bytes, and sends answers of as many."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Read what is missing as 0, and keep the DLC."""
        if not self.is_addressed(frame) or not 0 < frame.dlc < FRAME_LENGTH:
            return super().receive(frame)
        padded = CanFrame(frame.can_id, frame.data.ljust(FRAME_LENGTH, b"\0"))
        return [
            CanFrame(self.response_id, answer.data[: frame.dlc])
            if answer.can_id == self.response_id
            else answer
            for answer in super().receive(padded)
        ]


@fault("deaf-after-remote-frame", DefectClass.ROBUSTNESS, "frame.remote")
class DeafAfterRemote(Node):
    """Hears nothing more on its request identifier once it has got a remote frame there."""

    deaf = False

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Be deaf, for good."""
        ours = frame.can_id == self.request_id and not frame.extended
        self.deaf |= ours and frame.remote
        return [] if ours and self.deaf else super().receive(frame)


@fault("gives-up-after-25-ms", DefectClass.TIMING, "nmt.")
class GivesUpEarly(OwnClock):
    """Says 25 ms after the last request that it gives up, whether or not a transfer is running."""

    about = Multiplexer(0)

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Wind up the clock with each request that begins a transfer or belongs to one."""
        if self.server.transfer is not None:
            self.about = self.server.transfer.mux
        running = self.server.transfer is not None
        frames = super().receive(frame)
        if self.server.transfer is not None:
            self.about = self.server.transfer.mux
        if running or self.server.transfer is not None:
            self.own_due = self.now + IMPATIENCE
        return frames

    def when_due(self) -> list[bytes]:
        """Give up; not know that there is nothing to give up."""
        return super().when_due() or [Abort(self.about, AbortCode.TIMED_OUT).encode()]


@fault("first-request-unanswered", DefectClass.ROBUSTNESS, "nmt.first-request")
class FirstUnanswered(Node):
    """Does not answer the first request after it has booted unless it is an upload initiate."""

    fresh = True

    def start(self) -> list[CanFrame]:
        """Have got none."""
        self.fresh = True
        return super().start()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Drop one."""
        if not self.state.serves_sdo or not self.is_addressed(frame):
            return super().receive(frame)
        fresh, self.fresh = self.fresh, False
        if fresh and frame.data[:1] != bytes([_UPLOAD_INITIATE]):
            return []
        return super().receive(frame)
