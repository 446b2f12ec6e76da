"""Servers that abort with other codes or in the name of other objects, as they may."""

from conformance.faults.registry import unusual
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import Abort, DownloadInitiate, Request, Response, UploadInitiate
from conformance.sdo.layout import Multiplexer


class OtherCodes(Server):
    """Aborts with other codes."""

    codes: dict[AbortCode, AbortCode] = {}

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        return super().refuse(request, self.codes.get(code, code))


@unusual("generic-length-code")
class GenericLength(OtherCodes):
    """Says "length does not match" for too long and for too short."""

    codes = {
        AbortCode.LENGTH_TOO_HIGH: AbortCode.LENGTH_MISMATCH,
        AbortCode.LENGTH_TOO_LOW: AbortCode.LENGTH_MISMATCH,
    }


@unusual("generic-access-code")
class GenericAccess(OtherCodes):
    """Says "unsupported access" for read-only and for write-only."""

    codes = {
        AbortCode.READ_OF_WRITE_ONLY: AbortCode.UNSUPPORTED_ACCESS,
        AbortCode.WRITE_OF_READ_ONLY: AbortCode.UNSUPPORTED_ACCESS,
    }


@unusual("general-error-everywhere", soft=True)
class GeneralError(OtherCodes):
    """Aborts with "general error", but for toggle errors."""

    codes = {
        code: AbortCode.GENERAL_ERROR
        for code in AbortCode
        if code is not AbortCode.TOGGLE_NOT_ALTERNATED
    }


@unusual("stale-multiplexer-of-unknown-specifier")
class StaleMultiplexer(Server):
    """Puts the last object into the abort of a frame that names none."""

    last = Multiplexer(0)

    def refused_multiplexer(self, request: Request) -> Multiplexer:
        if self.transfer is None and getattr(request, "mux", None) is None:
            return self.last
        return super().refused_multiplexer(request)

    def react(self, request: Request) -> list[Response]:
        if isinstance(request, UploadInitiate | DownloadInitiate):
            self.last = request.mux
        return super().react(request)


@unusual("foreign-abort-ignored")
class ForeignAbortIgnored(Server):
    """Ignores an abort that names another object than the running transfer, or reserved bits."""

    def on_abort(self, request: Abort) -> list[Response]:
        if self.transfer and (request.mux != self.transfer.mux or request.reserved_bits):
            return []
        return super().on_abort(request)
