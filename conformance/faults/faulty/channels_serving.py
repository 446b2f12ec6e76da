"""Nodes that serve on the wrong identifiers, or on channels that are not in use."""

from functools import partial

from conformance.faults import registry
from conformance.faults.registry import About, Defect
from conformance.reference.node import Node, ServerChannel
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import CobId

fault = partial(registry.fault, about=About.CHANNELS)


@fault("channel-answers-on-default", Defect.FRAME_SHAPE, "channel.")
class AnswersOnDefault(Node):
    """Answers requests on a further channel with the identifier of the default one."""

    def respond_on(self, channel: ServerChannel, data: bytes) -> CanFrame:
        return self.respond(data)


@fault(
    "channel-answers-on-both",
    Defect.FRAME_SHAPE,
    "channel.own-identifier",
    "channel.configured-by-itself",
)
class AnswersOnBoth(Node):
    """Answers requests on a further channel with the identifier of the default one as well."""

    def answers(self, channel: ServerChannel, responses: list[bytes]) -> list[CanFrame]:
        frames = super().answers(channel, responses)
        if channel is self.channels[0]:
            return frames
        return frames + [self.respond(data) for data in responses]


@fault("channel-never-serves", Defect.ROBUSTNESS, "channel.configured")
class NeverServes(Node):
    """Lets further channels be configured and answers on none of them."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        return False


@fault("channel-identifiers-swapped", Defect.FRAME_SHAPE, "channel.configured")
class Swapped(Node):
    """Takes sub-index 02h of a further record for requests and 01h for responses."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        return channel.record.is_valid and channel.record.response.matches(frame)

    def respond_on(self, channel: ServerChannel, data: bytes) -> CanFrame:
        return channel.record.request.frame(data)


@fault("channel-half-valid-serves", Defect.STATE, "channel.half-valid[response]")
class HalfValid(Node):
    """Serves on a channel whose request identifier is enabled, whatever the other one is."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        return channel.record.request.valid and channel.record.request.matches(frame)


@fault("channel-disabled-serves", Defect.STATE, "channel.disabled")
class DisabledServes(Node):
    """Goes on serving on a channel that was disabled."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        return channel.record.request.matches(frame)


@fault("channel-old-identifier-serves", Defect.STATE, "channel.moved")
class OldIdentifierServes(Node):
    """Keeps the first identifiers that a channel got."""

    first: CobId | None = None

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        if channel.record.is_valid and self.first is None:
            self.first = channel.record.request
        return super().is_on(channel, frame) or (
            channel is self.channels[1] and self.first is not None and self.first.matches(frame)
        )


@fault("channel-default-off", Defect.ROBUSTNESS, "channel.")
class DefaultOff(Node):
    """Closes the default channel as long as a further one is enabled."""

    def is_addressed(self, frame: CanFrame) -> bool:
        busy = any(channel.record.is_valid for channel in self.channels[1:])
        return super().is_addressed(frame) and not busy


@fault("channel-extended-answered-short", Defect.FRAME_SHAPE, "channel.extended")
class ExtendedAnsweredShort(Node):
    """Answers on a channel with 29-bit identifiers with the low 11 bits of its own."""

    def respond_on(self, channel: ServerChannel, data: bytes) -> CanFrame:
        return CanFrame(channel.record.response.can_id & 0x7FF, data)


@fault("channel-extended-not-served", Defect.FRAME_SHAPE, "channel.extended")
class ExtendedNotServed(Node):
    """Takes bit 29 of a COB-ID but receives 11-bit frames only."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        return not frame.extended and super().is_on(channel, frame)


@fault("channel-format-ignored", Defect.FRAME_SHAPE, "channel.extended-is-another")
class FormatIgnored(Node):
    """Takes a 29-bit frame for one with the same 11-bit identifier on a further channel."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        plain = CanFrame(frame.can_id, frame.data)
        return super().is_on(channel, frame) or super().is_on(channel, plain)
