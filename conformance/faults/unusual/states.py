"""Nodes that serve by their state: some things in one NMT state only, or behind a password."""

from functools import partial

from conformance.faults import registry
from conformance.faults.addressed_objects import DOWNLOADS, initiated
from conformance.faults.registry import About
from conformance.reference.node import Node, ServerChannel
from conformance.reference.server import BlockDownload
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort, BlockUploadInitiate, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand, NmtState

unusual = partial(registry.unusual, about=About.NMT)
UPLOADS = (UploadInitiate, BlockUploadInitiate)
FIRST_OF_DEVICE = 0x2000
MEASURED = range(0x2130, 0x2140)
PASSWORD, PASSWORD_ENTRY = b"\x39\x30\x00\x00", Multiplexer(0x2020)


class RefusesByState(Node):
    """Refuses some initiates before it looks at anything else of them."""

    code = AbortCode.DEVICE_STATE

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Within a sub-block all is segments."""
        transfer = channel.server.transfer
        within = isinstance(transfer, BlockDownload) and not transfer.ended
        mux = None if within else initiated(frame)
        if mux is None or not self.refuses(frame, mux):
            return super().serve(channel, frame)
        channel.server.transfer = None
        return [Abort(mux, self.code).encode()]

    def refuses(self, frame: CanFrame, mux: Multiplexer) -> bool:
        """Say whether the state is in the way of an initiate."""
        raise NotImplementedError


@unusual("writes-refused-in-operational")
class WritesRefusedInOperational(RefusesByState):
    """Refuses all downloads while it is Operational, whatever they are."""

    def refuses(self, frame: CanFrame, mux: Multiplexer) -> bool:
        return self.state is NmtState.OPERATIONAL and initiated(frame, DOWNLOADS) is not None


@unusual("writes-refused-in-operational-which-it-enters")
class WritesRefusedAtOnce(WritesRefusedInOperational):
    """Enters Operational by itself behind its boot-up message, and refuses all downloads there."""

    def start(self) -> list[CanFrame]:
        frames = super().start()
        return frames + self.follow(NmtCommand.START)


@unusual("writes-refused-in-pre-operational")
class WritesRefusedInPreOperational(RefusesByState):
    """Refuses downloads from 2000h on as long as it is Pre-operational."""

    def refuses(self, frame: CanFrame, mux: Multiplexer) -> bool:
        written = initiated(frame, DOWNLOADS) is not None and mux.index >= FIRST_OF_DEVICE
        return self.state is NmtState.PRE_OPERATIONAL and written


@unusual("measured-values-read-in-operational")
class MeasuredInOperational(RefusesByState):
    """Refuses uploads of what it measures as long as it is Pre-operational."""

    def refuses(self, frame: CanFrame, mux: Multiplexer) -> bool:
        read = initiated(frame, UPLOADS) is not None and mux.index in MEASURED
        return self.state is NmtState.PRE_OPERATIONAL and read


@unusual("reads-refused-in-pre-operational")
class ReadsRefusedInPreOperational(RefusesByState):
    """Refuses uploads from 2000h on as long as it is Pre-operational."""

    def refuses(self, frame: CanFrame, mux: Multiplexer) -> bool:
        read = initiated(frame, UPLOADS) is not None and mux.index >= FIRST_OF_DEVICE
        return self.state is NmtState.PRE_OPERATIONAL and read


@unusual("locked-until-a-password")
class LockedUntilPassword(RefusesByState):
    """Refuses all from 2000h on until a password was written to 2020h."""

    code = AbortCode.LOCAL_CONTROL

    def refuses(self, frame: CanFrame, mux: Multiplexer) -> bool:
        """The password is never asked for by a reset: it is open until the power goes."""
        if mux.index < FIRST_OF_DEVICE or mux == PASSWORD_ENTRY:
            return False
        return self.objects.find(PASSWORD_ENTRY).value != PASSWORD
