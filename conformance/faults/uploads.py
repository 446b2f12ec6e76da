"""Servers that are wrong in uploads: counts, flags, sizes, access."""

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Response,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.segmented_server import Download, Upload
from conformance.sdo.server import Server

COUNT = DefectClass.UNUSED_COUNT
WIDTH = DefectClass.FIELD_WIDTH
ACCESS = DefectClass.ACCESS_OR_SIZE


@fault("upload-n-is-count", COUNT, "upload.length")
class UnusedIsCount(Server):
    """States in n how many bytes count instead of how many do not."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Put the count into n."""
        if 1 <= len(data) <= 3:
            return UploadInitiateResponse(mux, True, True, len(data), data.ljust(4, b"\0"))
        return super().start_upload(mux, data)


@fault("upload-always-four-bytes", COUNT, "upload.length")
class AlwaysFourBytes(Server):
    """Answers every short upload with 43h."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Pad to 4 bytes."""
        return super().start_upload(mux, data.ljust(4, b"\0") if 1 <= len(data) < 4 else data)


@fault("upload-n-not-zero-for-segmented", COUNT, "segmented-upload.size")
class UnusedInSegmented(Server):
    """Leaves a count in n of the answer that announces segments."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Set n to 1."""
        response = super().start_upload(mux, data)
        if response.expedited:
            return response
        return UploadInitiateResponse(mux, False, True, 1, response.payload)


@fault("upload-big-endian", WIDTH, "segmented-upload.size")
class BigEndianSize(Server):
    """Writes the size of a segmented upload with its high byte first."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Turn the size round."""
        response = super().start_upload(mux, data)
        if response.expedited:
            return response
        return UploadInitiateResponse(mux, sized=True, payload=response.payload[::-1])


@fault("upload-size-8-bit", WIDTH, "segmented-upload.size[256]")
class SizeOf8Bits(Server):
    """Announces the size of a segmented upload modulo 256."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Cut the size."""
        response = super().start_upload(mux, data)
        if response.expedited:
            return response
        return UploadInitiateResponse.with_size(mux, len(data) & 0xFF)


class _Wrapping(Server):
    """Reads the bytes of an upload through an offset that wraps."""

    wrap = 0

    def next_upload_data(self, transfer: Upload) -> bytes:
        """Take the bytes from the wrapped offset."""
        length = min(7, len(transfer.data) - transfer.offset)
        places = range(transfer.offset, transfer.offset + length)
        return bytes(transfer.data[place % self.wrap] for place in places)


@fault("upload-offset-8-bit", WIDTH, "segmented-upload.size[257]")
class OffsetOf8Bits(_Wrapping):
    """Repeats the first bytes of an object after 256."""

    wrap = 256


@fault("upload-offset-wraps-at-889", WIDTH, "segmented-upload.size[890]")
class OffsetWrapsAt889(_Wrapping):
    """Repeats the first bytes of an object after 889, which is 127 segments."""

    wrap = 889


@fault("upload-offset-12-bit", WIDTH, "segmented-upload.size[4097]")
class OffsetOf12Bits(_Wrapping):
    """Repeats the first bytes of an object after 4096."""

    wrap = 4096


@fault("upload-multiplexer-missing", DefectClass.FRAME_SHAPE, "upload.")
class NoMultiplexer(Server):
    """Answers the uploads of records without the sub-index."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Put 0 for the sub-index."""
        return super().start_upload(Multiplexer(mux.index), data)


@fault("upload-leaks-in-unused-bytes", DefectClass.LEAK, "upload.filler", soft=True)
class LeaksInUnusedBytes(Server):
    """Leaves bytes of the answer before in the unused bytes of an expedited one."""

    last = bytes(4)

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Keep the buffer."""
        response = super().start_upload(mux, data)
        if response.expedited:
            self.last = data + self.last[len(data) :]
            return UploadInitiateResponse(mux, True, True, 4 - len(data), self.last)
        return response


class _Segments(Server):
    """Changes segments before they are sent."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Pass each segment through ``change``."""
        transfer = self.transfer
        responses = super().on_upload_segment(request)
        return [
            self.change(transfer, response)
            if isinstance(response, UploadSegmentResponse) and isinstance(transfer, Upload)
            else response
            for response in responses
        ]

    def change(
        self,
        transfer: Upload,
        segment: UploadSegmentResponse,
    ) -> UploadSegmentResponse:
        """Return what is sent instead."""
        return segment


@fault("upload-segment-leaks", DefectClass.LEAK, "segmented-upload.filler", soft=True)
class LeaksInSegment(_Segments):
    """Fills the unused bytes of the last segment with the bytes of the one before."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        """Fill up from the data before."""
        if not segment.unused:
            return segment
        payload = segment.data + transfer.data[: segment.unused].ljust(segment.unused, b"#")
        return UploadSegmentResponse(payload, segment.toggle, segment.unused, segment.last)


@fault("upload-last-flag-missing-when-full", DefectClass.LAST_FLAG, "segmented-upload.size[7]")
class LastFlagMissing(_Segments):
    """Does not mark the last segment when it is full."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        """Take the mark away; the transfer is over all the same."""
        if segment.last and not segment.unused:
            return UploadSegmentResponse(segment.payload, segment.toggle)
        return segment


@fault("upload-last-flag-early", DefectClass.LAST_FLAG, "segmented-upload.size[8]")
class LastFlagEarly(_Segments):
    """Marks the last full segment as the last though some bytes remain."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        """Set the mark one segment early."""
        last = 0 < len(transfer.data) - transfer.offset < 7
        return UploadSegmentResponse(
            segment.payload, segment.toggle, segment.unused, segment.last or last
        )


@fault("upload-last-segment-n-off-by-one", COUNT, "segmented-upload.size[8]")
class UnusedOffByOne(_Segments):
    """States one byte too few as unused in a last segment that is not full."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        """Lower n."""
        unused = max(segment.unused - 1, 0)
        return UploadSegmentResponse(segment.payload, segment.toggle, unused, segment.last)


@fault("upload-n-7-when-full", COUNT, "segmented-upload.size[14]")
class UnusedSevenWhenFull(_Segments):
    """States 7 unused bytes in a last segment that is full."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        """Compute n modulo 7, wrongly."""
        unused = 7 if segment.last and not segment.unused else segment.unused
        return UploadSegmentResponse(segment.payload, segment.toggle, unused, segment.last)


@fault("upload-toggle-not-answered", DefectClass.STATE, "segmented-upload.size")
class ToggleNotAnswered(_Segments):
    """Sends every segment with t = 0."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        """Clear the toggle bit."""
        return UploadSegmentResponse(segment.payload, 0, segment.unused, segment.last)


@fault("upload-drops-last-byte", WIDTH, "segmented-upload.size[22]")
class DropsLastByte(Server):
    """Leaves out the last byte of an upload in segments."""

    def value_to_read(self, entry: Entry) -> bytes:
        """Cut long values."""
        return entry.value[:-1] if len(entry.value) > 4 else entry.value


@fault("upload-toggle-ignored", DefectClass.STATE, "segmented-upload.toggle")
class ToggleIgnored(Server):
    """Takes segment requests whatever their toggle bit."""

    def check_toggle(self, transfer: Download | Upload, toggle: int) -> None:
        """Check it in downloads only."""
        if isinstance(transfer, Download):
            super().check_toggle(transfer, toggle)


@fault("upload-toggle-not-reset", DefectClass.LEAK, "segmented-upload.toggle-afterwards[1]")
class ToggleNotReset(Server):
    """Expects the toggle bit of an aborted upload to go on in the next one."""

    due = 0

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Start with what was due."""
        response = super().start_upload(mux, data)
        if isinstance(self.transfer, Upload):
            self.transfer.toggle = self.due
        return response

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Remember what is due; a whole transfer resets it."""
        responses = super().on_upload_segment(request)
        self.due = self.transfer.toggle if isinstance(self.transfer, Upload) else 0
        return responses


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


@fault("upload-empty-hangs", DefectClass.ZERO_LENGTH, "segmented-upload.empty")
class EmptyHangs(Server):
    """Announces an empty object and never answers the segment request."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Find nothing to send."""
        if isinstance(self.transfer, Upload) and not self.transfer.data:
            return []
        return super().on_upload_segment(request)


@fault("request-reserved-bits-silent", DefectClass.ROBUSTNESS, "upload.request-reserved-bits")
class ReservedBitsSilent(Server):
    """Does not answer an upload request with reserved bits set."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Ignore what is not exactly 40h."""
        return [] if request.reserved_bits else super().on_upload_initiate(request)


@fault("request-reserved-bytes-silent", DefectClass.ROBUSTNESS, "upload.request-reserved-bytes")
class ReservedBytesSilent(Server):
    """Does not answer an upload request with reserved bytes that are not 0."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Ignore what carries anything behind the multiplexer."""
        return [] if any(request.reserved) else super().on_upload_initiate(request)


@fault(
    "segment-request-reserved-silent", DefectClass.ROBUSTNESS, "segmented-upload.request-reserved"
)
class SegmentReservedSilent(Server):
    """Does not answer a segment request with anything in its reserved bits or bytes."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Ignore what is not exactly 60h or 70h and 0."""
        if request.reserved_bits or any(request.reserved):
            return []
        return super().on_upload_segment(request)
