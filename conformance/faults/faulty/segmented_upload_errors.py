"""Servers that are wrong in a segmented upload about aborts, and about what belongs there."""

from dataclasses import replace

from conformance.faults.faulty.segmented_download_errors import BLOCK_FRAMES, ForeignIgnored
from conformance.faults.registry import Defect, fault
from conformance.reference.segmented_server import NO_MULTIPLEXER, Upload
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import is_abort
from conformance.sdo.frames import (
    Abort,
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


@fault("unknown-specifier-goes-on", Defect.STATE, "segmented-upload.foreign")
class UnknownGoesOn(Server):
    """Refuses a frame of another service but lets the running transfer live."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        transfer = self.transfer
        responses = super().refuse(request, code)
        if code is AbortCode.COMMAND_NOT_VALID:
            self.transfer = transfer
        return responses


@fault("download-segment-confirmed-in-upload", Defect.STATE, "segmented-upload.foreign")
class DownloadSegmentInUpload(Server):
    """Confirms a download segment in the middle of an upload."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        if isinstance(self.transfer, Upload):
            return [DownloadSegmentResponse(request.toggle)]
        return super().on_download_segment(request)


@fault("foreign-ignored-in-upload", Defect.STATE, "segmented-upload.foreign")
class ForeignIgnoredInUpload(ForeignIgnored):
    """Ignores frames of other services in a segmented upload."""


@fault("foreign-code-wrong-in-upload", Defect.STATE, "segmented-upload.foreign-later")
class ForeignCodeWrong(Server):
    """Reports a frame of another service in a transfer that has begun as a toggle error."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        transfer = self.transfer
        begun = isinstance(transfer, Upload) and transfer.offset
        if begun and code is AbortCode.COMMAND_NOT_VALID:
            return super().refuse(request, AbortCode.TOGGLE_NOT_ALTERNATED)
        return super().refuse(request, code)


@fault("upload-segment-without-initiate", Defect.STATE, "segmented-upload.without-initiate")
class UploadSegmentWithoutInitiate(Server):
    """Answers a segment request without a transfer with an empty last segment."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        if self.transfer is None:
            return [UploadSegmentResponse.with_data(b"", toggle=request.toggle, last=True)]
        return super().on_upload_segment(request)


@fault("upload-survives-its-end", Defect.STATE, "segmented-upload.after-the-last")
class UploadSurvives(Server):
    """Sends an upload from its beginning again when asked for more after the last segment."""

    finished: Upload | None = None

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        if self.transfer is None and self.finished is not None:
            self.transfer = replace(self.finished, offset=0, toggle=request.toggle)
        transfer = self.transfer
        responses = super().on_upload_segment(request)
        if self.transfer is None and isinstance(transfer, Upload):
            self.finished = transfer
        return responses


@fault("new-upload-ignored-in-transfer", Defect.STATE, "segmented-upload.")
class NewUploadIgnored(Server):
    """Does not answer an initiate in the middle of a transfer."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        return [] if self.transfer is not None else super().on_upload_initiate(request)


@fault("new-download-ignored-in-transfer", Defect.STATE, "segmented-upload.new-download")
class NewDownloadIgnored(Server):
    """Does not answer a download initiate in the middle of a transfer."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        return [] if self.transfer is not None else super().on_download_initiate(request)


@fault("restart-goes-on", Defect.STATE, "segmented-upload.restart")
class RestartGoesOn(Server):
    """Confirms a second initiate of the same upload and goes on where it was."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        offset = self.offset
        response = super().start_upload(mux, data)
        if isinstance(self.transfer, Upload) and offset < len(data):
            self.transfer.offset = offset
        return response

    offset = 0

    def react(self, request: Request) -> list[Response]:
        self.offset = self.transfer.offset if isinstance(self.transfer, Upload) else 0
        return super().react(request)


@fault("new-upload-serves-old-object", Defect.STATE, "segmented-upload.new-upload")
class NewServesOld(Server):
    """Answers the upload of another object in mid-transfer with bytes of the old one."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        old = self.transfer
        responses = super().on_upload_initiate(request)
        if isinstance(old, Upload) and old.mux != request.mux:
            return [UploadInitiateResponse.with_data(request.mux, old.data[:4])]
        return responses


@fault("abandoned-upload-deaf", Defect.LEAK, "segmented-upload.client-abort-then-upload")
class AbandonedUploadDeaf(Server):
    """Loses the first request behind the abort of an upload."""

    deaf = False

    def receive(self, frame: bytes) -> list[bytes]:
        """Drop one request, unless it reads the device type."""
        if is_abort(frame) and isinstance(self.transfer, Upload):
            self.deaf = True
        elif self.deaf:
            self.deaf = False
            if frame[1:3] != b"\x00\x10":
                return []
        return super().receive(frame)


@fault("abort-echoed-in-upload", Defect.ABORT, "segmented-upload.client-abort")
class EchoedInUpload(Server):
    """Sends the abort of an upload back."""

    def on_abort(self, request: Abort) -> list[Response]:
        running = isinstance(self.transfer, Upload)
        super().on_abort(request)
        return [request] if running else []


@fault(
    "abort-ignored-in-upload",
    Defect.ABORT,
    "segmented-upload.client-abort",
    "segmented-upload.client-abort-then-segment",
)
class IgnoredInUpload(Server):
    """Goes on with an upload that the client has aborted."""

    def on_abort(self, request: Abort) -> list[Response]:
        return [] if isinstance(self.transfer, Upload) else super().on_abort(request)


@fault(
    "unknown-specifier-ignored-in-upload",
    Defect.STATE,
    "segmented-upload.foreign[unknown",
    "matrix.segmented-upload-first",
    "matrix.segmented-upload-middle",
    "matrix.segmented-upload-last",
)
class UnknownIgnoredInUpload(Server):
    """Ignores an unknown command specifier in a segmented upload."""

    def react(self, request: Request) -> list[Response]:
        ignored = isinstance(self.transfer, Upload) and isinstance(request, Unknown)
        return [] if ignored else super().react(request)


@fault("block-frames-ignored-in-upload", Defect.STATE, "segmented-upload.foreign[block")
class BlockFramesIgnoredInUpload(Server):
    """Ignores the inner frames of a block transfer in a segmented upload."""

    def react(self, request: Request) -> list[Response]:
        ignored = isinstance(self.transfer, Upload) and isinstance(request, BLOCK_FRAMES)
        return [] if ignored else super().react(request)


@fault("abort-in-transfer-unnamed", Defect.ABORT, "segmented-upload.toggle")
class AbortUnnamed(Server):
    """Ends a transfer with an abort of 0000h:00, and goes on with it all the same."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        running = self.transfer
        responses = super().refuse(request, code)
        if running is None:
            return responses
        self.transfer = running
        return [
            replace(response, mux=NO_MULTIPLEXER) if isinstance(response, Abort) else response
            for response in responses
        ]
