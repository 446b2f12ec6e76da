"""Nodes that are right in NMT, and in what they send unasked, in their own way."""

from functools import partial

from conformance.faults import registry
from conformance.faults.addressed_objects import DOWNLOADS, initiated
from conformance.faults.altered_nodes import AlteredNode
from conformance.faults.own_clock import OwnClock
from conformance.faults.registry import About
from conformance.reference.dictionary import PLACES_FOR_ERRORS
from conformance.reference.node import HEARTBEAT_TIME, Node, ServerChannel
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.channel_parameters import CheckedEntry
from conformance.sdo.emergency import error_list, register_of
from conformance.sdo.frames import Abort
from conformance.sdo.nmt import TRANSITIONS, NmtCommand, NmtState, emergency
from conformance.sdo.objects import Access, DataType, Refusal

unusual = partial(registry.unusual, about=About.NMT)
COMMUNICATION_ERROR = 0x8100
SHORTEST_HEARTBEAT = 50
STATE_CHANGE_SECONDS, SERVING_SECONDS = 0.07, 0.01


@unusual("stopped-with-an-abort")
class StoppedWithAbort(Node):
    """Ends a transfer that is running when it is stopped with an abort."""

    code = AbortCode.CONNECTION_NOT_AVAILABLE

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Say goodbye on every channel that is busy."""
        frames: list[CanFrame] = []
        for channel in self.channels if command is NmtCommand.STOP else ():
            if channel.server.transfer is not None:
                mux = channel.server.transfer.mux
                frames += self.answers(channel, [Abort(mux, self.code).encode()])
        return frames + super().follow(command)


@unusual("stopped-with-local-control")
class StoppedWithLocalControl(StoppedWithAbort):
    """Ends a transfer that is running when it is stopped with 08000021h."""

    code = AbortCode.LOCAL_CONTROL


@unusual("stopped-with-general-error")
class StoppedWithGeneralError(StoppedWithAbort):
    """Ends a transfer that is running when it is stopped with 08000000h."""

    code = AbortCode.GENERAL_ERROR


@unusual("no-heartbeat")
class NoHeartbeat(AlteredNode):
    """Has no 1017h."""

    def alter(self) -> None:
        self.objects.remove(HEARTBEAT_TIME.index)


@unusual("heartbeat-time-constant")
class HeartbeatConstant(AlteredNode):
    """Has a 1017h that reads 0 and refuses every write."""

    def alter(self) -> None:
        self.heartbeat_time.access = Access.CONST


@unusual("heartbeat-time-constant-5-ms")
class HeartbeatConstantFast(AlteredNode):
    """Tells its state every 5 ms, and refuses every write of 1017h."""

    def alter(self) -> None:
        self.heartbeat_time.value = b"\x05\0"
        self.heartbeat_time.access = Access.CONST
        self.defaults = self.power_on = self.present()


@unusual("heartbeat-every-3-ms")
class HeartbeatEvery3Ms(AlteredNode):
    """Tells its state every 3 ms until 1017h is written."""

    def alter(self) -> None:
        self.heartbeat_time.value = b"\3\0"
        self.defaults = self.power_on = self.present()


@unusual("heartbeats-of-20-ms-refused")
class HeartbeatsRare(AlteredNode):
    """Takes no time of fewer than 50 ms in 1017h but 0."""

    def alter(self) -> None:
        entry = CheckedEntry(bytes(2), DataType.UNSIGNED16, check=self.check_period)
        self.heartbeat_time = entry
        self.objects.add({HEARTBEAT_TIME: entry})
        self.defaults = self.power_on = self.present()

    def check_period(self, old: bytes, new: bytes) -> None:
        """Refuse what is too short."""
        if 0 < int.from_bytes(new, "little") < SHORTEST_HEARTBEAT:
            raise Refusal(AbortCode.VALUE_TOO_LOW)


@unusual("heartbeats-queued")
class HeartbeatsQueued(Node):
    """Sends three heartbeats that were queued when 1017h is written, and one more behind that."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """The answer has the higher priority: it overtakes the last of them."""
        beating = self.heartbeat_seconds() > 0
        frames = super().receive(frame)
        if not beating or initiated(frame, DOWNLOADS) != HEARTBEAT_TIME:
            return frames
        return [self.heartbeat()] * 3 + frames + [self.heartbeat()]


@unusual("nmt-state-changes-after-70-ms")
class StateChangesLate(OwnClock):
    """Takes 70 ms to enter another state, and serves and beats in the old one up to then."""

    coming: NmtCommand | None = None

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Follow a reset at once."""
        if TRANSITIONS[command] is NmtState.INITIALISING:
            self.own_due = None
            return super().follow(command)
        self.coming, self.own_due = command, self.now + STATE_CHANGE_SECONDS
        return []

    def when_due(self) -> list[bytes]:
        """Enter the state."""
        if self.coming is not None:
            super().follow(self.coming)
        return []


@unusual("nmt-state-told-before-it-serves")
class ToldBeforeItServes(Node):
    """Tells each new state at once, and serves 10 ms after it has left Stopped."""

    serves_at = 0.0

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        if self.state is NmtState.STOPPED:
            self.serves_at = self.now + SERVING_SECONDS
        frames = super().follow(command)
        if self.heartbeat_seconds() and TRANSITIONS[command] is not NmtState.INITIALISING:
            frames.append(self.heartbeat())
        return frames

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Miss what comes before that."""
        return super().serve(channel, frame) if self.now >= self.serves_at else []


@unusual("operational-at-once")
class OperationalAtOnce(Node):
    """Enters Operational by itself behind its boot-up message."""

    def start(self) -> list[CanFrame]:
        frames = super().start()
        return frames + self.follow(NmtCommand.START)


@unusual("emergencies-within-transfers", lacking=frozenset(error_list(PLACES_FOR_ERRORS)))
class EmergenciesWithinTransfers(Node):
    """Reports an error with each SDO frame that comes, and one before each that it sends.

    It keeps no list of them.
    """

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Put emergencies between the frames, where they may be sent."""
        frames = super().receive(frame)
        if not self.is_addressed(frame) or not self.state.serves_sdo:
            return frames
        error = emergency(self.node_id, COMMUNICATION_ERROR, register_of(COMMUNICATION_ERROR))
        over = emergency(self.node_id, 0, 0)
        return [error, *(one for answer in frames for one in (error, answer)), over]
