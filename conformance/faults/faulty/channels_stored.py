"""Nodes whose SDO parameter records do not outlast a reset, or storing, as they should."""

from functools import partial

from conformance.faults import registry
from conformance.faults.registry import About, Defect
from conformance.reference.dictionary import CLIENT
from conformance.reference.node import Node, ServerChannel
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand

fault = partial(registry.fault, about=About.CHANNELS)


@fault("channel-gone-after-reset", Defect.STATE, "channel.records-after-reset")
class ChannelGone(Node):
    """Has 1202h no more after a reset of the communication, and again after the next."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        if command is NmtCommand.RESET_COMMUNICATION:
            record = self.channels[2].record.by_multiplexer()
            if self.objects.get(Multiplexer(0x1202, 1)) is None:
                self.objects.add(record)
            else:
                self.objects.remove(0x1202)
        return super().follow(command)


@fault("channel-other-with-each-reset", Defect.STATE, "channel.records-after-reset")
class ChannelOther(Node):
    """Gives its further channels other COB-IDs with each reset of the communication."""

    resets = 0

    def restore(self, *, communication_only: bool) -> None:
        super().restore(communication_only=communication_only)
        self.resets += 1
        entry = self.objects.find(Multiplexer(0x1201, 1))
        entry.value = bytes((self.resets,)) + entry.value[1:]


@fault("channel-missing-in-the-middle-wrong-code", Defect.ABORT, "channel.records")
class MiddleWrongCode(Node):
    """Refuses a read of 1240h with the code for a value that is out of range."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        if frame.data[:4] == b"\x40\x40\x12\x01":
            return [Abort(Multiplexer(0x1240, 1), AbortCode.VALUE_INVALID).encode()]
        return super().serve(channel, frame)


@fault("channel-client-cleared-by-store", Defect.STATE, "channel.clients-after-store")
class ClientCleared(Node):
    """Stores zeros in the place of the COB-IDs of its client."""

    def save(self) -> None:
        super().save()
        lost = [self.objects.get(Multiplexer(CLIENT, sub_index)) for sub_index in (1, 2)]
        self.power_on = [
            (entry, in_area, bytes(4) if any(entry is one for one in lost) else value)
            for entry, in_area, value in self.power_on
        ]


@fault("store-confirmed-and-ignored", Defect.STATE, "channel.client-stored")
class StoreIgnored(Node):
    """Confirms "save" and stores nothing."""

    def save(self) -> None:
        """Do nothing."""


@fault("store-refused", Defect.STATE, "channel.client-stored")
class StoreRefused(Node):
    """Says in 1010h:01 that it stores, and refuses to."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        if frame.data[1:] == b"\x10\x10\x01save":
            return [Abort(Multiplexer(0x1010, 1), AbortCode.NOT_TRANSFERABLE).encode()]
        return super().serve(channel, frame)
