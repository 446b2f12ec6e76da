"""Servers that are wrong in aborts: those that they send, and those that they get."""

from conformance.faults.own_clock import OneByOne
from conformance.faults.registry import About, Defect, fault
from conformance.reference.segmented_server import NO_MULTIPLEXER, Upload
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import is_abort
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NMT_ID
from conformance.sdo.objects import Refusal


@fault("refusals-run-out", Defect.ROBUSTNESS, "abort.many")
class RefusalsRunOut(Server):
    """Answers refused uploads for good with another code after 30 in a row."""

    count = 0

    def react(self, request: Request) -> list[Response]:
        """Start again with a request that is served."""
        responses = super().react(request)
        self.count = 0
        return responses

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        self.count += 1
        if self.count > 30:
            code = AbortCode.OUT_OF_MEMORY
        return super().refuse(request, code)


@fault("transfers-run-out", Defect.ROBUSTNESS, "abort.many-transfers")
class TransfersRunOut(Server):
    """Loses memory with each transfer that the client aborts, until none is left."""

    lost = 0

    def on_abort(self, request: Abort) -> list[Response]:
        self.lost += isinstance(self.transfer, Upload)
        return super().on_abort(request)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Refuse when nothing is left; a whole transfer clears the heap."""
        if self.lost > 30 and len(data) > 4:
            self.lost = 0
            raise Refusal(AbortCode.OUT_OF_MEMORY)
        return super().start_upload(mux, data)


@fault("abort-answered-when-idle", Defect.ABORT, "abort.not-answered")
class AnsweredWhenIdle(Server):
    """Answers an abort that meets no transfer with an abort."""

    def on_abort(self, request: Abort) -> list[Response]:
        if self.transfer is None:
            return [Abort(request.mux, AbortCode.COMMAND_NOT_VALID)]
        return super().on_abort(request)


@fault("abort-undoes-last-download", Defect.ABORT, "abort.after-a-transfer")
class UndoesLast(Server):
    """Takes back the last expedited download when an abort follows it."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        value = self.objects.writable(request.mux).value
        responses = super().on_download_initiate(request)
        if request.expedited:
            self.undo = (request.mux, value)
        return responses

    undo: tuple[Multiplexer, bytes] | None = None

    def on_abort(self, request: Abort) -> list[Response]:
        if self.undo is not None and self.undo[0] == request.mux:
            self.objects.find(request.mux).value = self.undo[1]
        return super().on_abort(request)


@fault("deaf-after-three-aborts", Defect.ABORT, "abort.repeated")
class DeafAfterAborts(Server):
    """Reads 1018h:01 as 0 after three aborts in a row."""

    count = 0

    def on_abort(self, request: Abort) -> list[Response]:
        self.count += 1
        return super().on_abort(request)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        if self.count >= 3 and mux == Multiplexer(0x1018, 1):
            self.count = 0
            data = b"\xff\xff\xff\xff"
        elif mux != Multiplexer(0x1000):
            self.count = 0
        return super().start_upload(mux, data)


@fault("abort-reserved-bits-served", Defect.ABORT, "abort.reserved-bits")
class ReservedBitsServed(Server):
    """Takes 81h to 9Fh for an upload initiate."""

    def on_abort(self, request: Abort) -> list[Response]:
        if request.reserved_bits:
            return self.on_upload_initiate(UploadInitiate(request.mux))
        return super().on_abort(request)


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


@fault("abort-big-endian", Defect.FRAME_SHAPE, "abort.frame")
class BigEndian(_Refusing):
    """Sends abort codes with the high byte first."""

    def changed(self, abort: Abort) -> Abort:
        return Abort(abort.mux, int.from_bytes(abort.code.to_bytes(4, "little"), "big"))


@fault("abort-code-private", Defect.FRAME_SHAPE, "abort.frame")
class PrivateCode(_Refusing):
    """Sends abort codes of its own."""

    def changed(self, abort: Abort) -> Abort:
        return Abort(abort.mux, 0x0F00FFC0)


@fault("abort-command-81h", Defect.FRAME_SHAPE, "abort.frame")
class Command81h(_Refusing):
    """Sends aborts with a reserved bit set."""

    def changed(self, abort: Abort) -> Abort:
        return Abort(abort.mux, abort.code, 1)


@fault("abort-multiplexer-missing", Defect.FRAME_SHAPE, "abort.own-multiplexer")
class MultiplexerMissing(_Refusing):
    """Sends aborts without a multiplexer."""

    def changed(self, abort: Abort) -> Abort:
        return Abort(Multiplexer(0), abort.code)


@fault("abort-multiplexer-stale", Defect.FRAME_SHAPE, "abort.own-multiplexer")
class MultiplexerStale(_Refusing):
    """Sends the multiplexer of the last object that was served in the abort of the next one."""

    served = Multiplexer(0)

    def react(self, request: Request) -> list[Response]:
        responses = super().react(request)
        if isinstance(request, UploadInitiate | DownloadInitiate):
            self.served = request.mux
        return responses

    def changed(self, abort: Abort) -> Abort:
        return Abort(self.served, abort.code)


@fault("abort-multiplexer-stale-in-download", Defect.FRAME_SHAPE, "abort.own-multiplexer-download")
class MultiplexerStaleInDownload(Server):
    """Sends multiplexer 0 in the abort of a download to a missing object."""

    def refused_multiplexer(self, request: Request) -> Multiplexer:
        if isinstance(request, DownloadInitiate):
            return Multiplexer(0)
        return super().refused_multiplexer(request)


@fault("every-abort-answered", Defect.ABORT, "abort.not-answered", "run.outside-the-cases")
class EveryAbortAnswered(Server):
    """Answers every abort with an abort of 0000h:00, as it does commands that it does not know."""

    def on_abort(self, request: Abort) -> list[Response]:
        return [*super().on_abort(request), Abort(NO_MULTIPLEXER, AbortCode.COMMAND_NOT_VALID)]


@fault("abort-echoed-late", Defect.ABORT, "abort.not-answered", "run.outside-the-cases")
class EchoedLate(Server):
    """Sends every abort of the client back, behind the answer to its next request."""

    echo: tuple[Response, ...] = ()

    def on_abort(self, request: Abort) -> list[Response]:
        self.echo = (request,)
        return super().on_abort(request)

    def react(self, request: Request) -> list[Response]:
        responses = super().react(request)
        if not responses or isinstance(request, Abort):
            return responses
        echo, self.echo = self.echo, ()
        return [*responses, *echo]


@fault(
    "request-behind-abort-lost",
    Defect.ROBUSTNESS,
    "abort.request-behind",
    about=About.TIME,
    soft=True,
)
class RequestBehindAbortLost(OneByOne):
    """Needs 3 ms for an abort of the client, and loses what comes meanwhile."""

    def seconds_for(self, frame: CanFrame) -> float:
        return 0.003 if is_abort(frame.data) else 0.0

    def loses(self, frame: CanFrame) -> bool:
        """Have room for no request while it deals with an abort on the same channel."""
        busy = self.busy_until is not None
        return busy and frame.can_id == self.waiting[0].can_id != NMT_ID


class _OtherService(Server):
    """Has another code for what it does not serve."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        return super().refuse(request, self.code_of(request, code))

    def code_of(self, request: Request, code: AbortCode) -> AbortCode:
        """Return the code."""
        del request
        return code


@fault("missing-read-called-read-only", Defect.ABORT, "abort.other-service")
class MissingReadCalledReadOnly(_OtherService):
    """Refuses to read a missing object as one that cannot be written."""

    def code_of(self, request: Request, code: AbortCode) -> AbortCode:
        reads = isinstance(request, UploadInitiate) and code is AbortCode.OBJECT_MISSING
        return AbortCode.WRITE_OF_READ_ONLY if reads else code


@fault("missing-write-called-write-only", Defect.ABORT, "abort.other-service")
class MissingWriteCalledWriteOnly(_OtherService):
    """Refuses to write a missing object as one that cannot be read."""

    def code_of(self, request: Request, code: AbortCode) -> AbortCode:
        writes = isinstance(request, DownloadInitiate) and code is AbortCode.OBJECT_MISSING
        return AbortCode.READ_OF_WRITE_ONLY if writes else code


class _AccusesNowAndThen(Server):
    """Ends every eleventh of the transfers in segments by a code that calls the request wrong."""

    code = AbortCode.TOGGLE_NOT_ALTERNATED
    asked_for = 0

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        self.asked_for += 1
        if self.asked_for % 11 == 0:
            return self.refuse(request, self.code)
        return super().on_upload_segment(request)


@fault("right-toggle-refused-now-and-then", Defect.STATE, "segmented-upload.")
class RightToggleRefused(_AccusesNowAndThen):
    """Calls the toggle bit of every eleventh request for a segment wrong, and ends the upload."""


@fault("known-specifier-refused-now-and-then", Defect.STATE, "segmented-upload.")
class KnownSpecifierRefused(_AccusesNowAndThen):
    """Calls every eleventh request for a segment no valid command, and ends the upload."""

    code = AbortCode.COMMAND_NOT_VALID
