"""Nodes that are right in their SDO channels in their own way."""

from functools import partial

from conformance.faults import registry
from conformance.faults.addressed_objects import initiated
from conformance.faults.altered_nodes import AlteredNode
from conformance.faults.registry import About
from conformance.reference.node import Node, ServerChannel
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.channel_parameters import ServerParameter
from conformance.sdo.cob_id import CobId
from conformance.sdo.frames import Abort
from conformance.sdo.objects import Refusal

unusual = partial(registry.unusual, about=About.CHANNELS)


@unusual("no-further-channels")
class NoFurtherChannels(AlteredNode):
    """Has the default channel only."""

    most_further = 0


@unusual("one-further-channel")
class OneFurtherChannel(AlteredNode):
    """Has one channel beside the default one."""

    most_further = 1


@unusual("channels-with-client-node-id")
class ChannelsWithClient(Node):
    """Has a sub-index 03h in all its further records."""

    def further_record(self, number: int) -> ServerParameter:
        return ServerParameter.further(number, self.check_cob_id, self.check_client)


@unusual("channels-without-client-node-id")
class ChannelsWithoutClient(Node):
    """Has no sub-index 03h in its further records."""

    def further_record(self, number: int) -> ServerParameter:
        return ServerParameter.further(number, self.check_cob_id)


@unusual("channels-11-bit-only")
class ElevenBitOnly(Node):
    """Refuses bit 29 of a COB-ID."""

    def check_format(self, wanted: CobId) -> None:
        super().check_format(wanted)
        if wanted.extended:
            raise Refusal(AbortCode.VALUE_INVALID)


@unusual("channels-static-only")
class StaticOnly(Node):
    """Refuses bit 30 of a COB-ID, which was reserved once."""

    def check_format(self, wanted: CobId) -> None:
        super().check_format(wanted)
        if wanted.dynamic:
            raise Refusal(AbortCode.VALUE_INVALID)


@unusual("channel-in-use-is-locked")
class LockedInUse(Node):
    """Takes nothing for a COB-ID in use but bit 31, not even its own value."""

    def check_in_use(self, before: CobId, wanted: CobId) -> None:
        if before.valid and wanted != before.disabled():
            raise Refusal(AbortCode.DEVICE_STATE)


@unusual("channel-restricted-refused-early")
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
        mux = initiated(frame)
        used = {
            other.server.transfer.mux
            for other in self.channels
            if other is not channel and other.server.transfer is not None
        }
        if mux is not None and channel.server.transfer is None and mux in used:
            return [Abort(mux, self.code).encode()]
        return super().serve(channel, frame)


@unusual("object-busy-with-08000021")
class BusyLocalControl(_OneClientAtATime):
    """Refuses an object that another channel uses with 08000021h."""


@unusual("object-busy-with-060A0023")
class BusyConnection(_OneClientAtATime):
    """Refuses an object that another channel uses with 060A0023h."""

    code = AbortCode.CONNECTION_NOT_AVAILABLE
