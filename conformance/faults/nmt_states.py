"""Nodes whose SDO servers do not mind the NMT state, and nodes that do not boot as they should."""

from conformance.device.device import DEVICE_TYPE
from conformance.faults.initiates import DOWNLOADS, initiated
from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand, NmtState, error_control
from conformance.sdo.node import Node

STATE = DefectClass.STATE
TIMING = DefectClass.TIMING


class _InStopped(Node):
    """Does something with requests that come in Stopped."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Look at the state."""
        if self.state is NmtState.STOPPED and self.is_addressed(frame):
            return self.on_stopped(frame)
        return super().receive(frame)

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        """Take a request in Stopped."""
        return []


@fault("nmt-stopped-answers", STATE, "nmt.stopped-silent")
class StoppedAnswers(_InStopped):
    """Serves SDO in Stopped as in any other state."""

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        """Serve it."""
        return [self.respond(data) for data in self.server.receive(frame.data)]


@fault("nmt-stopped-aborts", STATE, "nmt.stopped-silent")
class StoppedAborts(_InStopped):
    """Refuses requests in Stopped with an abort instead of being silent."""

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        """Abort."""
        mux = initiated(frame) or DEVICE_TYPE
        return [self.respond(Abort(mux, AbortCode.DEVICE_STATE).encode())]


@fault("nmt-stopped-answers-later", STATE, "nmt.stopped-silent")
class StoppedAnswersLater(_InStopped):
    """Keeps a request that came in Stopped and answers it when it may."""

    kept: CanFrame | None = None

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        """Keep it."""
        self.kept = frame
        return []

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Answer what was kept."""
        frames = super().follow(command)
        if self.state.serves_sdo and self.kept is not None:
            kept, self.kept = self.kept, None
            frames += self.receive(kept)
        return frames


@fault("nmt-stopped-writes", STATE, "nmt.stopped-writes-nothing")
class StoppedWrites(_InStopped):
    """Carries out expedited downloads in Stopped, without an answer."""

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        """Serve it in silence."""
        if initiated(frame, DOWNLOADS) is not None and frame.data[0] & 0xE2 == 0x22:
            self.server.receive(frame.data)
        return []


@fault("nmt-stopped-transfer-goes-on", STATE, "nmt.stopped-in-transfer")
class StoppedTransferGoesOn(_InStopped):
    """Goes on with a transfer that was running when it was stopped."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Keep the transfer."""
        kept = self.server.transfer
        frames = super().follow(command)
        if command is NmtCommand.STOP:
            self.server.transfer = kept
        return frames

    def on_stopped(self, frame: CanFrame) -> list[CanFrame]:
        """Serve segments."""
        if self.server.transfer is None:
            return []
        return [self.respond(data) for data in self.server.receive(frame.data)]


@fault("nmt-stopped-says-farewell-twice", STATE, "nmt.stopped-in-transfer")
class FarewellTwice(Node):
    """Sends two aborts when it is stopped in the middle of a transfer."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Abort twice."""
        transfer = self.server.transfer
        frames = super().follow(command)
        if command is NmtCommand.STOP and transfer is not None:
            abort = Abort(transfer.mux, AbortCode.CONNECTION_NOT_AVAILABLE)
            frames += [self.respond(abort.encode())] * 2
        return frames


@fault("nmt-stopped-for-good", STATE, "nmt.stopped-silent")
class StoppedForGood(Node):
    """Serves SDO no more after it was in Stopped, until it is reset."""

    halted = False

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Remember a stop."""
        self.halted = command is NmtCommand.STOP or (
            self.halted and command is not NmtCommand.RESET_NODE
        )
        return super().follow(command)

    def is_addressed(self, frame: CanFrame) -> bool:
        """Take no frame for a request then."""
        return not self.halted and super().is_addressed(frame)


@fault("nmt-stopped-in-transfer-wedges", STATE, "nmt.stopped-in-transfer")
class StoppedWedges(Node):
    """Refuses everything after it was stopped in the middle of a transfer."""

    wedged = False

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Remember a transfer."""
        self.wedged |= command is NmtCommand.STOP and self.server.transfer is not None
        return super().follow(command)

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Refuse downloads then."""
        mux = initiated(frame, DOWNLOADS)
        if self.wedged and self.is_addressed(frame) and mux is not None:
            return [self.respond(Abort(mux, AbortCode.DEVICE_STATE).encode())]
        return super().receive(frame)


@fault("nmt-operational-silent", STATE, "nmt.serves[operational]")
class OperationalSilent(Node):
    """Serves SDO in Pre-operational only."""

    def is_addressed(self, frame: CanFrame) -> bool:
        """Look at the state."""
        return self.state is not NmtState.OPERATIONAL and super().is_addressed(frame)


class _ReadOnlyIn(Node):
    """Refuses every download in a state."""

    read_only = NmtState.OPERATIONAL

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Look at the state."""
        mux = initiated(frame, DOWNLOADS)
        if self.state is self.read_only and self.is_addressed(frame) and mux is not None:
            return [self.respond(Abort(mux, AbortCode.DEVICE_STATE).encode())]
        return super().receive(frame)


@fault("nmt-operational-read-only", STATE, "nmt.serves[operational]")
class OperationalReadOnly(_ReadOnlyIn):
    """Refuses every download in Operational."""


@fault("nmt-pre-operational-read-only", STATE, "nmt.serves[pre-operational]")
class PreOperationalReadOnly(_ReadOnlyIn):
    """Refuses every download in Pre-operational."""

    read_only = NmtState.PRE_OPERATIONAL


@fault("nmt-reset-communication-without-boot-up", STATE, "nmt.reset-boots[communication]")
class NoBootUp(Node):
    """Sends no boot-up message after a reset of the communication."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Leave it away."""
        frames = super().follow(command)
        return [] if command is NmtCommand.RESET_COMMUNICATION else frames


@fault("nmt-reset-node-ignored", STATE, "nmt.reset-boots[node]")
class ResetIgnored(Node):
    """Knows no reset of the node."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Do nothing."""
        return [] if command is NmtCommand.RESET_NODE else super().follow(command)


@fault("nmt-boot-up-as-heartbeat", STATE, "nmt.reset-boots")
class BootUpAsHeartbeat(Node):
    """Boots with a heartbeat of Pre-operational instead of the boot-up message."""

    booted = False

    def start(self) -> list[CanFrame]:
        """Tell the state that comes, but the first time."""
        frames = super().start()
        booted, self.booted = self.booted, True
        return [error_control(self.node_id, self.state)] if booted else frames


@fault("nmt-reset-stays-stopped", STATE, "nmt.reset-from-stopped")
class ResetStaysStopped(Node):
    """Is in Stopped again after a reset in Stopped."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Keep the state."""
        stopped = self.state is NmtState.STOPPED
        frames = super().follow(command)
        if stopped and frames:
            self.state = NmtState.STOPPED
        return frames


@fault("nmt-reset-keeps-transfer", STATE, "nmt.reset-ends-transfer")
class ResetKeepsTransfer(Node):
    """Goes on with a transfer after a reset of the communication."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Keep it."""
        kept = self.server.transfer
        frames = super().follow(command)
        if command is NmtCommand.RESET_COMMUNICATION:
            self.server.transfer = kept
        return frames


@fault("nmt-reset-clears-objects", STATE, "nmt.reset-keeps-objects")
class ResetClears(Node):
    """Forgets its serial number in a reset of the communication."""

    def restore(self, *, communication_only: bool) -> None:
        """Set 1018h:04 to 0."""
        super().restore(communication_only=communication_only)
        self.objects.find(Multiplexer(0x1018, 4)).value = bytes(4)


@fault("nmt-heartbeat-wrong-state", STATE, "nmt.heartbeat[operational]")
class HeartbeatWrongState(Node):
    """Tells Pre-operational in its heartbeats in Operational."""

    def heartbeat(self) -> CanFrame:
        """Confuse them."""
        operational = self.state is NmtState.OPERATIONAL
        state = NmtState.PRE_OPERATIONAL if operational else self.state
        return error_control(self.node_id, state)


@fault("nmt-heartbeat-for-ever", TIMING, "nmt.heartbeat")
class HeartbeatForEver(Node):
    """Does not stop its heartbeats when 1017h is set to 0."""

    latest = 0.0

    def heartbeat_seconds(self) -> float:
        """Keep the last time that was set."""
        self.latest = super().heartbeat_seconds() or self.latest
        return self.latest


@fault("nmt-heartbeat-never", TIMING, "nmt.heartbeat")
class HeartbeatNever(Node):
    """Takes a time in 1017h and sends no heartbeats."""

    def heartbeat_seconds(self) -> float:
        """Do not look at 1017h."""
        return 0.0


@fault("nmt-heartbeat-in-seconds", TIMING, "nmt.heartbeat")
class HeartbeatInSeconds(Node):
    """Takes the time in 1017h for seconds."""

    def heartbeat_seconds(self) -> float:
        """Forget the factor."""
        return super().heartbeat_seconds() * 1000
