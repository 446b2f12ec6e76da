"""Servers that are right in uploads in their own way: segments, sizes, counts."""

from conformance.faults.registry import unusual
from conformance.reference.segmented_server import Upload
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Response,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH
from conformance.sdo.objects import DataType, Entry, Refusal


@unusual("short-uploads-in-segments")
class ShortInSegments(Server):
    """Sends everything in segments, also 1 to 4 bytes."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        self.transfer = Upload(mux, data)
        return UploadInitiateResponse.with_size(mux, len(data))


@unusual("upload-size-not-indicated")
class UnsizedUploads(Server):
    """Never says how long a segmented upload is (40h)."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        return response if response.expedited else UploadInitiateResponse.with_size(mux, None)


@unusual("expedited-upload-not-counted")
class UncountedUploads(Server):
    """Answers numbers with 42h: their type says how many of the 4 bytes count."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        if response.expedited and self.objects.find(mux).data_type.length is not None:
            return UploadInitiateResponse.with_uncounted_data(mux, data)
        return response


@unusual("short-text-not-counted")
class UncountedText(Server):
    """Answers a text of up to 4 bytes with 42h: it ends at the first 00h."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        is_text = self.objects.find(mux).data_type is DataType.VISIBLE_STRING
        if is_text and len(data) <= EXPEDITED_LENGTH:
            return UploadInitiateResponse.with_uncounted_data(mux, data)
        return super().start_upload(mux, data)


@unusual("short-upload-segments")
class ShortSegments(Server):
    """Sends segments of 5 bytes."""

    def next_upload_data(self, transfer: Upload) -> bytes:
        return super().next_upload_data(transfer)[:5]


@unusual("empty-last-upload-segment")
class EmptyLastSegment(Server):
    """Ends every upload with a segment without data."""

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        transfer = self.transfer
        responses = super().on_upload_segment(request)
        segment = responses[0]
        if not isinstance(transfer, Upload) or not isinstance(segment, UploadSegmentResponse):
            return responses
        if segment.last and segment.data:
            self.transfer = transfer
            return [UploadSegmentResponse(segment.payload, segment.toggle, segment.unused)]
        return responses


@unusual("text-ends-in-zero", soft=True)
class TextEndsInZero(Server):
    """Sends a text with a 00h behind it, which is part of its size."""

    def value_to_read(self, entry: Entry) -> bytes:
        ends = entry.data_type is DataType.VISIBLE_STRING
        return entry.value + b"\0" if ends else entry.value


@unusual("empty-value-not-read")
class EmptyNotRead(Server):
    """Refuses to read a value without data."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        if not data:
            raise Refusal(AbortCode.NO_DATA)
        return super().start_upload(mux, data)
