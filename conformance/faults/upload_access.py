"""Servers that are wrong about what can be read: access, missing objects, standard ones."""

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import Response, UploadInitiate, UploadInitiateResponse
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Refusal
from conformance.sdo.server import Server

ACCESS = DefectClass.ACCESS_OR_SIZE


@fault("reads-write-only", ACCESS, "upload.write-only")
class ReadsWriteOnly(Server):
    """Serves the upload of a write-only object."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Find the entry without asking for its access."""
        self.transfer = None
        return [self.start_upload(request.mux, self.objects.find(request.mux).value)]


@fault("access-codes-swapped", ACCESS, "upload.write-only")
class AccessCodesSwapped(Server):
    """Says read-only for write-only and the other way round."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Swap the code of uploads."""
        try:
            return super().on_upload_initiate(request)
        except Refusal as refusal:
            if refusal.code is AbortCode.READ_OF_WRITE_ONLY:
                raise Refusal(AbortCode.WRITE_OF_READ_ONLY) from refusal
            raise


class _Lookup(Server):
    """Changes why an upload is refused."""

    codes: dict[AbortCode, AbortCode] = {}  # noqa: RUF012 - subclasses replace it

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Replace the code."""
        try:
            return super().on_upload_initiate(request)
        except Refusal as refusal:
            raise Refusal(self.codes.get(refusal.code, refusal.code)) from refusal


@fault("missing-object-as-sub-index", ACCESS, "upload.object-missing")
class MissingObjectAsSubIndex(_Lookup):
    """Reports a missing object as a missing sub-index."""

    codes = {AbortCode.OBJECT_MISSING: AbortCode.SUB_INDEX_MISSING}  # noqa: RUF012


@fault("missing-sub-index-as-object", ACCESS, "upload.sub-index-missing")
class MissingSubIndexAsObject(_Lookup):
    """Reports a missing sub-index as a missing object."""

    codes = {AbortCode.SUB_INDEX_MISSING: AbortCode.OBJECT_MISSING}  # noqa: RUF012


@fault("sub-index-of-variable-served", ACCESS, "upload.sub-index-of-variable")
class SubIndexOfVariableServed(Server):
    """Reads any sub-index of a variable as the variable."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Fall back to sub-index 0, except for the identity."""
        try:
            return super().on_upload_initiate(request)
        except Refusal as refusal:
            if refusal.code is not AbortCode.SUB_INDEX_MISSING or request.mux.index == 0x1018:
                raise
            entry = self.objects.readable(Multiplexer(request.mux.index))
            return [self.start_upload(request.mux, entry.value)]


@fault("sub-index-wraps", ACCESS, "upload.sub-index-missing")
class SubIndexWraps(Server):
    """Looks at the low bits of the sub-index of a record only."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Mask the sub-index of 1018h."""
        if request.mux.index == 0x1018:
            entry = self.objects.readable(Multiplexer(0x1018, request.mux.sub_index & 3))
            return [self.start_upload(request.mux, entry.value)]
        return super().on_upload_initiate(request)


@fault("missing-object-reads-zero", ACCESS, "upload.object-missing")
class MissingObjectReadsZero(Server):
    """Serves objects that do not exist, with 0."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Make up a value."""
        try:
            return super().on_upload_initiate(request)
        except Refusal as refusal:
            if refusal.code is not AbortCode.OBJECT_MISSING:
                raise
            return [self.start_upload(request.mux, bytes(4))]


@fault("device-type-two-bytes", ACCESS, "upload.device-type")
class DeviceTypeOfTwoBytes(Server):
    """Has a device type of 16 bits."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Cut the device type."""
        return super().start_upload(mux, data[:2] if mux.index == 0x1000 else data)


@fault("identity-count-wrong", ACCESS, "upload.identity")
class IdentityCountWrong(Server):
    """Counts no entries in 1018h:00."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Say 0."""
        return super().start_upload(mux, b"\0" if mux == Multiplexer(0x1018, 0) else data)
