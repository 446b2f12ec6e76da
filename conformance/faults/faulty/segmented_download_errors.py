"""Servers that are wrong in segmented downloads about toggle bits, aborts and foreign requests."""

from dataclasses import replace

from conformance.faults.registry import Defect, fault
from conformance.reference.segmented_server import Download, Transfer, Upload
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
    Unknown,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.limits import EXPEDITED_LENGTH
from conformance.sdo.objects import Entry

BLOCK_FRAMES = BlockAck | BlockEnd | BlockEndResponse | BlockUploadStart
_OF_DOWNLOADS = (DownloadInitiate, DownloadSegment, BlockDownloadInitiate, BlockEnd)
_OF_UPLOADS = (
    UploadInitiate,
    UploadSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    BlockAck,
    BlockEndResponse,
)


@fault(
    "download-toggle-ignored",
    Defect.STATE,
    "segmented-download.toggle",
    "segmented-download.number-toggle",
)
class DownloadToggleIgnored(Server):
    """Takes segments whatever their toggle bit."""

    def check_toggle(self, transfer: Download | Upload, toggle: int) -> None:
        """Check it in uploads only; follow the client in downloads."""
        if isinstance(transfer, Upload):
            super().check_toggle(transfer, toggle)
        else:
            transfer.toggle = toggle


@fault("download-toggle-refused-as-unknown", Defect.STATE, "segmented-download.toggle")
class ToggleRefusedAsUnknown(Server):
    """Refuses a segment whose toggle bit did not alternate as what it does not know."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, Download) and request.toggle != transfer.toggle:
            return self.wrong(request)
        return super().on_download_segment(request)

    def wrong(self, request: DownloadSegment) -> list[Response]:
        """Refuse it."""
        return self.refuse(request, AbortCode.COMMAND_NOT_VALID)


@fault("download-toggle-ends-without-a-word", Defect.STATE, "segmented-download.toggle")
class ToggleEndsSilently(ToggleRefusedAsUnknown):
    """Ends a download at a segment whose toggle bit did not alternate, and does not say so."""

    def wrong(self, request: DownloadSegment) -> list[Response]:
        """Keep silent."""
        self.transfer = None
        return []


@fault("download-repeated-segment-stored", Defect.STATE, "segmented-download.toggle-ignored-data")
class RepeatedSegmentStored(Server):
    """Stores a repeated segment without a confirmation."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Keep silent about the wrong toggle bit, but take the bytes."""
        transfer = self.transfer
        if isinstance(transfer, Download) and request.toggle != transfer.toggle:
            transfer.data[:] = transfer.data[:-7] + request.data[::-1]
            return []
        return super().on_download_segment(request)


@fault(
    "download-toggle-not-reset",
    Defect.LEAK,
    "segmented-download.toggle-afterwards[segmented-download-middle]",
)
class DownloadToggleNotReset(Server):
    """Expects the toggle bit of an aborted download to go on in the next one."""

    due = 0

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        transfer = super().start_download(request, entry)
        transfer.toggle = self.due
        return transfer

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Remember what is due; a whole transfer resets it."""
        responses = super().on_download_segment(request)
        self.due = self.transfer.toggle if isinstance(self.transfer, Download) else 0
        return responses


@fault("unknown-specifier-halts", Defect.ROBUSTNESS, "segmented-download.foreign")
class UnknownHalts(Server):
    """Stops working after an unknown command specifier with all bits set."""

    halted = False

    def receive(self, frame: bytes) -> list[bytes]:
        answers = [] if self.halted else super().receive(frame)
        self.halted |= frame[:1] == b"\xff"
        return answers


@fault("upload-segment-served-in-download", Defect.STATE, "segmented-download.foreign")
class UploadSegmentInDownload(Server):
    """Sends what it has of a download in answer to an upload segment request."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        if isinstance(self.transfer, Download):
            data = bytes(self.transfer.data[:7])
            return [UploadSegmentResponse.with_data(data, toggle=request.toggle)]
        return super().on_upload_segment(request)


class ForeignIgnored(Server):
    """Ignores frames of block transfers in a running transfer of one kind."""

    during: type[Download] | type[Upload] = Upload

    def on_unexpected(self, request: Request) -> list[Response]:
        if isinstance(self.transfer, self.during):
            return []
        return super().on_unexpected(request)


@fault("foreign-ignored-in-download", Defect.STATE, "segmented-download.foreign")
class ForeignIgnoredInDownload(ForeignIgnored):
    """Ignores frames of other services in a segmented download."""

    during = Download


@fault("download-segment-without-initiate", Defect.STATE, "segmented-download.without-initiate")
class DownloadSegmentWithoutInitiate(Server):
    """Confirms a segment without a transfer."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        if self.transfer is None:
            return [DownloadSegmentResponse(request.toggle)]
        return super().on_download_segment(request)


@fault("download-survives-its-end", Defect.STATE, "segmented-download.after-the-last")
class DownloadSurvives(Server):
    """Appends a segment that comes after the last one."""

    finished: Download | None = None

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        if self.transfer is None and self.finished is not None:
            self.transfer = replace(self.finished, size=None, toggle=request.toggle)
        transfer = self.transfer
        responses = super().on_download_segment(request)
        if self.transfer is None and isinstance(transfer, Download):
            self.finished = transfer
        return responses


@fault("restart-keeps-segments", Defect.STATE, "segmented-download.restart")
class RestartKeepsSegments(Server):
    """Keeps the segments of a download when it is started again in the middle."""

    kept = b""

    def react(self, request: Request) -> list[Response]:
        self.kept = bytes(self.transfer.data) if isinstance(self.transfer, Download) else b""
        kept, begun = self.kept, isinstance(self.transfer, Download)
        responses = super().react(request)
        if begun and isinstance(request, DownloadInitiate) and isinstance(self.transfer, Download):
            self.transfer.data[:] = kept
            self.transfer.size = None
        return responses


@fault("new-upload-leaves-old-transfer", Defect.STATE, "segmented-download.new-upload")
class NewLeavesOld(Server):
    """Serves an expedited upload in the middle of a download, which then goes on."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        old = self.transfer
        responses = super().on_upload_initiate(request)
        if isinstance(old, Download) and self.transfer is None:
            self.transfer = old
        return responses


@fault("new-download-commits-old", Defect.STATE, "segmented-download.number-kept")
class NewCommitsOld(Server):
    """Stores what came of a download when another one begins."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        old = self.transfer
        if isinstance(old, Download) and old.data and old.mux != request.mux:
            old.entry.value = bytes(old.data)
        return super().on_download_initiate(request)


@fault("abort-echoed-in-download", Defect.ABORT, "segmented-download.client-abort")
class EchoedInDownload(Server):
    """Sends the abort of a download back."""

    def on_abort(self, request: Abort) -> list[Response]:
        running = isinstance(self.transfer, Download)
        super().on_abort(request)
        return [request] if running else []


@fault("abort-ignored-in-download", Defect.ABORT, "segmented-download.client-abort-then-segment")
class IgnoredInDownload(Server):
    """Goes on with a download that the client has aborted."""

    def on_abort(self, request: Abort) -> list[Response]:
        return [] if isinstance(self.transfer, Download) else super().on_abort(request)


@fault("abort-commits-download", Defect.ABORT, "segmented-download.number-kept")
class CommitsDownload(Server):
    """Stores what has come of a download that the client aborts."""

    def on_abort(self, request: Abort) -> list[Response]:
        if isinstance(self.transfer, Download) and self.transfer.data:
            self.transfer.entry.value = bytes(self.transfer.data)
        return super().on_abort(request)


@fault("abort-reserved-bits-confirmed", Defect.ABORT, "segmented-download.abort-reserved-bits")
class ReservedBitsConfirmed(Server):
    """Confirms 81h to 9Fh in a download as if it were an initiate."""

    def on_abort(self, request: Abort) -> list[Response]:
        if request.reserved_bits and isinstance(self.transfer, Download):
            return [DownloadInitiateResponse(request.mux)]
        return super().on_abort(request)


@fault("foreign-abort-answered", Defect.ABORT, "segmented-download.foreign-abort")
class ForeignAnswered(Server):
    """Answers an abort of another object: no such object."""

    def on_abort(self, request: Abort) -> list[Response]:
        if isinstance(self.transfer, Download) and request.mux != self.transfer.mux:
            return [Abort(request.mux, AbortCode.OBJECT_MISSING)]
        return super().on_abort(request)


@fault(
    "unknown-specifier-ignored-in-download",
    Defect.STATE,
    "segmented-download.foreign[unknown",
    "segmented-download.foreign-later",
    "matrix.segmented-download-first",
    "matrix.segmented-download-middle",
    "matrix.segmented-download-last",
)
class UnknownIgnoredInDownload(Server):
    """Ignores an unknown command specifier in a segmented download."""

    def react(self, request: Request) -> list[Response]:
        ignored = isinstance(self.transfer, Download) and isinstance(request, Unknown)
        return [] if ignored else super().react(request)


@fault("block-frames-ignored-in-download", Defect.STATE, "segmented-download.foreign[block")
class BlockFramesIgnoredInDownload(Server):
    """Ignores the inner frames of a block transfer in a segmented download."""

    def react(self, request: Request) -> list[Response]:
        ignored = isinstance(self.transfer, Download) and isinstance(request, BLOCK_FRAMES)
        return [] if ignored else super().react(request)


@fault("vanished-client-completes-later", Defect.TIMING, "segmented-download.number-kept")
class CompletesLater(Server):
    """Writes what came of a download when an upload begins before its end."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, Download | BlockDownload) and transfer.data:
            transfer.entry.value = bytes(transfer.data)
        return super().on_upload_initiate(request)


@fault("initiate-joins-running-transfer", Defect.STATE, "segmented-download.new-download")
class InitiateJoins(Server):
    """Confirms an initiate in the middle of a segmented transfer, and goes on with the old one."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        if isinstance(self.transfer, Download) and not request.expedited:
            return [DownloadInitiateResponse(request.mux)]
        return super().on_download_initiate(request)

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        running = self.transfer
        if isinstance(running, Upload):
            size = len(self.value_to_read(self.objects.readable(request.mux)))
            if not 1 <= size <= EXPEDITED_LENGTH:
                return [UploadInitiateResponse.with_size(request.mux, size)]
        return super().on_upload_initiate(request)


@fault("upload-and-download-side-by-side", Defect.STATE, "segmented-download.new-upload")
class SideBySide(Server):
    """Keeps an upload and a download at the same time, and serves segments of both."""

    parked: Transfer | None = None
    downloads = True

    def react(self, request: Request) -> list[Response]:
        wanted = isinstance(request, _OF_DOWNLOADS)
        if wanted is not self.downloads and (wanted or isinstance(request, _OF_UPLOADS)):
            self.downloads = wanted
            self.transfer, self.parked = self.parked, self.transfer
        return super().react(request)

    def on_abort(self, request: Abort) -> list[Response]:
        self.parked = None
        return super().on_abort(request)


@fault(
    "unsized-download-empties-string",
    Defect.LEAK,
    "segmented-download.client-abort-unsized",
    soft=True,
)
class UnsizedEmptiesString(Server):
    """Empties a string or domain as soon as a download without a size begins."""

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        if request.size is None and entry.data_type.length is None:
            entry.value = b""
        return super().start_download(request, entry)
