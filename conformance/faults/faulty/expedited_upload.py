"""Servers that are wrong in expedited uploads: counts, access, missing objects, standard ones."""

from dataclasses import replace

from conformance.faults.registry import Defect, fault
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Refusal

DROPPED = 3
# Requests that are answered before the device is gone: it dies while it is got to know.
ANSWERED = 12


@fault("response-short-dlc", Defect.FRAME_SHAPE, "frame.abort-identifier")
class ShortResponses(Node):
    """Leaves away the bytes behind the last one that is not 0."""

    def respond(self, data: bytes) -> CanFrame:
        return CanFrame(self.response_id, data[:4] + data[4:].rstrip(b"\0"))


@fault("response-extended", Defect.FRAME_SHAPE, "upload.device-type")
class ExtendedResponses(Node):
    """Answers with a 29-bit identifier."""

    def respond(self, data: bytes) -> CanFrame:
        return CanFrame(self.response_id, data, extended=True)


@fault("upload-n-is-count", Defect.UNUSED_COUNT, "upload.length")
class UnusedIsCount(Server):
    """States in n how many bytes count instead of how many do not."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        if 1 <= len(data) <= 3:
            return UploadInitiateResponse(mux, True, True, len(data), data.ljust(4, b"\0"))
        return super().start_upload(mux, data)


@fault("upload-always-four-bytes", Defect.UNUSED_COUNT, "upload.length")
class AlwaysFourBytes(Server):
    """Answers every short upload with 43h."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        return super().start_upload(mux, data.ljust(4, b"\0") if 1 <= len(data) < 4 else data)


@fault(
    "upload-reserved-bit",
    Defect.FRAME_SHAPE,
    "upload.reserved",
    "segmented-upload.reserved",
    "run.reserved",
)
class ReservedBit(Server):
    """Sets the reserved bit of each answer to an upload initiate."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        return [
            replace(response, reserved_bits=1)
            if isinstance(response, UploadInitiateResponse)
            else response
            for response in super().on_upload_initiate(request)
        ]


@fault("upload-multiplexer-missing", Defect.FRAME_SHAPE, "upload.")
class NoMultiplexer(Server):
    """Answers the uploads of records without the sub-index."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        return super().start_upload(Multiplexer(mux.index), data)


@fault("upload-leaks-in-unused-bytes", Defect.LEAK, "upload.filler", "run.filler", soft=True)
class LeaksInUnusedBytes(Server):
    """Leaves bytes of the answer before in the unused bytes of an expedited one."""

    last = bytes(4)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        if response.expedited:
            self.last = data + self.last[len(data) :]
            return UploadInitiateResponse(mux, True, True, 4 - len(data), self.last)
        return response


@fault("request-reserved-bits-silent", Defect.ROBUSTNESS, "upload.request-reserved-bits")
class ReservedBitsSilent(Server):
    """Does not answer an upload request with reserved bits set."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        return [] if request.reserved_bits else super().on_upload_initiate(request)


@fault("request-reserved-bytes-silent", Defect.ROBUSTNESS, "upload.request-reserved-bytes")
class ReservedBytesSilent(Server):
    """Does not answer an upload request with reserved bytes that are not 0."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        return [] if any(request.reserved) else super().on_upload_initiate(request)


@fault("reads-write-only", Defect.ACCESS_OR_SIZE, "upload.write-only")
class ReadsWriteOnly(Server):
    """Serves the upload of a write-only object."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        self.transfer = None
        return [self.start_upload(request.mux, self.objects.find(request.mux).value)]


@fault("access-codes-swapped", Defect.ACCESS_OR_SIZE, "upload.write-only")
class AccessCodesSwapped(Server):
    """Says read-only for write-only and the other way round."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        try:
            return super().on_upload_initiate(request)
        except Refusal as refusal:
            if refusal.code is AbortCode.READ_OF_WRITE_ONLY:
                raise Refusal(AbortCode.WRITE_OF_READ_ONLY) from refusal
            raise


class _Lookup(Server):
    """Changes why an upload is refused."""

    codes: dict[AbortCode, AbortCode] = {}

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        try:
            return super().on_upload_initiate(request)
        except Refusal as refusal:
            raise Refusal(self.codes.get(refusal.code, refusal.code)) from refusal


@fault("missing-object-as-sub-index", Defect.ACCESS_OR_SIZE, "upload.object-missing")
class MissingObjectAsSubIndex(_Lookup):
    """Reports a missing object as a missing sub-index."""

    codes = {AbortCode.OBJECT_MISSING: AbortCode.SUB_INDEX_MISSING}


@fault("missing-sub-index-as-object", Defect.ACCESS_OR_SIZE, "upload.sub-index-missing")
class MissingSubIndexAsObject(_Lookup):
    """Reports a missing sub-index as a missing object."""

    codes = {AbortCode.SUB_INDEX_MISSING: AbortCode.OBJECT_MISSING}


@fault("sub-index-of-variable-served", Defect.ACCESS_OR_SIZE, "upload.sub-index-of-variable")
class SubIndexOfVariableServed(Server):
    """Reads any sub-index of a variable as the variable."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        try:
            return super().on_upload_initiate(request)
        except Refusal as refusal:
            if refusal.code is not AbortCode.SUB_INDEX_MISSING or request.mux.index == 0x1018:
                raise
            entry = self.objects.readable(Multiplexer(request.mux.index))
            return [self.start_upload(request.mux, entry.value)]


@fault("sub-index-wraps", Defect.ACCESS_OR_SIZE, "upload.sub-index-missing")
class SubIndexWraps(Server):
    """Looks at the low bits of the sub-index of a record only."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        if request.mux.index == 0x1018:
            entry = self.objects.readable(Multiplexer(0x1018, request.mux.sub_index & 3))
            return [self.start_upload(request.mux, entry.value)]
        return super().on_upload_initiate(request)


@fault("missing-object-reads-zero", Defect.ACCESS_OR_SIZE, "upload.object-missing")
class MissingObjectReadsZero(Server):
    """Serves objects that do not exist, with 0."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        try:
            return super().on_upload_initiate(request)
        except Refusal as refusal:
            if refusal.code is not AbortCode.OBJECT_MISSING:
                raise
            return [self.start_upload(request.mux, bytes(4))]


@fault("device-type-two-bytes", Defect.ACCESS_OR_SIZE, "upload.device-type")
class DeviceTypeOfTwoBytes(Server):
    """Has a device type of 16 bits."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        return super().start_upload(mux, data[:2] if mux.index == 0x1000 else data)


@fault("identity-count-wrong", Defect.ACCESS_OR_SIZE, "upload.identity")
class IdentityCountWrong(Server):
    """Counts no entries in 1018h:00."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        return super().start_upload(mux, b"\0" if mux == Multiplexer(0x1018, 0) else data)


@fault("second-request-mixed-up", Defect.BACK_TO_BACK, "upload.behind-another")
class SecondMixedUp(Server):
    """Answers a read of 1018h:01 right behind one of 1018h:00 with the data of the first."""

    before: UploadInitiate | None = None

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        before, self.before = self.before, request
        responses = super().on_upload_initiate(request)
        mixed = before is not None and before.mux == Multiplexer(0x1018, 0)
        if mixed and request.mux == Multiplexer(0x1018, 1):
            return [UploadInitiateResponse.with_data(request.mux, b"\x04\x04\x04\x04")]
        return responses


@fault("refusal-spoils-next-read", Defect.LEAK, "upload.refused-is-over")
class RefusalSpoilsNext(Server):
    """Reads 1018h:01 as the code of a refusal right before it."""

    spoiled: AbortCode | None = None

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        self.spoiled = code
        return super().refuse(request, code)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        spoiled, self.spoiled = self.spoiled, None
        if spoiled is not None and mux == Multiplexer(0x1018, 1):
            data = int(spoiled).to_bytes(4, "little")
        return super().start_upload(mux, data)


class Twice(Server):
    """Sends something behind an abort."""

    request_kind: type[UploadInitiate] | type[DownloadInitiate] = UploadInitiate

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        responses = super().refuse(request, code)
        if isinstance(request, self.request_kind):
            responses.append(self.second(request.mux))
        return responses

    def second(self, mux: Multiplexer) -> Response:
        """Return the frame too many."""
        return Abort(mux, AbortCode.GENERAL_ERROR)


@fault("refused-upload-aborted-twice", Defect.ABORT, "upload.refused-once")
class UploadAbortedTwice(Twice):
    """Sends a second abort behind that of a refused upload."""


@fault("third-request-unanswered", Defect.ROBUSTNESS, "upload.")
class ThirdUnanswered(Node):
    """Does not answer every third request."""

    count = 0

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if self.state.serves_sdo and self.is_addressed(frame):
            self.count += 1
            if self.count % DROPPED == 0:
                return []
        return super().receive(frame)


@fault("dies-at-once", Defect.ROBUSTNESS, "upload.")
class DiesAtOnce(Node):
    """Does not answer any more after the first twelve requests."""

    left = ANSWERED

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if self.is_addressed(frame):
            self.left -= 1
        return super().receive(frame) if self.left >= 0 else []
