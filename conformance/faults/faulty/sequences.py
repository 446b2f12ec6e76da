"""Servers in which something of one transfer shows in the next, or that run out of something."""

from conformance.faults.registry import Defect, fault
from conformance.reference.segmented_server import Download, Upload
from conformance.reference.server import BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadSegment,
    Request,
    Response,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry, Refusal


@fault("second-read-of-short-text-zero", Defect.LEAK, "sequence.uploads")
class SecondReadZero(Server):
    """Reads a string of up to 4 bytes as zeros when it is read twice in a row."""

    last: Multiplexer | None = None

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        again, self.last = mux == self.last, mux
        if again and len(data) < 4 and mux.index in (0x1009, 0x2010):
            data = bytes(len(data))
        return super().start_upload(mux, data)


@fault("abandoned-upload-goes-on", Defect.LEAK, "sequence.abandoned-upload")
class AbandonedUploadGoesOn(Server):
    """Starts the upload after an aborted one where that one was."""

    offset = 0

    def on_abort(self, request: Abort) -> list[Response]:
        self.offset = self.transfer.offset if isinstance(self.transfer, Upload) else 0
        return super().on_abort(request)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        if isinstance(self.transfer, Upload):
            self.transfer.offset = min(self.offset, len(data) - 1)
            self.offset = 0
        return response


@fault("abandoned-download-kept", Defect.LEAK, "sequence.abandoned-download")
class AbandonedDownloadKept(Server):
    """Puts the segments of an aborted download in front of the next one of the same kind."""

    kept = b""

    def on_abort(self, request: Abort) -> list[Response]:
        if isinstance(self.transfer, Download):
            self.kept = bytes(self.transfer.data)
        return super().on_abort(request)

    def finish_download(self, transfer: Download) -> None:
        data = self.kept[:4] + bytes(transfer.data[4:]) if self.kept else bytes(transfer.data)
        self.kept = b""
        transfer.data[:] = data[: len(transfer.data)]
        super().finish_download(transfer)


@fault("size-kept-for-unsized-download", Defect.LEAK, "sequence.sized-aborted-then-unsized")
class SizeKept(Server):
    """Holds the size of an aborted download against one that indicates none."""

    size: int | None = None

    def on_abort(self, request: Abort) -> list[Response]:
        if isinstance(self.transfer, Download):
            self.size = self.transfer.size
        return super().on_abort(request)

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        size = self.size if request.size is None else request.size
        self.size = None
        return Download(request.mux, entry, size)


@fault("size-kept-after-transfer", Defect.LEAK, "sequence.downloads[sized-20-then-unsized-21]")
class SizeKeptAfterTransfer(Server):
    """Cuts a download without size to the size of the one before it."""

    size: int | None = None

    def finish_download(self, transfer: Download) -> None:
        if transfer.size is None and self.size is not None:
            del transfer.data[max(self.size, transfer.entry.shortest) :]
        self.size = transfer.size
        super().finish_download(transfer)


@fault("shorter-value-keeps-tail", Defect.LEAK, "download.text")
class ShorterKeepsTail(Server):
    """Leaves the end of a longer string behind a shorter one."""

    def store(self, entry: Entry, data: bytes) -> None:
        tail = entry.value[len(data) :] if entry.data_type.length is None else b""
        super().store(entry, data)
        entry.value = data + tail


@fault("shorter-value-over-longer-one-in-buffer", Defect.LEAK, "download.text")
class WrittenOver(Server):
    """Writes strings and domains over what is in their buffers, and reads the whole buffers."""

    BUFFER = 300

    def store(self, entry: Entry, data: bytes) -> None:
        before = entry.value
        super().store(entry, data)
        if entry.data_type.length is None:
            entry.value = (data + before[len(data) :]).ljust(self.BUFFER, b"\0")


@fault("stray-segment-stored-behind-abort", Defect.LEAK, "matrix.block-upload-end")
class StraySegmentStored(Server):
    """Keeps a download segment that comes in a block upload; the next abort appends it."""

    stray = b""
    stored_by: type[Request] = Abort

    def react(self, request: Request) -> list[Response]:
        if isinstance(request, DownloadSegment) and isinstance(self.transfer, BlockUpload):
            self.stray, self.entry = request.payload, self.objects.find(self.transfer.mux)
        elif isinstance(request, self.stored_by) and self.stray:
            self.entry.value += self.stray
            self.stray = b""
        return super().react(request)


@fault("stray-segment-stored-by-next-block-upload", Defect.LEAK, "matrix.block-upload")
class StraySegmentStoredLater(StraySegmentStored):
    """Keeps a download segment that comes in a block upload; the next block upload appends it."""

    stored_by = BlockUploadInitiate


@fault("unread-download-lost", Defect.LEAK, "sequence.downloads-unread")
class UnreadLost(Server):
    """Ignores the second of two downloads to one string without an upload between them."""

    last: Entry | None = None

    def store(self, entry: Entry, data: bytes) -> None:
        if entry is self.last and entry.data_type.length is None:
            return
        self.last = entry
        super().store(entry, data)

    def value_to_read(self, entry: Entry) -> bytes:
        self.last = None
        return super().value_to_read(entry)


@fault("upload-buffer-shared-with-download", Defect.LEAK, "sequence.upload-then-download")
class SharedBuffer(Server):
    """Stores the bytes of the last upload instead of the first bytes of a download to it."""

    read = b""
    entry: Entry | None = None

    def value_to_read(self, entry: Entry) -> bytes:
        self.entry, self.read = entry, entry.value[:2]
        return super().value_to_read(entry)

    def store(self, entry: Entry, data: bytes) -> None:
        if entry is self.entry and entry.data_type.length is None and len(data) > 2:
            data = self.read + data[len(self.read) :]
        self.entry = None
        super().store(entry, data)


@fault("refusal-spoils-next-segments", Defect.LEAK, "sequence.refused-then-served")
class RefusalSpoilsSegments(Server):
    """Starts an upload in segments one byte late after a refusal."""

    spoiled = False

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        self.spoiled = True
        return super().refuse(request, code)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        if self.spoiled and isinstance(self.transfer, Upload):
            self.transfer.offset = 1
        self.spoiled = False
        return response


@fault("abandoned-unsized-download-kept", Defect.LEAK, "sequence.abandoned-download[unsized]")
class UnsizedKeepsSegments(Server):
    """Appends a download without size to an aborted one without size."""

    kept = b""

    def on_abort(self, request: Abort) -> list[Response]:
        if isinstance(self.transfer, Download) and self.transfer.size is None:
            self.kept = bytes(self.transfer.data)
        return super().on_abort(request)

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, Download) and transfer.size is None and not transfer.data:
            transfer.data += self.kept
            self.kept = b""
        return super().on_download_segment(request)


@fault("aborted-domain-locked", Defect.LEAK, "sequence.aborted-domain")
class AbortedDomainLocked(Server):
    """Refuses to read a domain of which a download was aborted until it is written again."""

    def on_abort(self, request: Abort) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, Download) and transfer.entry.data_type is DataType.DOMAIN:
            transfer.entry.value = b""
        return super().on_abort(request)

    def value_to_read(self, entry: Entry) -> bytes:
        if entry.data_type is DataType.DOMAIN and not entry.value:
            raise Refusal(AbortCode.LOCAL_CONTROL)
        return super().value_to_read(entry)
