"""Servers in which something of one transfer shows in the next, or that run out of something."""

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    DownloadSegment,
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.segmented_server import Download, Upload
from conformance.sdo.server import Server

LEAK = DefectClass.LEAK


@fault("second-read-of-short-text-zero", LEAK, "sequence.uploads")
class SecondReadZero(Server):
    """Reads a string of up to 4 bytes as zeros when it is read twice in a row."""

    last: Multiplexer | None = None

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Clear what was read before."""
        again, self.last = mux == self.last, mux
        if again and len(data) < 4 and mux.index in (0x1009, 0x2010):
            data = bytes(len(data))
        return super().start_upload(mux, data)


@fault("second-segmented-upload-empty", LEAK, "segmented-upload.again")
class SecondUploadWrong(Server):
    """Delivers zeros in the second of two segmented uploads of one object."""

    last: Multiplexer | None = None

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Use up the buffer."""
        again = mux == self.last and len(data) > 7
        self.last = mux
        return super().start_upload(mux, bytes(len(data)) if again else data)

    def react(self, request: Request) -> list[Response]:
        """Forget the last object when anything but an upload comes."""
        if not isinstance(request, UploadInitiate | UploadSegment):
            self.last = None
        return super().react(request)


@fault("constant-text-consumed", LEAK, "segmented-upload.read-only-text")
class ConstantConsumed(Server):
    """Leaves out the last byte of a long constant text at every second reading."""

    odd = False

    def value_to_read(self, entry: Entry) -> bytes:
        """Cut every other time."""
        if entry.access.writable or len(entry.value) <= 7:
            return entry.value
        self.odd = not self.odd
        return entry.value if self.odd else entry.value[:-1]


@fault("abandoned-upload-goes-on", LEAK, "sequence.abandoned-upload")
class AbandonedUploadGoesOn(Server):
    """Starts the upload after an aborted one where that one was."""

    offset = 0

    def on_abort(self, request: Abort) -> list[Response]:
        """Keep the offset."""
        self.offset = self.transfer.offset if isinstance(self.transfer, Upload) else 0
        return super().on_abort(request)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Start there."""
        response = super().start_upload(mux, data)
        if isinstance(self.transfer, Upload):
            self.transfer.offset = min(self.offset, len(data) - 1)
            self.offset = 0
        return response


@fault("abandoned-upload-deaf", LEAK, "segmented-upload.client-abort-then-upload")
class AbandonedUploadDeaf(Server):
    """Loses the first request behind the abort of an upload."""

    deaf = False

    def receive(self, frame: bytes) -> list[bytes]:
        """Drop one request, unless it reads the device type."""
        if frame[:1] == b"\x80" and isinstance(self.transfer, Upload):
            self.deaf = True
        elif self.deaf:
            self.deaf = False
            if frame[1:3] != b"\x00\x10":
                return []
        return super().receive(frame)


@fault("abandoned-download-kept", LEAK, "sequence.abandoned-download")
class AbandonedDownloadKept(Server):
    """Puts the segments of an aborted download in front of the next one of the same kind."""

    kept = b""

    def on_abort(self, request: Abort) -> list[Response]:
        """Keep the buffer."""
        if isinstance(self.transfer, Download):
            self.kept = bytes(self.transfer.data)
        return super().on_abort(request)

    def finish_download(self, transfer: Download) -> None:
        """Lay the old bytes over the new ones."""
        data = self.kept[:4] + bytes(transfer.data[4:]) if self.kept else bytes(transfer.data)
        self.kept = b""
        transfer.data[:] = data[: len(transfer.data)]
        super().finish_download(transfer)


@fault("size-kept-for-unsized-download", LEAK, "sequence.sized-aborted-then-unsized")
class SizeKept(Server):
    """Holds the size of an aborted download against one that indicates none."""

    size: int | None = None

    def on_abort(self, request: Abort) -> list[Response]:
        """Keep the size."""
        if isinstance(self.transfer, Download):
            self.size = self.transfer.size
        return super().on_abort(request)

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        """Use the old size where there is no new one."""
        size = self.size if request.size is None else request.size
        self.size = None
        return Download(request.mux, entry, size)


@fault("size-kept-after-transfer", LEAK, "sequence.downloads[sized-20-then-unsized-21]")
class SizeKeptAfterTransfer(Server):
    """Cuts a download without size to the size of the one before it."""

    size: int | None = None

    def finish_download(self, transfer: Download) -> None:
        """Use and keep sizes."""
        if transfer.size is None and self.size is not None:
            del transfer.data[max(self.size, transfer.entry.shortest) :]
        self.size = transfer.size
        super().finish_download(transfer)


@fault("shorter-value-keeps-tail", LEAK, "sequence.downloads[sized-20-then-expedited-4]")
class ShorterKeepsTail(Server):
    """Leaves the end of a longer string behind a shorter one."""

    def store(self, entry: Entry, data: bytes) -> None:
        """Overwrite the beginning."""
        tail = entry.value[len(data) :] if entry.data_type.length is None else b""
        super().store(entry, data)
        entry.value = data + tail


@fault("unread-download-lost", LEAK, "sequence.downloads-unread")
class UnreadLost(Server):
    """Ignores the second of two downloads to one string without an upload between them."""

    last: Entry | None = None

    def store(self, entry: Entry, data: bytes) -> None:
        """Store once."""
        if entry is self.last and entry.data_type.length is None:
            return
        self.last = entry
        super().store(entry, data)

    def value_to_read(self, entry: Entry) -> bytes:
        """Be ready again."""
        self.last = None
        return super().value_to_read(entry)


@fault("second-write-to-number-lost", LEAK, "download.twice")
class SecondWriteLost(Server):
    """Ignores a write to a number that gives it back the value before the last write."""

    before: bytes | None = None

    def store(self, entry: Entry, data: bytes) -> None:
        """Compare with an old cache."""
        if data == self.before and entry.data_type.length:
            entry.check_length(len(data))
            return
        self.before = entry.value
        super().store(entry, data)


@fault("same-value-refused", DefectClass.ACCESS_OR_SIZE, "download.same-value")
class SameValueRefused(Server):
    """Refuses to write the value that an object has."""

    def store(self, entry: Entry, data: bytes) -> None:
        """Insist on a change."""
        if data == entry.value:
            raise Refusal(AbortCode.VALUE_INVALID)
        super().store(entry, data)


@fault("upload-buffer-shared-with-download", LEAK, "sequence.upload-then-download")
class SharedBuffer(Server):
    """Stores the bytes of the last upload instead of the first bytes of a download to it."""

    read = b""
    entry: Entry | None = None

    def value_to_read(self, entry: Entry) -> bytes:
        """Fill the shared buffer."""
        self.entry, self.read = entry, entry.value[:2]
        return super().value_to_read(entry)

    def store(self, entry: Entry, data: bytes) -> None:
        """Store from the shared buffer."""
        if entry is self.entry and entry.data_type.length is None and len(data) > 2:
            data = self.read + data[len(self.read) :]
        self.entry = None
        super().store(entry, data)


@fault("refusal-leaves-size", LEAK, "segmented-download.refused-is-over")
class RefusalLeavesSize(Server):
    """Puts bytes of a refused download at the end of the next one."""

    left = b""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Keep the buffer."""
        if isinstance(self.transfer, Download) and code is AbortCode.LENGTH_TOO_LOW:
            self.left = bytes(self.transfer.data[-2:])
        return super().refuse(request, code)

    def store(self, entry: Entry, data: bytes) -> None:
        """Use it up."""
        if self.left and entry.data_type.length is None:
            data, self.left = data[:-2] + self.left, b""
        super().store(entry, data)


@fault("refusal-blocks-next-write", LEAK, "download.refused-is-over")
class RefusalBlocksNext(Server):
    """Ignores the write after one that was refused for its length."""

    blocked = False

    def store(self, entry: Entry, data: bytes) -> None:
        """Skip one write."""
        try:
            entry.check_length(len(data))
        except Refusal:
            self.blocked = True
            raise
        if self.blocked and data != entry.value:
            self.blocked = False
            return
        super().store(entry, data)


@fault("refusal-spoils-next-read", LEAK, "upload.refused-is-over")
class RefusalSpoilsNext(Server):
    """Reads 1018h:01 as the code of a refusal right before it."""

    spoiled: AbortCode | None = None

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Leave the code in the buffer."""
        self.spoiled = code
        return super().refuse(request, code)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Send the buffer."""
        spoiled, self.spoiled = self.spoiled, None
        if spoiled is not None and mux == Multiplexer(0x1018, 1):
            data = int(spoiled).to_bytes(4, "little")
        return super().start_upload(mux, data)


@fault("refusal-spoils-next-segments", LEAK, "sequence.refused-then-served")
class RefusalSpoilsSegments(Server):
    """Starts an upload in segments one byte late after a refusal."""

    spoiled = False

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Leave an offset behind."""
        self.spoiled = True
        return super().refuse(request, code)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Use it up."""
        response = super().start_upload(mux, data)
        if self.spoiled and isinstance(self.transfer, Upload):
            self.transfer.offset = 1
        self.spoiled = False
        return response


@fault("refusals-run-out", DefectClass.ROBUSTNESS, "abort.many")
class RefusalsRunOut(Server):
    """Answers refused uploads for good with another code after 30 in a row."""

    count = 0

    def react(self, request: Request) -> list[Response]:
        """Start again with a request that is served."""
        responses = super().react(request)
        self.count = 0
        return responses

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Count."""
        self.count += 1
        if self.count > 30:
            code = AbortCode.OUT_OF_MEMORY
        return super().refuse(request, code)


@fault("transfers-run-out", DefectClass.ROBUSTNESS, "abort.many-transfers")
class TransfersRunOut(Server):
    """Loses memory with each transfer that the client aborts, until none is left."""

    lost = 0

    def on_abort(self, request: Abort) -> list[Response]:
        """Forget to give back."""
        self.lost += isinstance(self.transfer, Upload)
        return super().on_abort(request)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Refuse when nothing is left; a whole transfer clears the heap."""
        if self.lost > 30 and len(data) > 4:
            self.lost = 0
            raise Refusal(AbortCode.OUT_OF_MEMORY)
        return super().start_upload(mux, data)


@fault("abandoned-unsized-download-kept", LEAK, "sequence.abandoned-download[unsized]")
class UnsizedKeepsSegments(Server):
    """Appends a download without size to an aborted one without size."""

    kept = b""

    def on_abort(self, request: Abort) -> list[Response]:
        """Keep the buffer."""
        if isinstance(self.transfer, Download) and self.transfer.size is None:
            self.kept = bytes(self.transfer.data)
        return super().on_abort(request)

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Put the old bytes first."""
        transfer = self.transfer
        if isinstance(transfer, Download) and transfer.size is None and not transfer.data:
            transfer.data += self.kept
            self.kept = b""
        return super().on_download_segment(request)
