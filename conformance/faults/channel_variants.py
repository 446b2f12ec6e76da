"""Nodes that are unusual, and right, in their SDO channels, in NMT and in what else they send."""

from conformance.faults.altered_nodes import AlteredNode
from conformance.faults.initiates import DOWNLOADS, initiated
from conformance.faults.registry import variant
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import CobId
from conformance.sdo.errors import register_of
from conformance.sdo.frames import Abort
from conformance.sdo.nmt import NMT_ID, NmtCommand, emergency
from conformance.sdo.node import HEARTBEAT_TIME, Node, ServerChannel
from conformance.sdo.objects import Access, DataType, Refusal
from conformance.sdo.parameters import CheckedEntry, ServerParameter

COMMUNICATION_ERROR = 0x8100
SHORTEST_HEARTBEAT = 50


@variant("no-further-channels")
class NoFurtherChannels(AlteredNode):
    """Has the default channel only."""

    most_further = 0


@variant("one-further-channel")
class OneFurtherChannel(AlteredNode):
    """Has one channel beside the default one."""

    most_further = 1


@variant("channels-with-client-node-id")
class ChannelsWithClient(Node):
    """Has a sub-index 03h in all its further records."""

    def further_record(self, number: int) -> ServerParameter:
        """Return one that has it."""
        return ServerParameter.further(number, self.check_cob_id, self.check_client)


@variant("channels-without-client-node-id")
class ChannelsWithoutClient(Node):
    """Has no sub-index 03h in its further records."""

    def further_record(self, number: int) -> ServerParameter:
        """Return one without it."""
        return ServerParameter.further(number, self.check_cob_id)


@variant("channels-11-bit-only")
class ElevenBitOnly(Node):
    """Refuses bit 29 of a COB-ID."""

    def check_format(self, wanted: CobId) -> None:
        """Refuse it."""
        super().check_format(wanted)
        if wanted.extended:
            raise Refusal(AbortCode.VALUE_INVALID)


@variant("channels-static-only")
class StaticOnly(Node):
    """Refuses bit 30 of a COB-ID, which was reserved once."""

    def check_format(self, wanted: CobId) -> None:
        """Refuse it."""
        super().check_format(wanted)
        if wanted.dynamic:
            raise Refusal(AbortCode.VALUE_INVALID)


@variant("channel-in-use-is-locked")
class LockedInUse(Node):
    """Takes nothing for a COB-ID in use but bit 31, not even its own value."""

    def check_in_use(self, before: CobId, wanted: CobId) -> None:
        """Ask for bit 31."""
        if before.valid and wanted != before.disabled():
            raise Refusal(AbortCode.DEVICE_STATE)


@variant("channel-restricted-refused-early")
class RestrictedEarly(Node):
    """Refuses a restricted CAN-ID also while the channel is not in use."""

    def check_restricted(self, wanted: CobId) -> None:
        """Ask as if it were; 000h is what a channel has before it gets one."""
        if wanted.can_id:
            super().check_restricted(CobId(wanted.can_id, wanted.extended))
        super().check_restricted(wanted)


class _OneClientAtATime(Node):
    """Refuses an object that is in a transfer on another channel."""

    code = AbortCode.LOCAL_CONTROL

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Look at the other transfers."""
        mux = initiated(frame)
        used = {
            other.server.transfer.mux
            for other in self.channels
            if other is not channel and other.server.transfer is not None
        }
        if mux is not None and channel.server.transfer is None and mux in used:
            return [Abort(mux, self.code).encode()]
        return super().serve(channel, frame)


@variant("object-busy-with-08000021")
class BusyLocalControl(_OneClientAtATime):
    """Refuses an object that another channel uses with 08000021h."""


@variant("object-busy-with-060A0023")
class BusyConnection(_OneClientAtATime):
    """Refuses an object that another channel uses with 060A0023h."""

    code = AbortCode.CONNECTION_NOT_AVAILABLE


@variant("stopped-with-an-abort")
class StoppedWithAbort(Node):
    """Ends a transfer that is running when it is stopped with an abort."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Say goodbye on every channel that is busy."""
        frames: list[CanFrame] = []
        for channel in self.channels if command is NmtCommand.STOP else ():
            if channel.server.transfer is not None:
                mux = channel.server.transfer.mux
                abort = Abort(mux, AbortCode.CONNECTION_NOT_AVAILABLE)
                frames += self.answers(channel, [abort.encode()])
        return frames + super().follow(command)


@variant("no-heartbeat")
class NoHeartbeat(AlteredNode):
    """Has no 1017h."""

    def alter(self) -> None:
        """Take it out of the object dictionary."""
        self.objects.remove(HEARTBEAT_TIME.index)


@variant("heartbeat-time-constant")
class HeartbeatConstant(AlteredNode):
    """Has a 1017h that reads 0 and refuses every write."""

    def alter(self) -> None:
        """Make it a constant."""
        self.heartbeat_time.access = Access.CONST


@variant("heartbeat-time-constant-5-ms")
class HeartbeatConstantFast(AlteredNode):
    """Tells its state every 5 ms, and refuses every write of 1017h."""

    def alter(self) -> None:
        """Set the time that it powers on with, and make it a constant."""
        self.heartbeat_time.value = b"\x05\0"
        self.heartbeat_time.access = Access.CONST
        self.defaults = self.power_on = self.present()


@variant("heartbeat-every-3-ms")
class HeartbeatEvery3Ms(AlteredNode):
    """Tells its state every 3 ms until 1017h is written."""

    def alter(self) -> None:
        """Set the time that it powers on with."""
        self.heartbeat_time.value = b"\3\0"
        self.defaults = self.power_on = self.present()


@variant("heartbeats-of-20-ms-refused")
class HeartbeatsRare(AlteredNode):
    """Takes no time of fewer than 50 ms in 1017h but 0."""

    def alter(self) -> None:
        """Set up a check."""
        entry = CheckedEntry(bytes(2), DataType.UNSIGNED16, check=self.check_period)
        self.heartbeat_time = entry
        self.objects.add({HEARTBEAT_TIME: entry})
        self.defaults = self.power_on = self.present()

    def check_period(self, old: bytes, new: bytes) -> None:
        """Refuse what is too short."""
        if 0 < int.from_bytes(new, "little") < SHORTEST_HEARTBEAT:
            raise Refusal(AbortCode.VALUE_TOO_LOW)


@variant("heartbeats-queued")
class HeartbeatsQueued(Node):
    """Sends three heartbeats that were queued when 1017h is written, and one more behind that."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """The answer has the higher priority: it overtakes the last of them."""
        beating = self.heartbeat_seconds() > 0
        frames = super().receive(frame)
        if not beating or initiated(frame, DOWNLOADS) != HEARTBEAT_TIME:
            return frames
        return [self.heartbeat()] * 3 + frames + [self.heartbeat()]


@variant("operational-at-once")
class OperationalAtOnce(Node):
    """Enters Operational by itself behind its boot-up message."""

    def start(self) -> list[CanFrame]:
        """Go on."""
        frames = super().start()
        return frames + self.follow(NmtCommand.START)


@variant("emergencies-within-transfers")
class EmergenciesWithinTransfers(Node):
    """Reports an error with each SDO frame that comes, and one before each that it sends."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Put emergencies between the frames, where they may be sent."""
        frames = super().receive(frame)
        if frame.can_id == NMT_ID or not self.state.serves_sdo:
            return frames
        error = emergency(self.node_id, COMMUNICATION_ERROR, register_of(COMMUNICATION_ERROR))
        over = emergency(self.node_id, 0, 0)
        return [error, *(one for answer in frames for one in (error, answer)), over]
