"""Nodes whose SDO channels know of each other, or answer where they should not."""

from conformance.faults.initiates import initiated
from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import CobId
from conformance.sdo.frames import Abort
from conformance.sdo.layout import Multiplexer
from conformance.sdo.node import Node, ServerChannel
from conformance.sdo.segmented_server import Download, SegmentedServer, Upload

STATE = DefectClass.STATE
LEAK = DefectClass.LEAK
SHAPE = DefectClass.FRAME_SHAPE
ROBUST = DefectClass.ROBUSTNESS


# Which frames reach a channel, and where it answers


@fault("channel-answers-on-default", SHAPE, "channel.")
class AnswersOnDefault(Node):
    """Answers requests on a further channel with the identifier of the default one."""

    def respond_on(self, channel: ServerChannel, data: bytes) -> CanFrame:
        """Use the one response identifier."""
        return self.respond(data)


@fault("channel-answers-on-both", SHAPE, "channel.own-identifier")
class AnswersOnBoth(Node):
    """Answers requests on a further channel with the identifier of the default one as well."""

    def answers(self, channel: ServerChannel, responses: list[bytes]) -> list[CanFrame]:
        """Repeat each answer."""
        frames = super().answers(channel, responses)
        if channel is self.channels[0]:
            return frames
        return frames + [self.respond(data) for data in responses]


@fault("channel-never-serves", ROBUST, "channel.configured")
class NeverServes(Node):
    """Lets further channels be configured and answers on none of them."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        """Take no frame for a request."""
        return False


@fault("channel-identifiers-swapped", SHAPE, "channel.configured")
class Swapped(Node):
    """Takes sub-index 02h of a further record for requests and 01h for responses."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        """Look at sub-index 02h."""
        return channel.record.is_valid and channel.record.response.matches(frame)

    def respond_on(self, channel: ServerChannel, data: bytes) -> CanFrame:
        """Use sub-index 01h."""
        return channel.record.request.frame(data)


@fault("channel-half-valid-serves", STATE, "channel.half-valid[response]")
class HalfValid(Node):
    """Serves on a channel whose request identifier is enabled, whatever the other one is."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        """Look at bit 31 of sub-index 01h only."""
        return channel.record.request.valid and channel.record.request.matches(frame)


@fault("channel-disabled-serves", STATE, "channel.disabled")
class DisabledServes(Node):
    """Goes on serving on a channel that was disabled."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        """Do not look at bit 31."""
        return channel.record.request.matches(frame)


@fault("channel-old-identifier-serves", STATE, "channel.moved")
class OldIdentifierServes(Node):
    """Keeps the first identifiers that a channel got."""

    first: CobId | None = None

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        """Remember what was enabled first."""
        if channel.record.is_valid and self.first is None:
            self.first = channel.record.request
        return super().is_on(channel, frame) or (
            channel is self.channels[1] and self.first is not None and self.first.matches(frame)
        )


@fault("channel-default-off", ROBUST, "channel.")
class DefaultOff(Node):
    """Closes the default channel as long as a further one is enabled."""

    def is_addressed(self, frame: CanFrame) -> bool:
        """Ask whether another channel is there."""
        busy = any(channel.record.is_valid for channel in self.channels[1:])
        return super().is_addressed(frame) and not busy


@fault("channel-extended-answered-short", SHAPE, "channel.extended")
class ExtendedAnsweredShort(Node):
    """Answers on a channel with 29-bit identifiers with the low 11 bits of its own."""

    def respond_on(self, channel: ServerChannel, data: bytes) -> CanFrame:
        """Cut the identifier."""
        return CanFrame(channel.record.response.can_id & 0x7FF, data)


@fault("channel-extended-not-served", SHAPE, "channel.extended")
class ExtendedNotServed(Node):
    """Takes bit 29 of a COB-ID but receives 11-bit frames only."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        """Ignore 29-bit frames."""
        return not frame.extended and super().is_on(channel, frame)


@fault("channel-format-ignored", SHAPE, "channel.extended-is-another")
class FormatIgnored(Node):
    """Takes a 29-bit frame for one with the same 11-bit identifier on a further channel."""

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        """Look at the number alone."""
        plain = CanFrame(frame.can_id, frame.data)
        return super().is_on(channel, frame) or super().is_on(channel, plain)


# What channels have to do with each other


class _Linked(Node):
    """Does something to the other channels after each request on one."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Serve, and touch the others."""
        responses = super().serve(channel, frame)
        for other in self.channels:
            if other is not channel:
                self.touch(channel, other.server, frame)
        return responses

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        """Do it."""


@fault("channels-share-transfer", STATE, "independence.")
class ShareTransfer(_Linked):
    """Keeps one transfer for all channels."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        """Give it to the other ones."""
        other.transfer = channel.server.transfer


@fault("channels-share-transfer-beyond-the-second", STATE, "independence.three")
class ShareBeyondSecond(Node):
    """Keeps one transfer for all channels but the default one."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Give it to the other ones."""
        responses = super().serve(channel, frame)
        if channel is not self.channels[0]:
            for other in self.channels[1:]:
                other.server.transfer = channel.server.transfer
        return responses


@fault("channels-share-toggle", STATE, "independence.")
class ShareToggle(_Linked):
    """Keeps one toggle bit for all segmented transfers."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        """Let the other ones have it."""
        own, others = channel.server.transfer, other.transfer
        if isinstance(own, Upload | Download) and isinstance(others, Upload | Download):
            others.toggle = own.toggle


@fault("channels-share-download-buffer", LEAK, "independence.interleaved")
class ShareBuffer(_Linked):
    """Collects the segments of all downloads in one buffer."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        """Let the other ones have what came."""
        own, others = channel.server.transfer, other.transfer
        if isinstance(own, Download) and isinstance(others, Download):
            others.data[: len(own.data)] = own.data


@fault("channels-share-upload-buffer", LEAK, "independence.interleaved[upload-and-upload]")
class ShareUploadBuffer(_Linked):
    """Reads the segments of all uploads from one buffer."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        """Overwrite what the other ones send."""
        own, others = channel.server.transfer, other.transfer
        if isinstance(own, Upload) and isinstance(others, Upload):
            others.data = own.data[: len(others.data)].ljust(len(others.data), b"\0")


@fault("channel-abort-ends-all", STATE, "independence.abort")
class AbortEndsAll(_Linked):
    """Ends the transfers of all channels when a client aborts one."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        """End it."""
        if frame.data[:1] == b"\x80":
            other.transfer = None


@fault("channel-refusal-ends-all", STATE, "independence.refusal")
class RefusalEndsAll(_Linked):
    """Ends the transfers of all channels when the server aborts one."""

    refused = False

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Look whether it does."""
        responses = super().serve(channel, frame)
        if any(data[:1] == b"\x80" for data in responses):
            for other in self.channels:
                other.server.transfer = None
        return responses


@fault("channel-initiate-ends-all", STATE, "independence.")
class InitiateEndsAll(_Linked):
    """Ends the transfers of other channels when one begins with a read."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        """End it."""
        if frame.data[:1] == b"\x40":
            other.transfer = None


class _Busy(Node):
    """Refuses requests on one channel in the middle of a transfer on another."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Ask whether any other channel is busy."""
        busy = any(
            other.server.transfer is not None for other in self.channels if other is not channel
        )
        mux = initiated(frame)
        if busy and channel.server.transfer is None and mux is not None:
            return self.refuse(mux)
        return super().serve(channel, frame)

    def refuse(self, mux: Multiplexer) -> list[bytes]:
        """Say so."""
        return [Abort(mux, AbortCode.LOCAL_CONTROL).encode()]


@fault("channel-busy-for-all-objects", ROBUST, "independence.")
class BusyForAll(_Busy):
    """Serves nothing on one channel during a transfer on another, whatever the object is."""


@fault("channel-busy-silent", ROBUST, "independence.")
class BusySilent(_Busy):
    """Does not answer at all on one channel during a transfer on another."""

    def refuse(self, mux: Multiplexer) -> list[bytes]:
        """Keep silent."""
        return []


_SEGMENTS = tuple(bytes((command,)) for command in (*range(0x20), 0x60, 0x70))


@fault("channel-segment-goes-elsewhere", STATE, "independence.segment-elsewhere")
class SegmentGoesElsewhere(Node):
    """Hands a segment that meets no transfer on its channel to a channel that has one."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Look for a transfer."""
        if channel.server.transfer is None and frame.data[:1] in _SEGMENTS:
            for other in self.channels:
                if other.server.transfer is not None:
                    return other.server.receive(frame.data)
        return super().serve(channel, frame)


@fault("channel-same-object-mixed", LEAK, "independence.same-object[download]")
class SameObjectMixed(_Linked):
    """Writes what came last on any channel into the end of a download to the same object."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        """Overwrite the last byte."""
        own, others = channel.server.transfer, other.transfer
        if not isinstance(own, Download) or not isinstance(others, Download):
            return
        if own.mux == others.mux and own.data and others.data:
            others.data[-1] = own.data[-1]


@fault("channel-same-object-wrong-code", DefectClass.ABORT, "independence.same-object")
class SameObjectWrongCode(_Busy):
    """Refuses an object that another channel uses as if it did not exist."""

    def refuse(self, mux: Multiplexer) -> list[bytes]:
        """Use 06020000h."""
        return [Abort(mux, AbortCode.OBJECT_MISSING).encode()]
