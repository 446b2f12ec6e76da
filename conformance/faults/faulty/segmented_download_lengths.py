"""Servers that take segmented downloads of a wrong length, or refuse them badly."""

from conformance.faults.registry import Defect, fault
from conformance.reference.segmented_server import Download
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    DownloadInitiate,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
)
from conformance.sdo.objects import Entry


@fault("download-too-many-accepted", Defect.ACCESS_OR_SIZE, "segmented-download.too-many")
class TooManyAccepted(Server):
    """Drops the bytes beyond the announced size in silence."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        return request.data[: transfer.room]


@fault(
    "number-too-long-accepted-segmented",
    Defect.ACCESS_OR_SIZE,
    "segmented-download.number-too-long",
)
class NumberTooLongSegmented(Server):
    """Cuts a number that comes in segments and is too long."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Do not check."""

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        size = request.size if entry.data_type.length is None else None
        return Download(request.mux, entry, size)

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        if transfer.entry.data_type.length is not None:
            return request.data[: transfer.room]
        return super().segment_data(transfer, request)


@fault(
    "number-too-long-not-indicated-accepted",
    Defect.ACCESS_OR_SIZE,
    "segmented-download.number-too-long-not-indicated",
)
class NumberTooLongUnsized(Server):
    """Cuts a number that comes in segments without its size and is too long."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        if transfer.size is None and transfer.entry.data_type.length is not None:
            return request.data[: transfer.room]
        return super().segment_data(transfer, request)


@fault(
    "number-too-short-accepted-segmented",
    Defect.ACCESS_OR_SIZE,
    "segmented-download.number-too-short",
    "segmented-download.number-too-short-not-indicated",
)
class NumberTooShortSegmented(Server):
    """Pads a number that comes in segments and is too short, an empty one included."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if size is not None and size > entry.longest:
            super().check_announced_size(entry, size)

    def finish_download(self, transfer: Download) -> None:
        transfer.size = None
        self.store(transfer.entry, bytes(transfer.data).ljust(transfer.entry.shortest, b"\0"))


@fault("download-too-few-accepted", Defect.ACCESS_OR_SIZE, "segmented-download.too-few")
class TooFewAccepted(Server):
    """Stores a download that ends before the announced size."""

    def finish_download(self, transfer: Download) -> None:
        transfer.size = None
        super().finish_download(transfer)


@fault(
    "download-too-few-refused-and-stored",
    Defect.ACCESS_OR_SIZE,
    "segmented-download.too-few",
    soft=True,
)
class TooFewStored(Server):
    """Stores what came of a download before it refuses it as too short."""

    def finish_download(self, transfer: Download) -> None:
        self.store(transfer.entry, bytes(transfer.data))
        super().finish_download(transfer)


@fault("huge-size-crashes", Defect.ROBUSTNESS, "segmented-download.huge-size")
class HugeSizeCrashes(Server):
    """Never answers again once a download has announced more than it has memory for."""

    crashed = False

    def receive(self, frame: bytes) -> list[bytes]:
        self.crashed |= frame[:1] == b"\x21" and frame[7:8] >= b"\x80"
        return [] if self.crashed else super().receive(frame)


@fault("number-empty-accepted", Defect.ZERO_LENGTH, "segmented-download.number-empty")
class NumberEmptyAccepted(Server):
    """Confirms a download of 0 bytes to a number, and does nothing."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if size != 0:
            super().check_announced_size(entry, size)

    def store(self, entry: Entry, data: bytes) -> None:
        if data or not entry.shortest:
            super().store(entry, data)


@fault("download-confirmed-then-refused", Defect.ABORT, "segmented-download.too-")
class ConfirmedThenRefused(Server):
    """Confirms the last segment of a download before it finds that it has to refuse it."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        confirmed = isinstance(self.transfer, Download) and isinstance(request, DownloadSegment)
        responses = super().refuse(request, code)
        late = code is not AbortCode.TOGGLE_NOT_ALTERNATED
        if confirmed and late and isinstance(request, DownloadSegment) and request.last:
            return [DownloadSegmentResponse(request.toggle), *responses]
        return responses
