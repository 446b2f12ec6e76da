"""Servers that are unusual and right: what CiA 301 leaves open, taken the other way."""

from conformance.faults.length_variants import SmallBuffer
from conformance.faults.registry import variant
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    DownloadSegment,
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.node import Node
from conformance.sdo.objects import DataType, Entry, Refusal
from conformance.sdo.segmented_server import Download, Upload
from conformance.sdo.server import Server


@variant("short-uploads-in-segments")
class ShortInSegments(Server):
    """Sends everything in segments, also 1 to 4 bytes."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Never answer expedited."""
        self.transfer = Upload(mux, data)
        return UploadInitiateResponse.with_size(mux, len(data))


@variant("upload-size-not-indicated")
class UnsizedUploads(Server):
    """Never says how long a segmented upload is (40h)."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Leave the size out."""
        response = super().start_upload(mux, data)
        return response if response.expedited else UploadInitiateResponse.with_size(mux, None)


@variant("expedited-upload-not-counted")
class UncountedUploads(Server):
    """Answers numbers with 42h: their type says how many of the 4 bytes count."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Leave the count out for what is no text."""
        response = super().start_upload(mux, data)
        if response.expedited and self.objects.find(mux).data_type.length is not None:
            return UploadInitiateResponse.with_uncounted_data(mux, data)
        return response


@variant("short-upload-segments")
class ShortSegments(Server):
    """Sends segments of 5 bytes."""

    def next_upload_data(self, transfer: Upload) -> bytes:
        """Take fewer bytes."""
        return super().next_upload_data(transfer)[:5]


@variant("empty-last-upload-segment")
class EmptyLastSegment(Server):
    """Ends every upload with a segment without data."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Send the mark by itself."""
        transfer = self.transfer
        responses = super().on_upload_segment(request)
        segment = responses[0]
        if not isinstance(transfer, Upload) or not isinstance(segment, UploadSegmentResponse):
            return responses
        if segment.last and segment.data:
            self.transfer = transfer
            return [UploadSegmentResponse(segment.payload, segment.toggle, segment.unused)]
        return responses


@variant("download-toggle-error-ignored")
class ToggleErrorIgnored(Server):
    """Ignores a download segment whose toggle bit did not alternate, and goes on."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Keep silent."""
        if isinstance(self.transfer, Download) and request.toggle != self.transfer.toggle:
            return []
        return super().on_download_segment(request)


@variant("new-initiate-refused", soft=True)
class NewInitiateRefused(Server):
    """Refuses an initiate in the middle of a transfer, which ends."""

    def react(self, request: Request) -> list[Response]:
        """Refuse it with the multiplexer of the running transfer."""
        initiate = isinstance(request, UploadInitiate | DownloadInitiate)
        if initiate and self.transfer is not None:
            mux = self.transfer.mux
            self.transfer = None
            return [Abort(mux, AbortCode.COMMAND_NOT_VALID)]
        return super().react(request)


@variant("silent-when-idle")
class SilentWhenIdle(Server):
    """Keeps silent about frames that belong to a transfer when there is none."""

    def react(self, request: Request) -> list[Response]:
        """Ignore all but initiates and unknown specifiers."""
        if self.transfer is None and isinstance(request, DownloadSegment | UploadSegment):
            return []
        return super().react(request)


@variant("strict-about-reserved-bits")
class StrictAboutBits(Server):
    """Refuses requests with reserved bits set, or with n where it has no meaning."""

    def react(self, request: Request) -> list[Response]:
        """Look at what most servers ignore."""
        bits = getattr(request, "reserved_bits", 0)
        meaningless = (
            isinstance(request, DownloadInitiate)
            and request.unused
            and not (request.expedited and request.sized)
        )
        if bits or meaningless:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().react(request)


@variant("strict-about-reserved-bytes", soft=True)
class StrictAboutBytes(Server):
    """Refuses upload requests with reserved bytes that are not 0."""

    def react(self, request: Request) -> list[Response]:
        """Look at what most servers ignore."""
        if isinstance(request, UploadInitiate | UploadSegment) and any(request.reserved):
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().react(request)


@variant("sizes-checked-at-the-end")
class SizesCheckedLate(Server):
    """Takes any announced size and looks at it with the last segment only."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Look later."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        """Take everything for now."""
        if len(request.data) > transfer.room and request.last and request.unused == 0:
            return super().segment_data(transfer, request)
        return request.data

    def finish_download(self, transfer: Download) -> None:
        """Look now."""
        if transfer.size is not None and len(transfer.data) > transfer.size:
            raise Refusal(AbortCode.LENGTH_TOO_HIGH)
        super().finish_download(transfer)


@variant("access-checked-at-the-end")
class AccessCheckedLate(Server):
    """Confirms a segmented download and refuses a read-only object with the last segment."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        """Look later at segmented ones."""
        if request.expedited:
            return super().entry_to_write(request)
        return self.objects.find(request.mux)

    def finish_download(self, transfer: Download) -> None:
        """Look now."""
        self.objects.writable(transfer.mux)
        super().finish_download(transfer)


class _Codes(Server):
    """Aborts with other codes."""

    codes: dict[AbortCode, AbortCode] = {}  # noqa: RUF012 - subclasses replace it

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Replace the code."""
        return super().refuse(request, self.codes.get(code, code))


@variant("generic-length-code")
class GenericLength(_Codes):
    """Says "length does not match" for too long and for too short."""

    codes = {  # noqa: RUF012
        AbortCode.LENGTH_TOO_HIGH: AbortCode.LENGTH_MISMATCH,
        AbortCode.LENGTH_TOO_LOW: AbortCode.LENGTH_MISMATCH,
    }


@variant("generic-access-code")
class GenericAccess(_Codes):
    """Says "unsupported access" for read-only and for write-only."""

    codes = {  # noqa: RUF012
        AbortCode.READ_OF_WRITE_ONLY: AbortCode.UNSUPPORTED_ACCESS,
        AbortCode.WRITE_OF_READ_ONLY: AbortCode.UNSUPPORTED_ACCESS,
    }


@variant("general-error-everywhere", soft=True)
class GeneralError(_Codes):
    """Aborts with "general error", but for toggle errors."""

    codes = {  # noqa: RUF012
        code: AbortCode.GENERAL_ERROR
        for code in AbortCode
        if code is not AbortCode.TOGGLE_NOT_ALTERNATED
    }


@variant("stale-multiplexer-of-unknown-specifier")
class StaleMultiplexer(Server):
    """Puts the last object into the abort of a frame that names none."""

    last = Multiplexer(0)

    def refused_multiplexer(self, request: Request) -> Multiplexer:
        """Use the last one for what is no initiate, when idle."""
        if self.transfer is None and getattr(request, "mux", None) is None:
            return self.last
        return super().refused_multiplexer(request)

    def react(self, request: Request) -> list[Response]:
        """Remember the object."""
        if isinstance(request, UploadInitiate | DownloadInitiate):
            self.last = request.mux
        return super().react(request)


@variant("foreign-abort-ignored")
class ForeignAbortIgnored(Server):
    """Ignores an abort that names another object than the running transfer, or reserved bits."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Look at the multiplexer."""
        if self.transfer and (request.mux != self.transfer.mux or request.reserved_bits):
            return []
        return super().on_abort(request)


@variant("text-ends-in-zero")
class TextEndsInZero(Server):
    """Sends a text with a 00h behind it, which is part of its size."""

    def value_to_read(self, entry: Entry) -> bytes:
        """Append it."""
        ends = entry.data_type is DataType.VISIBLE_STRING
        return entry.value + b"\0" if ends else entry.value


@variant("no-empty-values")
class NoEmptyValues(Server):
    """Refuses to store a value without data."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Insist on a byte."""
        if size == 0:
            raise Refusal(AbortCode.LENGTH_TOO_LOW)
        super().check_announced_size(entry, size)


@variant("empty-value-not-read")
class EmptyNotRead(Server):
    """Refuses to read a value without data."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Say that there is none."""
        if not data:
            raise Refusal(AbortCode.NO_DATA)
        return super().start_upload(mux, data)


@variant("22h-refused-for-short-numbers")
class UncountedShortRefused(Server):
    """Refuses an expedited download without a count to fewer than 4 bytes."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        """Insist on the count."""
        if not request.sized and entry.longest < 4:
            raise Refusal(AbortCode.LENGTH_MISMATCH)
        return super().expedited_data(request, entry)


@variant("n-of-last-segment-binding")
class UnusedBinding(Server):
    """Takes n = 0 in a last segment for 7 bytes, and refuses them as too many."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        """Do not cut."""
        if len(request.data) > transfer.room:
            raise Refusal(AbortCode.LENGTH_TOO_HIGH)
        return request.data


@variant("strings-of-300-bytes-out-of-memory")
class StringsOf300(SmallBuffer, _Codes):
    """Has room for 300 bytes in strings and domains, and calls more out of memory."""

    capacity = 300
    codes = {AbortCode.LENGTH_TOO_HIGH: AbortCode.OUT_OF_MEMORY}  # noqa: RUF012

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Call a large download out of memory, and only that."""
        if isinstance(request, DownloadInitiate) and (request.size or 0) > self.capacity:
            entry = self.objects.find(request.mux) if code is AbortCode.LENGTH_TOO_HIGH else None
            if entry and entry.data_type.length is None:
                return super().refuse(request, code)
        return Server.refuse(self, request, code)


@variant("short-frames-served")
class ShortFramesServed(Node):
    """Serves a request of fewer than 8 bytes that holds all it needs."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Fill up upload initiates and downloads that hold their data."""
        command = frame.data[:1]
        upload = command == b"\x40" and frame.dlc >= 4
        download = command in (b"\x2f", b"\x2b", b"\x27", b"\x23") and (
            frame.dlc >= 8 - ((command[0] >> 2) & 3)
        )
        if self.is_addressed(frame) and (upload or download):
            frame = CanFrame(frame.can_id, frame.data.ljust(FRAME_LENGTH, b"\0"))
        return super().receive(frame)


@variant("short-frames-refused")
class ShortFramesRefused(Server):
    """Answers a frame of fewer than 8 bytes with an abort."""

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        """Refuse it, unless it may be an abort."""
        if frame[:1] >= b"\x80":
            return []
        self.transfer = None
        return [Abort(Multiplexer(0), AbortCode.LENGTH_MISMATCH).encode()]
