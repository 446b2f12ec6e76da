"""Servers that are wrong in the segments of an upload: sizes, data, counts, flags, toggle bits."""

from conformance.faults.registry import About, Defect, fault
from conformance.reference.segmented_server import Download, Upload
from conformance.reference.server import Server
from conformance.sdo.frames import (
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH, SEGMENT_LENGTH
from conformance.sdo.objects import Entry

ENDLESS_AT = 4097
LARGEST_SIZE = 0xFFFF_FFFF


@fault("upload-n-not-zero-for-segmented", Defect.UNUSED_COUNT, "segmented-upload.size")
class UnusedInSegmented(Server):
    """Leaves a count in n of the answer that announces segments."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        if response.expedited:
            return response
        return UploadInitiateResponse(mux, False, True, 1, response.payload)


@fault("upload-big-endian", Defect.FIELD_WIDTH, "segmented-upload.size")
class BigEndianSize(Server):
    """Writes the size of a segmented upload with its high byte first."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        if response.expedited:
            return response
        return UploadInitiateResponse(mux, sized=True, payload=response.payload[::-1])


@fault("upload-size-8-bit", Defect.FIELD_WIDTH, "segmented-upload.size[257]")
class SizeOf8Bits(Server):
    """Announces the size of a segmented upload modulo 256."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
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


@fault("upload-offset-8-bit", Defect.FIELD_WIDTH, "segmented-upload.size[257]")
class OffsetOf8Bits(_Wrapping):
    """Repeats the first bytes of an object after 256."""

    wrap = 256


@fault("upload-offset-wraps-at-889", Defect.FIELD_WIDTH, "segmented-upload.size[890]")
class OffsetWrapsAt889(_Wrapping):
    """Repeats the first bytes of an object after 889, which is 127 segments."""

    wrap = 889


@fault("upload-offset-12-bit", Defect.FIELD_WIDTH, "segmented-upload.size[4097]")
class OffsetOf12Bits(_Wrapping):
    """Repeats the first bytes of an object after 4096."""

    wrap = 4096


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


@fault("upload-segment-leaks", Defect.LEAK, "segmented-upload.filler", soft=True)
class LeaksInSegment(_Segments):
    """Fills the unused bytes of the last segment with the bytes of the one before."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        if not segment.unused:
            return segment
        payload = segment.data + transfer.data[: segment.unused].ljust(segment.unused, b"#")
        return UploadSegmentResponse(payload, segment.toggle, segment.unused, segment.last)


@fault("upload-last-flag-missing-when-full", Defect.LAST_FLAG, "segmented-upload.size[7]")
class LastFlagMissing(_Segments):
    """Does not mark the last segment when it is full."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        """Take the mark away; the transfer is over all the same."""
        if segment.last and not segment.unused:
            return UploadSegmentResponse(segment.payload, segment.toggle)
        return segment


@fault("upload-last-flag-early", Defect.LAST_FLAG, "segmented-upload.size[8]")
class LastFlagEarly(_Segments):
    """Marks the last full segment as the last though some bytes remain."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        last = 0 < len(transfer.data) - transfer.offset < 7
        return UploadSegmentResponse(
            segment.payload, segment.toggle, segment.unused, segment.last or last
        )


@fault(
    "upload-last-segment-n-off-by-one",
    Defect.UNUSED_COUNT,
    "segmented-upload.size[8]",
    "upload.known-objects",
)
class UnusedOffByOne(_Segments):
    """States one byte too few as unused in a last segment that is not full."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        unused = max(segment.unused - 1, 0)
        return UploadSegmentResponse(segment.payload, segment.toggle, unused, segment.last)


@fault("upload-n-7-when-full", Defect.UNUSED_COUNT, "segmented-upload.size[14]")
class UnusedSevenWhenFull(_Segments):
    """States 7 unused bytes in a last segment that is full."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        unused = 7 if segment.last and not segment.unused else segment.unused
        return UploadSegmentResponse(segment.payload, segment.toggle, unused, segment.last)


@fault("upload-toggle-not-answered", Defect.STATE, "segmented-upload.size")
class ToggleNotAnswered(_Segments):
    """Sends every segment with t = 0."""

    def change(self, transfer: Upload, segment: UploadSegmentResponse) -> UploadSegmentResponse:
        return UploadSegmentResponse(segment.payload, 0, segment.unused, segment.last)


@fault(
    "upload-drops-last-byte",
    Defect.FIELD_WIDTH,
    "segmented-upload.size[22]",
    "random.segmented-transfers",
)
class DropsLastByte(Server):
    """Leaves out the last byte of an upload in segments."""

    def value_to_read(self, entry: Entry) -> bytes:
        return entry.value[:-1] if len(entry.value) > 4 else entry.value


@fault(
    "upload-toggle-ignored",
    Defect.STATE,
    "segmented-upload.toggle",
    "segmented-upload.toggle-first",
    "segmented-upload.toggle-repeated",
)
class ToggleIgnored(Server):
    """Takes segment requests whatever their toggle bit."""

    def check_toggle(self, transfer: Download | Upload, toggle: int) -> None:
        if isinstance(transfer, Download):
            super().check_toggle(transfer, toggle)


@fault(
    "upload-toggle-not-reset",
    Defect.LEAK,
    "segmented-upload.toggle-afterwards[segmented-upload-middle]",
    "random.interrupted",
)
class ToggleNotReset(Server):
    """Expects the toggle bit of an aborted upload to go on in the next one."""

    due = 0

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        if isinstance(self.transfer, Upload):
            self.transfer.toggle = self.due
        return response

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Remember what is due; a whole transfer resets it."""
        responses = super().on_upload_segment(request)
        self.due = self.transfer.toggle if isinstance(self.transfer, Upload) else 0
        return responses


@fault("upload-empty-hangs", Defect.ZERO_LENGTH, "segmented-upload.empty")
class EmptyHangs(Server):
    """Announces an empty object and never answers the segment request."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        if isinstance(self.transfer, Upload) and not self.transfer.data:
            return []
        return super().on_upload_segment(request)


@fault(
    "segment-request-reserved-silent",
    Defect.ROBUSTNESS,
    "segmented-upload.request-reserved",
    "segmented-upload.request-reserved-bits",
    "segmented-upload.request-reserved-bytes",
)
class SegmentReservedSilent(Server):
    """Does not answer a segment request with anything in its reserved bits or bytes."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Ignore what is not exactly 60h or 70h and 0."""
        if request.reserved_bits or any(request.reserved):
            return []
        return super().on_upload_segment(request)


@fault("upload-empty-as-4-bytes", Defect.ZERO_LENGTH, "segmented-upload.empty")
class EmptyAs4Bytes(Server):
    """Answers the upload of an empty object by 53h: 4 bytes 0, and n spilled into bit 4."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        if data:
            return super().start_upload(mux, data)
        return UploadInitiateResponse(mux, True, True, 0, bytes(4), 1)


@fault("second-segmented-upload-empty", Defect.LEAK, "segmented-upload.again")
class SecondUploadWrong(Server):
    """Delivers zeros in the second of two segmented uploads of one object."""

    last: Multiplexer | None = None

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        again = mux == self.last and len(data) > 7
        self.last = mux
        return super().start_upload(mux, bytes(len(data)) if again else data)

    def react(self, request: Request) -> list[Response]:
        """Forget the last object when anything but an upload comes."""
        if not isinstance(request, UploadInitiate | UploadSegment):
            self.last = None
        return super().react(request)


@fault("constant-text-consumed", Defect.LEAK, "segmented-upload.read-only-text")
class ConstantConsumed(Server):
    """Leaves out the last byte of a long constant text at every second reading."""

    odd = False

    def value_to_read(self, entry: Entry) -> bytes:
        if entry.access.writable or len(entry.value) <= 7:
            return entry.value
        self.odd = not self.odd
        return entry.value if self.odd else entry.value[:-1]


@fault("upload-of-5-bytes-expedited", Defect.FIELD_WIDTH, "segmented-upload.size[5]")
class FiveBytesExpedited(Server):
    """Sends an object of 5 bytes in one frame and leaves out the last."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        if len(data) == EXPEDITED_LENGTH + 1:
            return UploadInitiateResponse.with_data(mux, data[:EXPEDITED_LENGTH])
        return super().start_upload(mux, data)


@fault("upload-endless", Defect.LAST_FLAG, "segmented-upload.size[4097]", about=About.LENGTHS)
class UploadEndless(Server):
    """Announces FFFFFFFFh bytes for 4097, sends them over and over, and never marks a last one."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        if len(data) == ENDLESS_AT:
            return UploadInitiateResponse.with_size(mux, LARGEST_SIZE)
        return response

    def next_upload_data(self, transfer: Upload) -> bytes:
        if len(transfer.data) == ENDLESS_AT and transfer.offset + 7 >= ENDLESS_AT:
            transfer.offset = 0
        return super().next_upload_data(transfer)


@fault("uploads-endless", Defect.LAST_FLAG, "segmented-upload.size")
class UploadsEndless(Server):
    """Sends the bytes of an upload in segments over and over, says no size and marks no last."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        return response if response.expedited else UploadInitiateResponse.with_size(mux, None)

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        transfer = self.transfer
        if not isinstance(transfer, Upload):
            return super().on_upload_segment(request)
        self.check_toggle(transfer, request.toggle)
        transfer.toggle ^= 1
        data = (transfer.data or b"\0") * SEGMENT_LENGTH
        return [UploadSegmentResponse(data[:SEGMENT_LENGTH], toggle=request.toggle)]
