"""Servers that are wrong about which transfer is running, or whether one is."""

from dataclasses import replace

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    BlockUploadInitiate,
    DownloadInitiate,
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
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Refusal
from conformance.sdo.segmented_server import Download, SegmentedServer, Upload
from conformance.sdo.server import Server

STATE = DefectClass.STATE
ROBUST = DefectClass.ROBUSTNESS


@fault("unknown-specifier-ignored", ROBUST, "specifier.unknown")
class UnknownIgnored(Server):
    """Does not answer a command specifier that it does not know."""

    def on_unexpected(self, request: Request) -> list[Response]:
        """Keep silent."""
        return []


@fault("unknown-specifier-code-wrong", ROBUST, "specifier.unknown")
class UnknownCodeWrong(Server):
    """Reports an unknown command specifier as a missing object."""

    def on_unexpected(self, request: Request) -> list[Response]:
        """Give another reason."""
        raise Refusal(AbortCode.OBJECT_MISSING)


@fault("unknown-specifier-served-as-upload", ROBUST, "specifier.unknown")
class UnknownServed(Server):
    """Serves an unknown command specifier as an upload."""

    def on_unexpected(self, request: Request) -> list[Response]:
        """Look at the multiplexer only."""
        if isinstance(request, Unknown):
            mux = Multiplexer(int.from_bytes(request.frame[1:3], "little"), request.frame[3])
            return self.on_upload_initiate(UploadInitiate(mux))
        return super().on_unexpected(request)


@fault("unknown-specifier-spoils-next-read", ROBUST, "specifier.unknown-is-over")
class UnknownSpoilsNext(Server):
    """Reads 1018h:01 as 0 right after an unknown command specifier."""

    spoiled = False

    def react(self, request: Request) -> list[Response]:
        """Remember the request before."""
        spoiled, self.spoiled = self.spoiled, isinstance(request, Unknown)
        if spoiled and request == UploadInitiate(Multiplexer(0x1018, 1)):
            return [UploadInitiateResponse.with_data(Multiplexer(0x1018, 1), b"\xff" * 4)]
        return super().react(request)


@fault("unknown-specifier-halts", ROBUST, "segmented-download.foreign")
class UnknownHalts(Server):
    """Stops working after an unknown command specifier with all bits set."""

    halted = False

    def receive(self, frame: bytes) -> list[bytes]:
        """Answer it, and then nothing any more."""
        answers = [] if self.halted else super().receive(frame)
        self.halted |= frame[:1] == b"\xff"
        return answers


@fault("unknown-specifier-goes-on", STATE, "segmented-upload.foreign")
class UnknownGoesOn(Server):
    """Refuses a frame of another service but lets the running transfer live."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Keep the transfer."""
        transfer = self.transfer
        responses = super().refuse(request, code)
        if code is AbortCode.COMMAND_NOT_VALID:
            self.transfer = transfer
        return responses


@fault("upload-segment-served-in-download", STATE, "segmented-download.foreign")
class UploadSegmentInDownload(Server):
    """Sends what it has of a download in answer to an upload segment request."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Serve from the buffer."""
        if isinstance(self.transfer, Download):
            data = bytes(self.transfer.data[:7])
            return [UploadSegmentResponse.with_data(data, toggle=request.toggle)]
        return super().on_upload_segment(request)


@fault("download-segment-confirmed-in-upload", STATE, "segmented-upload.foreign")
class DownloadSegmentInUpload(Server):
    """Confirms a download segment in the middle of an upload."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Confirm it."""
        if isinstance(self.transfer, Upload):
            return [DownloadSegmentResponse(request.toggle)]
        return super().on_download_segment(request)


class _ForeignIgnored(Server):
    """Ignores frames of block transfers in a running transfer of one kind."""

    during: type[Download] | type[Upload] = Upload

    def on_unexpected(self, request: Request) -> list[Response]:
        """Keep silent during such a transfer."""
        if isinstance(self.transfer, self.during):
            return []
        return super().on_unexpected(request)


@fault("foreign-ignored-in-upload", STATE, "segmented-upload.foreign")
class ForeignIgnoredInUpload(_ForeignIgnored):
    """Ignores frames of other services in a segmented upload."""


@fault("foreign-ignored-in-download", STATE, "segmented-download.foreign")
class ForeignIgnoredInDownload(_ForeignIgnored):
    """Ignores frames of other services in a segmented download."""

    during = Download


@fault("foreign-code-wrong-in-upload", STATE, "segmented-upload.foreign-later")
class ForeignCodeWrong(Server):
    """Reports a frame of another service in a transfer that has begun as a toggle error."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Give another reason."""
        transfer = self.transfer
        begun = isinstance(transfer, Upload) and transfer.offset
        if begun and code is AbortCode.COMMAND_NOT_VALID:
            return super().refuse(request, AbortCode.TOGGLE_NOT_ALTERNATED)
        return super().refuse(request, code)


@fault("upload-segment-without-initiate", STATE, "segmented-upload.without-initiate")
class UploadSegmentWithoutInitiate(Server):
    """Answers a segment request without a transfer with an empty last segment."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Serve nothing, politely."""
        if self.transfer is None:
            return [UploadSegmentResponse.with_data(b"", toggle=request.toggle, last=True)]
        return super().on_upload_segment(request)


@fault("download-segment-without-initiate", STATE, "segmented-download.without-initiate")
class DownloadSegmentWithoutInitiate(Server):
    """Confirms a segment without a transfer."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Confirm, and store nothing."""
        if self.transfer is None:
            return [DownloadSegmentResponse(request.toggle)]
        return super().on_download_segment(request)


@fault("block-frame-confirmed-out-of-block", STATE, "specifier.out-of-block")
class BlockFrameConfirmed(Server):
    """Confirms the end of a block download that nobody started."""

    def receive(self, frame: bytes) -> list[bytes]:
        """Answer C1h to DDh with A1h."""
        if self.transfer is None and frame[:1] and frame[0] & 0xE3 == 0xC1:
            return [b"\xa1" + bytes(7)]
        return super().receive(frame)


@fault("upload-survives-its-end", STATE, "segmented-upload.after-the-last")
class UploadSurvives(Server):
    """Sends an upload from its beginning again when asked for more after the last segment."""

    finished: Upload | None = None

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Start over."""
        if self.transfer is None and self.finished is not None:
            self.transfer = replace(self.finished, offset=0, toggle=request.toggle)
        transfer = self.transfer
        responses = super().on_upload_segment(request)
        if self.transfer is None and isinstance(transfer, Upload):
            self.finished = transfer
        return responses


@fault("download-survives-its-end", STATE, "segmented-download.after-the-last")
class DownloadSurvives(Server):
    """Appends a segment that comes after the last one."""

    finished: Download | None = None

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Go on with the transfer that was over."""
        if self.transfer is None and self.finished is not None:
            self.transfer = replace(self.finished, size=None, toggle=request.toggle)
        transfer = self.transfer
        responses = super().on_download_segment(request)
        if self.transfer is None and isinstance(transfer, Download):
            self.finished = transfer
        return responses


@fault("new-upload-ignored-in-transfer", STATE, "segmented-upload.")
class NewUploadIgnored(Server):
    """Does not answer an initiate in the middle of a transfer."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Keep silent."""
        return [] if self.transfer is not None else super().on_upload_initiate(request)


@fault("new-download-ignored-in-transfer", STATE, "segmented-upload.new-download")
class NewDownloadIgnored(Server):
    """Does not answer a download initiate in the middle of a transfer."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        """Keep silent."""
        return [] if self.transfer is not None else super().on_download_initiate(request)


@fault("restart-goes-on", STATE, "segmented-upload.restart")
class RestartGoesOn(Server):
    """Confirms a second initiate of the same upload and goes on where it was."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Keep the offset."""
        offset = self.offset
        response = super().start_upload(mux, data)
        if isinstance(self.transfer, Upload) and offset < len(data):
            self.transfer.offset = offset
        return response

    offset = 0

    def react(self, request: Request) -> list[Response]:
        """Remember how far the transfer was."""
        self.offset = self.transfer.offset if isinstance(self.transfer, Upload) else 0
        return super().react(request)


@fault("restart-keeps-segments", STATE, "segmented-download.restart")
class RestartKeepsSegments(Server):
    """Keeps the segments of a download when it is started again in the middle."""

    kept = b""

    def react(self, request: Request) -> list[Response]:
        """Remember what came so far."""
        self.kept = bytes(self.transfer.data) if isinstance(self.transfer, Download) else b""
        kept, begun = self.kept, isinstance(self.transfer, Download)
        responses = super().react(request)
        if begun and isinstance(request, DownloadInitiate) and isinstance(self.transfer, Download):
            self.transfer.data[:] = kept
            self.transfer.size = None
        return responses


@fault("new-upload-serves-old-object", STATE, "segmented-upload.new-upload")
class NewServesOld(Server):
    """Answers the upload of another object in mid-transfer with bytes of the old one."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Mix the new multiplexer with the old data."""
        old = self.transfer
        responses = super().on_upload_initiate(request)
        if isinstance(old, Upload) and old.mux != request.mux:
            return [UploadInitiateResponse.with_data(request.mux, old.data[:4])]
        return responses


@fault("new-upload-leaves-old-transfer", STATE, "segmented-download.new-upload")
class NewLeavesOld(Server):
    """Serves an expedited upload in the middle of a download, which then goes on."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Keep the download beside it."""
        old = self.transfer
        responses = super().on_upload_initiate(request)
        if isinstance(old, Download) and self.transfer is None:
            self.transfer = old
        return responses


@fault("new-download-commits-old", STATE, "segmented-download.number-kept")
class NewCommitsOld(Server):
    """Stores what came of a download when another one begins."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        """Commit first."""
        old = self.transfer
        if isinstance(old, Download) and old.data and old.mux != request.mux:
            old.entry.value = bytes(old.data)
        return super().on_download_initiate(request)


@fault("block-refused-in-silence", ROBUST, "specifier.block-")
class BlockSilent(SegmentedServer):
    """Does not answer a block initiate, which it does not implement."""

    def on_block_initiate(
        self, request: BlockDownloadInitiate | BlockUploadInitiate
    ) -> list[Response]:
        """Keep silent."""
        return []


@fault("block-refused-with-wrong-code", ROBUST, "specifier.block-download")
class BlockCodeWrong(SegmentedServer):
    """Refuses block transfers as if the object did not exist."""

    def on_block_initiate(
        self, request: BlockDownloadInitiate | BlockUploadInitiate
    ) -> list[Response]:
        """Give another reason."""
        raise Refusal(AbortCode.OBJECT_MISSING)


@fault("block-upload-switched-without-leave", ROBUST, "specifier.block-upload")
class BlockSwitched(SegmentedServer):
    """Answers a block upload with an ordinary one though pst = 0 forbids it."""

    def on_block_initiate(
        self, request: BlockDownloadInitiate | BlockUploadInitiate
    ) -> list[Response]:
        """Switch."""
        if isinstance(request, BlockUploadInitiate):
            return self.on_upload_initiate(UploadInitiate(request.mux))
        return super().on_block_initiate(request)


@fault("second-request-mixed-up", DefectClass.BACK_TO_BACK, "upload.behind-another")
class SecondMixedUp(Server):
    """Answers a read of 1018h:01 right behind one of 1018h:00 with the data of the first."""

    before: UploadInitiate | None = None

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Use the old buffer under the new multiplexer."""
        before, self.before = self.before, request
        responses = super().on_upload_initiate(request)
        mixed = before is not None and before.mux == Multiplexer(0x1018, 0)
        if mixed and request.mux == Multiplexer(0x1018, 1):
            return [UploadInitiateResponse.with_data(request.mux, b"\x04\x04\x04\x04")]
        return responses
