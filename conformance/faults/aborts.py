"""Servers that are wrong in aborts: the ones that they send, and the ones that they get."""

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    DownloadInitiateResponse,
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.segmented_server import Download, Upload
from conformance.sdo.server import Server

ABORT = DefectClass.ABORT
SHAPE = DefectClass.FRAME_SHAPE


@fault("abort-answered-when-idle", ABORT, "abort.not-answered")
class AnsweredWhenIdle(Server):
    """Answers an abort that meets no transfer with an abort."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Complain."""
        if self.transfer is None:
            return [Abort(request.mux, AbortCode.COMMAND_NOT_VALID)]
        return super().on_abort(request)


@fault("abort-echoed-in-upload", ABORT, "segmented-upload.client-abort")
class EchoedInUpload(Server):
    """Sends the abort of an upload back."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Echo it."""
        running = isinstance(self.transfer, Upload)
        super().on_abort(request)
        return [request] if running else []


@fault("abort-echoed-in-download", ABORT, "segmented-download.client-abort")
class EchoedInDownload(Server):
    """Sends the abort of a download back."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Echo it."""
        running = isinstance(self.transfer, Download)
        super().on_abort(request)
        return [request] if running else []


@fault("abort-ignored-in-upload", ABORT, "segmented-upload.client-abort")
class IgnoredInUpload(Server):
    """Goes on with an upload that the client has aborted."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Ignore it."""
        return [] if isinstance(self.transfer, Upload) else super().on_abort(request)


@fault("abort-ignored-in-download", ABORT, "segmented-download.client-abort-then-segment")
class IgnoredInDownload(Server):
    """Goes on with a download that the client has aborted."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Ignore it."""
        return [] if isinstance(self.transfer, Download) else super().on_abort(request)


@fault("abort-commits-download", ABORT, "segmented-download.number-kept")
class CommitsDownload(Server):
    """Stores what has come of a download that the client aborts."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Commit."""
        if isinstance(self.transfer, Download) and self.transfer.data:
            self.transfer.entry.value = bytes(self.transfer.data)
        return super().on_abort(request)


@fault("abort-undoes-last-download", ABORT, "abort.after-a-transfer")
class UndoesLast(Server):
    """Takes back the last expedited download when an abort follows it."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        """Remember the value."""
        value = self.objects.writable(request.mux).value
        responses = super().on_download_initiate(request)
        if request.expedited:
            self.undo = (request.mux, value)
        return responses

    undo: tuple[Multiplexer, bytes] | None = None

    def on_abort(self, request: Abort) -> list[Response]:
        """Put it back."""
        if self.undo is not None and self.undo[0] == request.mux:
            self.objects.find(request.mux).value = self.undo[1]
        return super().on_abort(request)


@fault("deaf-after-three-aborts", ABORT, "abort.repeated")
class DeafAfterAborts(Server):
    """Reads 1018h:01 as 0 after three aborts in a row."""

    count = 0

    def on_abort(self, request: Abort) -> list[Response]:
        """Count."""
        self.count += 1
        return super().on_abort(request)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Answer wrongly once."""
        if self.count >= 3 and mux == Multiplexer(0x1018, 1):
            self.count = 0
            data = b"\xff\xff\xff\xff"
        elif mux != Multiplexer(0x1000):
            self.count = 0
        return super().start_upload(mux, data)


@fault("abort-reserved-bits-served", ABORT, "abort.reserved-bits")
class ReservedBitsServed(Server):
    """Takes 81h to 9Fh for an upload initiate."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Serve it."""
        if request.reserved_bits:
            return self.on_upload_initiate(UploadInitiate(request.mux))
        return super().on_abort(request)


@fault("abort-reserved-bits-confirmed", ABORT, "segmented-download.abort-reserved-bits")
class ReservedBitsConfirmed(Server):
    """Confirms 81h to 9Fh in a download as if it were an initiate."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Confirm it."""
        if request.reserved_bits and isinstance(self.transfer, Download):
            return [DownloadInitiateResponse(request.mux)]
        return super().on_abort(request)


@fault("foreign-abort-answered", ABORT, "segmented-download.foreign-abort")
class ForeignAnswered(Server):
    """Answers an abort of another object: no such object."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Look at the multiplexer."""
        if isinstance(self.transfer, Download) and request.mux != self.transfer.mux:
            return [Abort(request.mux, AbortCode.OBJECT_MISSING)]
        return super().on_abort(request)


@fault("short-abort-served", ABORT, "frame.short-abort")
class ShortAbortServed(Server):
    """Takes an abort of fewer than 8 bytes for a request for the next segment."""

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        """Serve it in an upload."""
        if isinstance(self.transfer, Upload) and frame[:1] == b"\x80":
            return self.receive(bytes([0x60 | self.transfer.toggle << 4]) + bytes(7))
        return super().on_wrong_length(frame)


class _Refusing(Server):
    """Changes the aborts that it sends."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Pass each abort through ``changed``."""
        return [
            self.changed(response) if isinstance(response, Abort) else response
            for response in super().refuse(request, code)
        ]

    def changed(self, abort: Abort) -> Abort:
        """Return what is sent instead."""
        return abort


@fault("abort-big-endian", SHAPE, "abort.frame")
class BigEndian(_Refusing):
    """Sends abort codes with the high byte first."""

    def changed(self, abort: Abort) -> Abort:
        """Turn the code round."""
        return Abort(abort.mux, int.from_bytes(abort.code.to_bytes(4, "little"), "big"))


@fault("abort-code-private", SHAPE, "abort.frame")
class PrivateCode(_Refusing):
    """Sends abort codes of its own."""

    def changed(self, abort: Abort) -> Abort:
        """Use a code that no table knows."""
        return Abort(abort.mux, 0x0F00FFC0)


@fault("abort-command-81h", SHAPE, "abort.frame")
class Command81h(_Refusing):
    """Sends aborts with a reserved bit set."""

    def changed(self, abort: Abort) -> Abort:
        """Set the bit."""
        return Abort(abort.mux, abort.code, 1)


@fault("abort-multiplexer-missing", SHAPE, "abort.own-multiplexer")
class MultiplexerMissing(_Refusing):
    """Sends aborts without a multiplexer."""

    def changed(self, abort: Abort) -> Abort:
        """Clear it."""
        return Abort(Multiplexer(0), abort.code)


@fault("abort-multiplexer-stale", SHAPE, "abort.own-multiplexer")
class MultiplexerStale(_Refusing):
    """Sends the multiplexer of the last object that was served in the abort of the next one."""

    served = Multiplexer(0)

    def react(self, request: Request) -> list[Response]:
        """Remember what was served."""
        responses = super().react(request)
        if isinstance(request, UploadInitiate | DownloadInitiate):
            self.served = request.mux
        return responses

    def changed(self, abort: Abort) -> Abort:
        """Use the old one."""
        return Abort(self.served, abort.code)


@fault("abort-multiplexer-stale-in-download", SHAPE, "abort.own-multiplexer-download")
class MultiplexerStaleInDownload(Server):
    """Sends multiplexer 0 in the abort of a download to a missing object."""

    def refused_multiplexer(self, request: Request) -> Multiplexer:
        """Look it up in vain."""
        if isinstance(request, DownloadInitiate):
            return Multiplexer(0)
        return super().refused_multiplexer(request)


class _Twice(Server):
    """Sends something behind an abort."""

    request_kind: type[UploadInitiate] | type[DownloadInitiate] = UploadInitiate

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Add a second frame."""
        responses = super().refuse(request, code)
        if isinstance(request, self.request_kind):
            responses.append(self.second(request.mux))
        return responses

    def second(self, mux: Multiplexer) -> Response:
        """Return the frame too many."""
        return Abort(mux, AbortCode.GENERAL_ERROR)


@fault("refused-upload-aborted-twice", ABORT, "upload.refused-once")
class UploadAbortedTwice(_Twice):
    """Sends a second abort behind that of a refused upload."""


@fault("refused-download-confirmed", ABORT, "download.refused-once")
class DownloadConfirmed(_Twice):
    """Sends the confirmation behind the abort of a refused download."""

    request_kind = DownloadInitiate

    def second(self, mux: Multiplexer) -> Response:
        """Confirm."""
        return DownloadInitiateResponse(mux)
