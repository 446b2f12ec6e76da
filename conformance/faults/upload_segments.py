"""Servers that are wrong in the segments of an upload: data, counts, flags, toggle bits."""

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.frames import (
    Response,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry
from conformance.sdo.segmented_server import Download, Upload
from conformance.sdo.server import Server

COUNT = DefectClass.UNUSED_COUNT
WIDTH = DefectClass.FIELD_WIDTH


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


@fault("upload-empty-hangs", DefectClass.ZERO_LENGTH, "segmented-upload.empty")
class EmptyHangs(Server):
    """Announces an empty object and never answers the segment request."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Find nothing to send."""
        if isinstance(self.transfer, Upload) and not self.transfer.data:
            return []
        return super().on_upload_segment(request)


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


@fault("upload-empty-as-4-bytes", DefectClass.ZERO_LENGTH, "segmented-upload.empty")
class EmptyAs4Bytes(Server):
    """Answers the upload of an empty object by 53h: 4 bytes 0, and n spilled into bit 4."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Subtract the length from 4."""
        if data:
            return super().start_upload(mux, data)
        return UploadInitiateResponse(mux, True, True, 0, bytes(4), 1)
