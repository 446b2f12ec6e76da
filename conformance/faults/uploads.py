"""Servers that are wrong in the initiate of an upload: counts, sizes, reserved fields."""

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.frames import Response, UploadInitiate, UploadInitiateResponse
from conformance.sdo.layout import Multiplexer
from conformance.sdo.server import Server

COUNT = DefectClass.UNUSED_COUNT
WIDTH = DefectClass.FIELD_WIDTH


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
