"""Nodes that check what they are asked for in one NMT state only."""

from conformance.faults.registry import About, Defect, fault
from conformance.reference.node import Node, ServerChannel
from conformance.reference.segmented_server import SegmentedServer
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    DownloadInitiate,
    DownloadInitiateResponse,
    Response,
    UploadInitiate,
)
from conformance.sdo.nmt import NmtState
from conformance.sdo.objects import Entry, Refusal


class _InOneState(Node):
    """Has other code in use in one of the states that serve: ``careless`` servers."""

    careless: type[Server] = Server
    where = NmtState.OPERATIONAL

    def __init__(
        self,
        node_id: int,
        server: SegmentedServer,
        *further: SegmentedServer,
        server_timeout: float | None = None,
    ) -> None:
        super().__init__(node_id, server, *further, server_timeout=server_timeout)
        self._careful = [channel.server for channel in self.channels]
        self._careless = [self.careless(self.objects) for _ in self.channels]

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Let the server of the state react; a transfer ends where the state changes."""
        servers = self._careless if self.state is self.where else self._careful
        channel.server = servers[self.channels.index(channel)]
        return super().serve(channel, frame)


class _AnyAccess(Server):
    """Writes what is read-only, and reads what is write-only."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        self.transfer = None
        return [self.start_upload(request.mux, self.objects.find(request.mux).value)]

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        return self.objects.find(request.mux)

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        return self.objects.find(request.mux)


class _AnyLength(Server):
    """Cuts numbers that are too long, and fills up those that are too short."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Take any."""

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data.ljust(entry.shortest, b"\0")[: entry.longest])


class _AnyObject(Server):
    """Reads what it lacks as 0, and confirms what is written to that."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        if self.objects.get(request.mux) is None:
            self.transfer = None
            return [DownloadInitiateResponse(request.mux)]
        return super().on_download_initiate(request)

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        if self.objects.get(request.mux) is None:
            self.transfer = None
            return [self.start_upload(request.mux, bytes(4))]
        return super().on_upload_initiate(request)


class _AnyValue(Server):
    """Takes numbers beyond their limits."""

    def store(self, entry: Entry, data: bytes) -> None:
        entry.check_length(len(data))
        entry.value = data


class _WholeWords(Server):
    """Reads numbers of fewer than 4 bytes with 4."""

    def value_to_read(self, entry: Entry) -> bytes:
        return entry.value.ljust(4, b"\0")


class _NothingWritten(Server):
    """Refuses what is written to numbers as invalid."""

    def store(self, entry: Entry, data: bytes) -> None:
        if entry.data_type.length is not None:
            raise Refusal(AbortCode.VALUE_INVALID)
        super().store(entry, data)


@fault(
    "access-not-checked-in-operational",
    Defect.ACCESS_OR_SIZE,
    "other-state.read-only",
    "other-state.write-only",
    about=About.NMT,
)
class AccessInOperational(_InOneState):
    """Writes what is read-only, and reads what is write-only, in Operational."""

    careless = _AnyAccess


@fault(
    "access-not-checked-in-pre-operational",
    Defect.ACCESS_OR_SIZE,
    "download.read-only",
    about=About.NMT,
)
class AccessInPreOperational(AccessInOperational):
    """Writes what is read-only, and reads what is write-only, in Pre-operational."""

    where = NmtState.PRE_OPERATIONAL


@fault(
    "lengths-not-checked-in-operational",
    Defect.FIELD_WIDTH,
    "other-state.too-long",
    "other-state.too-short",
    about=About.NMT,
)
class LengthsInOperational(_InOneState):
    """Cuts numbers that are too long, and fills up those that are too short, in Operational."""

    careless = _AnyLength


@fault(
    "lengths-not-checked-in-pre-operational",
    Defect.FIELD_WIDTH,
    "download.too-long",
    about=About.NMT,
)
class LengthsInPreOperational(LengthsInOperational):
    """Cuts numbers that are too long, and fills up those that are too short, in Pre-operational."""

    where = NmtState.PRE_OPERATIONAL


@fault(
    "missing-objects-served-in-operational",
    Defect.ACCESS_OR_SIZE,
    "other-state.object-missing",
    "other-state.sub-index-missing",
    about=About.NMT,
)
class MissingInOperational(_InOneState):
    """Reads what it lacks as 0, and confirms what is written to that, in Operational."""

    careless = _AnyObject


@fault(
    "missing-objects-served-in-pre-operational",
    Defect.ACCESS_OR_SIZE,
    "upload.object-missing",
    about=About.NMT,
)
class MissingInPreOperational(MissingInOperational):
    """Reads what it lacks as 0, and confirms what is written to that, in Pre-operational."""

    where = NmtState.PRE_OPERATIONAL


@fault(
    "limits-not-checked-in-operational",
    Defect.ACCESS_OR_SIZE,
    "other-state.limits",
    about=About.NMT,
)
class LimitsInOperational(_InOneState):
    """Takes numbers beyond their limits in Operational."""

    careless = _AnyValue


@fault(
    "numbers-of-4-bytes-in-operational",
    Defect.FIELD_WIDTH,
    "other-state.read",
    about=About.NMT,
)
class WholeWordsInOperational(_InOneState):
    """Reads numbers of fewer than 4 bytes with 4 in Operational."""

    careless = _WholeWords


@fault(
    "numbers-not-written-in-operational",
    Defect.ACCESS_OR_SIZE,
    "other-state.write-back",
    about=About.NMT,
)
class NothingInOperational(_InOneState):
    """Refuses what is written to numbers in Operational as an invalid value."""

    careless = _NothingWritten
