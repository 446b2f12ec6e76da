"""Nodes that store parameters and load their defaults, in wrong ways and in unusual ones.

All of those that are about defaults have other values stored when a run begins: what a device that
was never configured loads cannot be seen.
"""

from conformance.faults.dictionary import CLIENT
from conformance.faults.registry import DefectClass, fault, variant
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import Abort, DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.node import Node, ServerChannel
from conformance.sdo.objects import Access, DataType, Entry
from conformance.sdo.segmented_server import SegmentedServer
from conformance.sdo.storage import LOAD, LOAD_ALL, SAVE, SAVE_ALL, SIGNATURES

STATE = DefectClass.STATE
STORED = {
    Multiplexer(0x2002): b"\x02\x01",
    Multiplexer(0x2004): b"\4\3\2\1",
    Multiplexer(0x2010): b"stored",
    Multiplexer(0x2100, 1): b"\x21",
    Multiplexer(CLIENT, 3): b"\x07",
}
FORGOTTEN = Multiplexer(0x2100, 1)


@variant("configured-and-not-stored")
class NotStored(Node):
    """Was configured before the run, and keeps that until it is reset."""

    configured = False

    def start(self) -> list[CanFrame]:
        """Be configured when it is switched on: its EDS knows nothing of it."""
        if not self.configured:
            self.configured = True
            for mux, value in STORED.items():
                if (entry := self.objects.get(mux)) is not None:
                    entry.value = value
            self.keep()
        return super().start()

    def keep(self) -> None:
        """Store nothing."""


@variant("parameters-stored")
class ParametersStored(NotStored):
    """Was configured before the run, and keeps that without power."""

    def keep(self) -> None:
        """Store it."""
        self.save()


@variant("defaults-loaded-at-once")
class LoadedAtOnce(ParametersStored):
    """Has its defaults as soon as it has confirmed "load"."""

    def load_defaults(self) -> None:
        """Do not wait for the reset."""
        super().load_defaults()
        self.restore(communication_only=False)


@variant("stores-by-itself")
class StoresByItself(Node):
    """Stores at once what is written from 2000h on, and has no commands for that or defaults."""

    def __init__(
        self,
        node_id: int,
        server: SegmentedServer,
        *further: SegmentedServer,
        server_timeout: float | None = None,
    ) -> None:
        """Say so in 1010h:01 and 1011h:01."""
        super().__init__(node_id, server, *further, server_timeout=server_timeout)
        for mux, value in ((SAVE_ALL, b"\2\0\0\0"), (LOAD_ALL, bytes(4))):
            self.objects.add({mux: Entry(value, DataType.UNSIGNED32, Access.RO)})

    def restore(self, *, communication_only: bool) -> None:
        """Keep what was written to the device itself."""
        super().restore(communication_only=True)


@fault("load-defaults-refused", STATE, "od.load-defaults")
class LoadRefused(ParametersStored):
    """Says in 1011h:01 that it loads its defaults, and refuses to."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Refuse the signature."""
        if frame.data[1:4] == b"\x11\x10\x01" and frame.data[4:] == LOAD:
            return [Abort(LOAD_ALL, AbortCode.NOT_TRANSFERABLE).encode()]
        return super().serve(channel, frame)


@fault("load-defaults-silent", STATE, "od.load-defaults")
class LoadSilent(ParametersStored):
    """Loads its defaults and does not confirm it."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Keep the confirmation."""
        responses = super().serve(channel, frame)
        return [] if frame.data[1:] == b"\x11\x10\x01" + LOAD else responses


@fault("load-defaults-ignored", STATE, "od.default-of-parameter[2004h:00]")
class LoadIgnored(ParametersStored):
    """Confirms "load" and keeps what is stored."""

    def load_defaults(self) -> None:
        """Do nothing."""


@fault("load-defaults-forgets-an-object", STATE, "od.default-of-parameter[2100h:01]")
class LoadForgets(ParametersStored):
    """Loads the defaults of all objects but one."""

    def load_defaults(self) -> None:
        """Keep its stored value."""
        kept = self.objects.find(FORGOTTEN)
        stored = [place for place in self.power_on if place[0] is kept]
        super().load_defaults()
        others = [place for place in self.power_on if place[0] is not kept]
        self.power_on = others + stored


@fault("load-defaults-until-reset", STATE, "od.default-of-parameter")
class LoadedUntilReset(ParametersStored):
    """Loads its defaults at once, and after the reset it has again what was stored."""

    def load_defaults(self) -> None:
        """Change what is in use only."""
        stored = self.power_on
        super().load_defaults()
        self.restore(communication_only=False)
        self.power_on = stored


@fault("load-defaults-of-communication-only", STATE, "od.default-of-parameter[2010h:00]")
class LoadsCommunicationOnly(ParametersStored):
    """Loads the defaults of its communication objects, though it was asked for all."""

    def load_defaults(self) -> None:
        """Keep what is stored beyond 1FFFh."""
        stored = [place for place in self.power_on if not place[1]]
        super().load_defaults()
        self.power_on = [place for place in self.power_on if place[1]] + stored


@fault("load-defaults-others", STATE, "od.default-of-parameter[1017h:00]")
class LoadsOthers(ParametersStored):
    """Loads other values than its defaults."""

    def load_defaults(self) -> None:
        """Change a bit in the last byte of all that may be written."""
        super().load_defaults()
        self.power_on = [
            (entry, in_area, self.changed(value) if entry.access.writable else value)
            for entry, in_area, value in self.power_on
        ]

    def changed(self, value: bytes) -> bytes:
        """Return another value of the same length."""
        return value[:-1] + bytes(byte ^ 1 for byte in value[-1:])


# Signatures


class AnySignature(ParametersStored):
    """Takes other signatures for its own as well."""

    command = SAVE_ALL

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Serve the right signature in the place of a wrong one."""
        request = decode_request(frame.data)
        if (
            isinstance(request, DownloadInitiate)
            and request.mux == self.command
            and self.taken(request.payload)
        ):
            right = DownloadInitiate.with_data(self.command, SIGNATURES[self.command])
            frame = frame._replace(data=right.encode())
        return super().serve(channel, frame)

    def taken(self, data: bytes) -> bool:
        """Take everything."""
        return True


@fault("store-any-signature", STATE, "od.save-signature")
class StoreAnySignature(AnySignature):
    """Stores its parameters whatever is written to 1010h:01."""


@fault("store-signature-reversed", STATE, "od.save-signature")
class StoreSignatureReversed(AnySignature):
    """Takes "save" with its bytes in either order."""

    def taken(self, data: bytes) -> bool:
        """Take it the other way round, too."""
        return data == SAVE[::-1]


@fault("store-signature-of-the-other", STATE, "od.save-signature")
class StoreSignatureOfTheOther(AnySignature):
    """Stores its parameters when "load" is written to 1010h:01."""

    def taken(self, data: bytes) -> bool:
        """Take "load" for "save"."""
        return data == LOAD


@fault("load-any-signature", STATE, "od.load-signature")
class LoadAnySignature(AnySignature):
    """Loads its defaults whatever is written to 1011h:01."""

    command = LOAD_ALL


@fault("load-signature-in-capitals", STATE, "od.load-signature")
class LoadSignatureInCapitals(AnySignature):
    """Loads its defaults for "LOAD" as well."""

    command = LOAD_ALL

    def taken(self, data: bytes) -> bool:
        """Take capitals."""
        return data == LOAD.upper()


@fault("store-signature-wrong-code", DefectClass.ABORT, "od.save-signature")
class SignatureWrongCode(Node):
    """Refuses what is no signature as if 1010h:01 were read-only."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Use 06010002h."""
        responses = super().serve(channel, frame)
        wrong = Abort(SAVE_ALL, AbortCode.NOT_TRANSFERABLE).encode()
        other = Abort(SAVE_ALL, AbortCode.WRITE_OF_READ_ONLY).encode()
        return [other if response == wrong else response for response in responses]


# Records of SDO channels over resets and storing


@fault("channel-gone-after-reset", STATE, "channel.records-after-reset")
class ChannelGone(Node):
    """Has 1202h no more after a reset of the communication, and again after the next."""

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Take it out, or put it in."""
        if command is NmtCommand.RESET_COMMUNICATION:
            record = self.channels[2].record.by_multiplexer()
            if self.objects.get(Multiplexer(0x1202, 1)) is None:
                self.objects.add(record)
            else:
                self.objects.remove(0x1202)
        return super().follow(command)


@fault("channel-other-with-each-reset", STATE, "channel.records-after-reset")
class ChannelOther(Node):
    """Gives its further channels other COB-IDs with each reset of the communication."""

    resets = 0

    def restore(self, *, communication_only: bool) -> None:
        """Count up."""
        super().restore(communication_only=communication_only)
        self.resets += 1
        entry = self.objects.find(Multiplexer(0x1201, 1))
        entry.value = bytes((self.resets,)) + entry.value[1:]


@fault("channel-missing-in-the-middle-wrong-code", DefectClass.ABORT, "channel.records")
class MiddleWrongCode(Node):
    """Refuses a read of 1240h with the code for a value that is out of range."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Use 06090030h."""
        if frame.data[:4] == b"\x40\x40\x12\x01":
            return [Abort(Multiplexer(0x1240, 1), AbortCode.VALUE_INVALID).encode()]
        return super().serve(channel, frame)


@fault("channel-client-cleared-by-store", STATE, "channel.clients-after-store")
class ClientCleared(Node):
    """Stores zeros in the place of the COB-IDs of its client."""

    def save(self) -> None:
        """Forget bit 31."""
        super().save()
        lost = [self.objects.get(Multiplexer(CLIENT, sub_index)) for sub_index in (1, 2)]
        self.power_on = [
            (entry, in_area, bytes(4) if any(entry is one for one in lost) else value)
            for entry, in_area, value in self.power_on
        ]


@fault("store-confirmed-and-ignored", STATE, "channel.client-stored")
class StoreIgnored(Node):
    """Confirms "save" and stores nothing."""

    def save(self) -> None:
        """Do nothing."""


@fault("store-refused", STATE, "channel.client-stored")
class StoreRefused(Node):
    """Says in 1010h:01 that it stores, and refuses to."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Refuse the signature."""
        if frame.data[1:] == b"\x10\x10\x01save":
            return [Abort(Multiplexer(0x1010, 1), AbortCode.NOT_TRANSFERABLE).encode()]
        return super().serve(channel, frame)
