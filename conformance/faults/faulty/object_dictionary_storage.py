"""Nodes that store parameters and load their defaults in wrong ways.

All of those that are about defaults have other values stored when a run begins: what a device that
was never configured loads cannot be seen.
"""

from functools import partial

from conformance.faults import registry
from conformance.faults.registry import About, Defect
from conformance.faults.unusual.object_dictionary_storage import ParametersStored
from conformance.reference.node import Node, ServerChannel
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_request, is_abort
from conformance.sdo.frames import Abort, DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.storage_commands import (
    APPLICATION_PART,
    COMMUNICATION_PART,
    LOAD,
    LOAD_ALL,
    SAVE,
    SAVE_ALL,
    signature_of,
)

fault = partial(registry.fault, about=About.OBJECTS)
FORGOTTEN = Multiplexer(0x2100, 1)


@fault("load-defaults-refused", Defect.STATE, "od.load-defaults")
class LoadRefused(ParametersStored):
    """Says in 1011h:01 that it loads its defaults, and refuses to."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        if frame.data[1:4] == b"\x11\x10\x01" and frame.data[4:] == LOAD:
            return [Abort(LOAD_ALL, AbortCode.NOT_TRANSFERABLE).encode()]
        return super().serve(channel, frame)


@fault("load-defaults-silent", Defect.STATE, "od.load-defaults")
class LoadSilent(ParametersStored):
    """Loads its defaults and does not confirm it."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        responses = super().serve(channel, frame)
        return [] if frame.data[1:] == b"\x11\x10\x01" + LOAD else responses


@fault("load-defaults-ignored", Defect.STATE, "od.default-of-parameter[2004h:00]")
class LoadIgnored(ParametersStored):
    """Confirms "load" and keeps what is stored."""

    def load_defaults(self) -> None:
        """Do nothing."""


@fault("load-defaults-forgets-an-object", Defect.STATE, "od.default-of-parameter[2100h:01]")
class LoadForgets(ParametersStored):
    """Loads the defaults of all objects but one."""

    def load_defaults(self) -> None:
        kept = self.objects.find(FORGOTTEN)
        stored = [place for place in self.power_on if place[0] is kept]
        super().load_defaults()
        others = [place for place in self.power_on if place[0] is not kept]
        self.power_on = others + stored


@fault("load-defaults-until-reset", Defect.STATE, "od.default-of-parameter")
class LoadedUntilReset(ParametersStored):
    """Loads its defaults at once, and after the reset it has again what was stored."""

    def load_defaults(self) -> None:
        stored = self.power_on
        super().load_defaults()
        self.restore(communication_only=False)
        self.power_on = stored


@fault("load-defaults-of-communication-only", Defect.STATE, "od.default-of-parameter[2010h:00]")
class LoadsCommunicationOnly(ParametersStored):
    """Loads the defaults of its communication objects, though it was asked for all."""

    def load_defaults(self) -> None:
        stored = [place for place in self.power_on if not place[1]]
        super().load_defaults()
        self.power_on = [place for place in self.power_on if place[1]] + stored


@fault("load-defaults-others", Defect.STATE, "od.default-of-parameter[1017h:00]")
class LoadsOthers(ParametersStored):
    """Loads other values than its defaults."""

    def load_defaults(self) -> None:
        super().load_defaults()
        self.power_on = [
            (entry, in_area, self.changed(value) if entry.access.writable else value)
            for entry, in_area, value in self.power_on
        ]

    def changed(self, value: bytes) -> bytes:
        """Return another value of the same length."""
        return value[:-1] + bytes(byte ^ 1 for byte in value[-1:])


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
            right = DownloadInitiate.with_data(self.command, signature_of(self.command))
            frame = frame._replace(data=right.encode())
        return super().serve(channel, frame)

    def taken(self, data: bytes) -> bool:
        """Take everything."""
        return True


@fault("store-any-signature", Defect.STATE, "od.save-signature")
class StoreAnySignature(AnySignature):
    """Stores its parameters whatever is written to 1010h:01."""


@fault("store-signature-reversed", Defect.STATE, "od.save-signature")
class StoreSignatureReversed(AnySignature):
    """Takes "save" with its bytes in either order."""

    def taken(self, data: bytes) -> bool:
        return data == SAVE[::-1]


@fault("store-signature-of-the-other", Defect.STATE, "od.save-signature")
class StoreSignatureOfTheOther(AnySignature):
    """Stores its parameters when "load" is written to 1010h:01."""

    def taken(self, data: bytes) -> bool:
        return data == LOAD


@fault("load-any-signature", Defect.STATE, "od.load-signature")
class LoadAnySignature(AnySignature):
    """Loads its defaults whatever is written to 1011h:01."""

    command = LOAD_ALL


@fault("load-signature-in-capitals", Defect.STATE, "od.load-signature")
class LoadSignatureInCapitals(AnySignature):
    """Loads its defaults for "LOAD" as well."""

    command = LOAD_ALL

    def taken(self, data: bytes) -> bool:
        return data == LOAD.upper()


@fault("store-any-signature-of-part", Defect.STATE, "od.save-signature-of-part")
class StoreAnySignatureOfPart(AnySignature):
    """Stores the parameters of the application whatever is written to 1010h:03."""

    command = Multiplexer(SAVE_ALL.index, APPLICATION_PART)


@fault("load-any-signature-of-part", Defect.STATE, "od.load-signature-of-part")
class LoadAnySignatureOfPart(AnySignature):
    """Loads the defaults of the communication whatever is written to 1011h:02."""

    command = Multiplexer(LOAD_ALL.index, COMMUNICATION_PART)


@fault("store-signature-wrong-code", Defect.ABORT, "od.save-signature")
class SignatureWrongCode(Node):
    """Refuses what is no signature as if 1010h:01 were read-only."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        responses = super().serve(channel, frame)
        wrong = Abort(SAVE_ALL, AbortCode.NOT_TRANSFERABLE).encode()
        other = Abort(SAVE_ALL, AbortCode.WRITE_OF_READ_ONLY).encode()
        return [other if response == wrong else response for response in responses]


class _RefusedAndFollowed(ParametersStored):
    """Refuses a wrong signature, and does what the right one asks for."""

    command = SAVE_ALL

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        responses = super().serve(channel, frame)
        request = decode_request(frame.data)
        about = isinstance(request, DownloadInitiate) and request.mux == self.command
        if about and responses and is_abort(responses[0]):
            self.obey()
        return responses

    def obey(self) -> None:
        """Store the parameters."""
        self.save()


@fault("store-any-signature-refused-and-followed", Defect.STATE, "od.save-signature")
class StoreRefusedAndFollowed(_RefusedAndFollowed):
    """Refuses what is no "save", and stores its parameters all the same."""


@fault("load-any-signature-refused-and-followed", Defect.STATE, "od.load-signature")
class LoadRefusedAndFollowed(_RefusedAndFollowed):
    """Refuses what is no "load", and loads its defaults all the same."""

    command = LOAD_ALL

    def obey(self) -> None:
        """Load the defaults."""
        self.load_defaults()
