"""Nodes whose SDO servers do not mind the NMT state, or that do not boot as they should."""

from functools import partial

from conformance.device.device import DEVICE_TYPE
from conformance.faults import registry
from conformance.faults.addressed_objects import DOWNLOADS, initiated
from conformance.faults.own_clock import OwnClock
from conformance.faults.registry import About, Defect
from conformance.reference.node import Node
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand, NmtState, error_control

fault = partial(registry.fault, about=About.NMT)
# In seconds.
IMPATIENCE = 0.025
_UPLOAD_INITIATE = 0x40


class _InStopped(Node):
    """Does something with requests that come in Stopped."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if self.state is NmtState.STOPPED and self.is_addressed(frame):
            return self.on_stopped(frame)
        return super().receive(frame)

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        """Take a request in Stopped."""
        return []


@fault("nmt-stopped-answers", Defect.STATE, "nmt.stopped-silent")
class StoppedAnswers(_InStopped):
    """Serves SDO in Stopped as in any other state."""

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        return [self.respond(data) for data in self.server.receive(frame.data)]


@fault("nmt-stopped-aborts", Defect.STATE, "nmt.stopped-silent")
class StoppedAborts(_InStopped):
    """Refuses requests in Stopped with an abort instead of being silent."""

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        mux = initiated(frame) or DEVICE_TYPE
        return [self.respond(Abort(mux, AbortCode.DEVICE_STATE).encode())]


@fault("nmt-stopped-answers-later", Defect.STATE, "nmt.stopped-silent")
class StoppedAnswersLater(_InStopped):
    """Keeps a request that came in Stopped and answers it when it may."""

    kept: CanFrame | None = None

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        self.kept = frame
        return []

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        frames = super().follow(command)
        if self.state.serves_sdo and self.kept is not None:
            kept, self.kept = self.kept, None
            frames += self.receive(kept)
        return frames


@fault("nmt-stopped-writes", Defect.STATE, "nmt.stopped-writes-nothing")
class StoppedWrites(_InStopped):
    """Carries out expedited downloads in Stopped, without an answer."""

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        if initiated(frame, DOWNLOADS) is not None and frame.data[0] & 0xE2 == 0x22:
            self.server.receive(frame.data)
        return []


@fault("nmt-stopped-transfer-goes-on", Defect.STATE, "nmt.stopped-in-transfer")
class StoppedTransferGoesOn(_InStopped):
    """Goes on with a transfer that was running when it was stopped."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        kept = self.server.transfer
        frames = super().follow(command)
        if command is NmtCommand.STOP:
            self.server.transfer = kept
        return frames

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        if self.server.transfer is None:
            return []
        return [self.respond(data) for data in self.server.receive(frame.data)]


@fault("nmt-stopped-says-farewell-twice", Defect.STATE, "nmt.stopped-in-transfer")
class FarewellTwice(Node):
    """Sends two aborts when it is stopped in the middle of a transfer."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        transfer = self.server.transfer
        frames = super().follow(command)
        if command is NmtCommand.STOP and transfer is not None:
            abort = Abort(transfer.mux, AbortCode.CONNECTION_NOT_AVAILABLE)
            frames += [self.respond(abort.encode())] * 2
        return frames


@fault("nmt-stopped-for-good", Defect.STATE, "nmt.stopped-silent")
class StoppedForGood(Node):
    """Serves SDO no more after it was in Stopped, until it is reset."""

    halted = False

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        self.halted = command is NmtCommand.STOP or (
            self.halted and command is not NmtCommand.RESET_NODE
        )
        return super().follow(command)

    def is_addressed(self, frame: CanFrame) -> bool:
        return not self.halted and super().is_addressed(frame)


@fault("nmt-stopped-in-transfer-wedges", Defect.STATE, "nmt.stopped-in-transfer")
class StoppedWedges(Node):
    """Refuses everything after it was stopped in the middle of a transfer."""

    wedged = False

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        self.wedged |= command is NmtCommand.STOP and self.server.transfer is not None
        return super().follow(command)

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        mux = initiated(frame, DOWNLOADS)
        if self.wedged and self.is_addressed(frame) and mux is not None:
            return [self.respond(Abort(mux, AbortCode.DEVICE_STATE).encode())]
        return super().receive(frame)


@fault("nmt-operational-silent", Defect.STATE, "nmt.serves[operational]")
class OperationalSilent(Node):
    """Serves SDO in Pre-operational only."""

    def is_addressed(self, frame: CanFrame) -> bool:
        return self.state is not NmtState.OPERATIONAL and super().is_addressed(frame)


class _ReadOnlyIn(Node):
    """Refuses every download in a state as one of a read-only object."""

    read_only = NmtState.OPERATIONAL

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        mux = initiated(frame, DOWNLOADS)
        if self.state is self.read_only and self.is_addressed(frame) and mux is not None:
            return [self.respond(Abort(mux, AbortCode.WRITE_OF_READ_ONLY).encode())]
        return super().receive(frame)


@fault("nmt-operational-read-only", Defect.STATE, "nmt.serves[operational]")
class OperationalReadOnly(_ReadOnlyIn):
    """Refuses every download in Operational as one of a read-only object."""


@fault("nmt-pre-operational-read-only", Defect.STATE, "nmt.serves[pre-operational]")
class PreOperationalReadOnly(_ReadOnlyIn):
    """Refuses every download in Pre-operational as one of a read-only object."""

    read_only = NmtState.PRE_OPERATIONAL


@fault("nmt-reset-communication-without-boot-up", Defect.STATE, "nmt.reset-boots[communication]")
class NoBootUp(Node):
    """Sends no boot-up message after a reset of the communication."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        frames = super().follow(command)
        return [] if command is NmtCommand.RESET_COMMUNICATION else frames


@fault("nmt-reset-node-ignored", Defect.STATE, "nmt.reset-boots[node]")
class ResetIgnored(Node):
    """Knows no reset of the node."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        return [] if command is NmtCommand.RESET_NODE else super().follow(command)


@fault("nmt-boot-up-as-heartbeat", Defect.STATE, "nmt.reset-boots")
class BootUpAsHeartbeat(Node):
    """Boots with a heartbeat of Pre-operational instead of the boot-up message."""

    booted = False

    def start(self) -> list[CanFrame]:
        """Tell the state that comes, but the first time."""
        frames = super().start()
        booted, self.booted = self.booted, True
        return [error_control(self.node_id, self.state)] if booted else frames


@fault("nmt-reset-stays-stopped", Defect.STATE, "nmt.reset-from-stopped")
class ResetStaysStopped(Node):
    """Is in Stopped again after a reset in Stopped."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        stopped = self.state is NmtState.STOPPED
        frames = super().follow(command)
        if stopped and frames:
            self.state = NmtState.STOPPED
        return frames


@fault("nmt-reset-keeps-transfer", Defect.STATE, "nmt.reset-ends-transfer")
class ResetKeepsTransfer(Node):
    """Goes on with a transfer after a reset of the communication."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        kept = self.server.transfer
        frames = super().follow(command)
        if command is NmtCommand.RESET_COMMUNICATION:
            self.server.transfer = kept
        return frames


@fault("nmt-reset-clears-objects", Defect.STATE, "nmt.reset-keeps-objects")
class ResetClears(Node):
    """Forgets its serial number in a reset of the communication."""

    def restore(self, *, communication_only: bool) -> None:
        super().restore(communication_only=communication_only)
        self.objects.find(Multiplexer(0x1018, 4)).value = bytes(4)


@fault("nmt-heartbeat-wrong-state", Defect.STATE, "nmt.heartbeat[operational]")
class HeartbeatWrongState(Node):
    """Tells Pre-operational in its heartbeats in Operational."""

    def heartbeat(self) -> CanFrame:
        operational = self.state is NmtState.OPERATIONAL
        state = NmtState.PRE_OPERATIONAL if operational else self.state
        return error_control(self.node_id, state)


@fault("nmt-heartbeat-for-ever", Defect.TIMING, "nmt.heartbeat")
class HeartbeatForEver(Node):
    """Does not stop its heartbeats when 1017h is set to 0."""

    latest = 0.0

    def heartbeat_seconds(self) -> float:
        self.latest = super().heartbeat_seconds() or self.latest
        return self.latest


@fault("nmt-heartbeat-never", Defect.TIMING, "nmt.heartbeat")
class HeartbeatNever(Node):
    """Takes a time in 1017h and sends no heartbeats."""

    def heartbeat_seconds(self) -> float:
        return 0.0


@fault("nmt-heartbeat-in-seconds", Defect.TIMING, "nmt.heartbeat")
class HeartbeatInSeconds(Node):
    """Takes the time in 1017h for seconds."""

    def heartbeat_seconds(self) -> float:
        return super().heartbeat_seconds() * 1000


@fault("gives-up-after-25-ms", Defect.TIMING, "nmt.")
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


@fault("first-request-lost", Defect.ROBUSTNESS, "nmt.first-request")
class FirstLost(Node):
    """Does not answer the first request after it has booted."""

    fresh = True

    def start(self) -> list[CanFrame]:
        self.fresh = True
        return super().start()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if not self.state.serves_sdo or not self.is_addressed(frame):
            return super().receive(frame)
        fresh, self.fresh = self.fresh, False
        return [] if fresh and not self.answers_first(frame) else super().receive(frame)

    def answers_first(self, frame: CanFrame) -> bool:
        """Say whether the first request is answered all the same."""
        return False


@fault("first-request-unanswered", Defect.ROBUSTNESS, "nmt.first-request")
class FirstUnanswered(FirstLost):
    """Does not answer the first request after it has booted unless it is an upload initiate."""

    def answers_first(self, frame: CanFrame) -> bool:
        return frame.data[:1] == bytes([_UPLOAD_INITIATE])
