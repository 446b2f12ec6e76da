"""Nodes whose SDO channels know of each other."""

from functools import partial

from conformance.faults import registry
from conformance.faults.addressed_objects import initiated
from conformance.faults.own_clock import AnswersLater
from conformance.faults.registry import About, Defect
from conformance.reference.node import Node, ServerChannel
from conformance.reference.segmented_server import Download, SegmentedServer, Upload
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import is_abort
from conformance.sdo.frames import Abort
from conformance.sdo.layout import Multiplexer

fault = partial(registry.fault, about=About.CHANNELS)
_SEGMENTS = tuple(bytes((command,)) for command in (*range(0x20), 0x60, 0x70))


class _Linked(Node):
    """Does something to the other channels after each request on one."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        responses = super().serve(channel, frame)
        for other in self.channels:
            if other is not channel:
                self.touch(channel, other.server, frame)
        return responses

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        """Do it."""


@fault("channels-share-transfer", Defect.STATE, "independence.", "independence.client-vanished")
class ShareTransfer(_Linked):
    """Keeps one transfer for all channels."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        other.transfer = channel.server.transfer


@fault("channels-share-transfer-beyond-the-second", Defect.STATE, "independence.three")
class ShareBeyondSecond(Node):
    """Keeps one transfer for all channels but the default one."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        responses = super().serve(channel, frame)
        if channel is not self.channels[0]:
            for other in self.channels[1:]:
                other.server.transfer = channel.server.transfer
        return responses


@fault("channels-share-toggle", Defect.STATE, "independence.", "independence.toggle")
class ShareToggle(_Linked):
    """Keeps one toggle bit for all segmented transfers."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        own, others = channel.server.transfer, other.transfer
        if isinstance(own, Upload | Download) and isinstance(others, Upload | Download):
            others.toggle = own.toggle


@fault("channels-share-download-buffer", Defect.LEAK, "independence.interleaved")
class ShareBuffer(_Linked):
    """Collects the segments of all downloads in one buffer."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        own, others = channel.server.transfer, other.transfer
        if isinstance(own, Download) and isinstance(others, Download):
            others.data[: len(own.data)] = own.data


@fault("channels-share-upload-buffer", Defect.LEAK, "independence.interleaved[upload-and-upload]")
class ShareUploadBuffer(_Linked):
    """Reads the segments of all uploads from one buffer."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        own, others = channel.server.transfer, other.transfer
        if isinstance(own, Upload) and isinstance(others, Upload):
            others.data = own.data[: len(others.data)].ljust(len(others.data), b"\0")


@fault("channel-abort-ends-all", Defect.STATE, "independence.abort")
class AbortEndsAll(_Linked):
    """Ends the transfers of all channels when a client aborts one."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        if is_abort(frame.data):
            other.transfer = None


@fault("channel-refusal-ends-all", Defect.STATE, "independence.refusal")
class RefusalEndsAll(_Linked):
    """Ends the transfers of all channels when the server aborts one."""

    refused = False

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        responses = super().serve(channel, frame)
        if any(is_abort(data) for data in responses):
            for other in self.channels:
                other.server.transfer = None
        return responses


@fault("channel-initiate-ends-all", Defect.STATE, "independence.")
class InitiateEndsAll(_Linked):
    """Ends the transfers of other channels when one begins with a read."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
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
        return [Abort(mux, AbortCode.LOCAL_CONTROL).encode()]


@fault("channel-busy-for-all-objects", Defect.ROBUSTNESS, "independence.")
class BusyForAll(_Busy):
    """Serves nothing on one channel during a transfer on another, whatever the object is."""


@fault("channel-busy-silent", Defect.ROBUSTNESS, "independence.")
class BusySilent(_Busy):
    """Does not answer at all on one channel during a transfer on another."""

    def refuse(self, mux: Multiplexer) -> list[bytes]:
        return []


@fault("channel-segment-goes-elsewhere", Defect.STATE, "independence.segment-elsewhere")
class SegmentGoesElsewhere(Node):
    """Hands a segment that meets no transfer on its channel to a channel that has one."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        if channel.server.transfer is None and frame.data[:1] in _SEGMENTS:
            for other in self.channels:
                if other.server.transfer is not None:
                    return other.server.receive(frame.data)
        return super().serve(channel, frame)


@fault("channel-same-object-mixed", Defect.LEAK, "independence.same-object[download]")
class SameObjectMixed(_Linked):
    """Writes what came last on any channel into the end of a download to the same object."""

    def touch(self, channel: ServerChannel, other: SegmentedServer, frame: CanFrame) -> None:
        own, others = channel.server.transfer, other.transfer
        if not isinstance(own, Download) or not isinstance(others, Download):
            return
        if own.mux == others.mux and own.data and others.data:
            others.data[-1] = own.data[-1]


@fault("channel-same-object-wrong-code", Defect.ABORT, "independence.same-object")
class SameObjectWrongCode(_Busy):
    """Refuses an object that another channel uses as if it did not exist."""

    def refuse(self, mux: Multiplexer) -> list[bytes]:
        return [Abort(mux, AbortCode.OBJECT_MISSING).encode()]


@fault("channel-answer-forgotten", Defect.BACK_TO_BACK, "independence.next-request")
class AnswerForgotten(AnswersLater):
    """Has room for one answer: a request on another channel right behind takes its place."""

    delay = 0.001

    def hold(self, frames: list[CanFrame]) -> None:
        if frames and self.held and self.held[0][1].can_id != frames[0].can_id:
            self.held.clear()
        super().hold(frames)
