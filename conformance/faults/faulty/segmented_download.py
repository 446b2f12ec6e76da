"""Servers that are wrong in segmented downloads: frames, counts, what they store."""

from conformance.faults.faulty.expedited_download_access import ReadOnlyWritten
from conformance.faults.registry import About, Defect, fault
from conformance.reference.segmented_server import Download
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal


@fault(
    "download-segment-response-echoes-multiplexer",
    Defect.FRAME_SHAPE,
    "segmented-download.reserved",
)
class SegmentResponseEchoes(Server):
    """Puts the multiplexer into the reserved bytes of 20h and 30h."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        transfer = self.transfer
        responses = super().on_download_segment(request)
        if not isinstance(transfer, Download):
            return responses
        mux = DownloadInitiateResponse(transfer.mux).encode()[1:4]
        return [DownloadSegmentResponse(request.toggle, reserved=mux + bytes(4))]


@fault(
    "segmented-download-stored-in-neighbour",
    Defect.ACCESS_OR_SIZE,
    "segmented-download.other-objects",
)
class SegmentsStoredInNeighbour(Server):
    """Writes the end of a long string into the number before it."""

    def finish_download(self, transfer: Download) -> None:
        super().finish_download(transfer)
        if len(transfer.data) > 13:
            self.objects.find(Multiplexer(0x2004)).value = bytes(transfer.data[-4:])


@fault(
    "read-only-written-segmented",
    Defect.ACCESS_OR_SIZE,
    "segmented-download.read-only",
    "segmented-download.read-only-text",
)
class ReadOnlyWrittenSegmented(ReadOnlyWritten):
    """Accepts segmented downloads to read-only objects."""


@fault("read-only-refused-and-written", Defect.ACCESS_OR_SIZE, "segmented-download.read-only")
class ReadOnlyRefusedAndWritten(Server):
    """Refuses a download to a read-only object and changes the object all the same."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        try:
            return super().entry_to_write(request)
        except Refusal:
            if request.mux == Multiplexer(0x1018, 1):
                entry = self.objects.find(request.mux)
                entry.value = bytes([entry.value[0] ^ 1]) + entry.value[1:]
            raise


@fault(
    "download-20h-refused",
    Defect.ACCESS_OR_SIZE,
    "segmented-download.size-not-indicated",
    "segmented-download.number-size-not-indicated",
)
class UnsizedRefused(Server):
    """Refuses segmented downloads that do not indicate their size."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if size is None:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        super().check_announced_size(entry, size)


@fault(
    "download-20h-takes-reserved-bytes-for-size",
    Defect.ACCESS_OR_SIZE,
    "segmented-download.request-reserved-bytes",
)
class ReservedTakenForSize(Server):
    """Takes bytes 4 to 7 of a download without size for its size."""

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        size = int.from_bytes(request.payload, "little")
        return Download(request.mux, entry, request.size if size == 0 else size)


@fault("segmented-short-object-refused", Defect.ACCESS_OR_SIZE, "segmented-download.number")
class ShortSegmentedRefused(Server):
    """Refuses to take up to 4 bytes in segments."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if entry.longest <= 4 or (size is not None and 1 <= size <= 4):
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        super().check_announced_size(entry, size)


@fault("announced-size-8-bit", Defect.FIELD_WIDTH, "segmented-download.size[257]")
class AnnouncedSizeOf8Bits(Server):
    """Looks at the low byte of an announced size only."""

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        size = None if request.size is None else request.size & 0xFF
        return Download(request.mux, entry, size)


@fault("download-buffer-wraps-at-1000", Defect.FIELD_WIDTH, "segmented-download.size[4097]")
class BufferWraps(Server):
    """Starts to overwrite the beginning of a download after 1000 bytes."""

    def finish_download(self, transfer: Download) -> None:
        data = transfer.data
        for place in range(1000, len(data)):
            data[place % 1000] = data[place]
        super().finish_download(transfer)


class _Taking(Server):
    """Takes other bytes from a segment than the ones that count."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        """Take what ``taken`` says, as far as there is room."""
        super().segment_data(transfer, request)
        return self.taken(request)[: max(transfer.room, 0)]

    def taken(self, request: DownloadSegment) -> bytes:
        """Return the bytes to take."""
        return request.data


@fault(
    "download-filler-stored", Defect.UNUSED_COUNT, "segmented-download.filler-ignored[8-unsized]"
)
class FillerStored(_Taking):
    """Stores all 7 bytes of a last segment when no size was announced."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        if transfer.size is None:
            return request.payload
        return super().segment_data(transfer, request)

    def finish_download(self, transfer: Download) -> None:
        del transfer.data[transfer.entry.longest :]
        super().finish_download(transfer)


@fault("download-filler-checked", Defect.UNUSED_COUNT, "segmented-download.filler-ignored")
class FillerChecked(_Taking):
    """Refuses a last segment whose unused bytes are not 0."""

    def taken(self, request: DownloadSegment) -> bytes:
        if any(request.payload[len(request.data) :]):
            raise Refusal(AbortCode.LENGTH_TOO_HIGH)
        return request.data


@fault(
    "download-short-segments-padded",
    Defect.UNUSED_COUNT,
    "segmented-download.short-segments",
    soft=True,
)
class ShortSegmentsPadded(_Taking):
    """Takes all 7 bytes of every segment but the last."""

    def taken(self, request: DownloadSegment) -> bytes:
        return request.data if request.last else request.payload


@fault(
    "download-empty-last-refused",
    Defect.ZERO_LENGTH,
    "segmented-download.empty-last",
    soft=True,
)
class EmptyLastRefused(_Taking):
    """Refuses a last segment without data."""

    def taken(self, request: DownloadSegment) -> bytes:
        if not request.data:
            raise Refusal(AbortCode.LENGTH_TOO_LOW)
        return request.data


@fault("download-empty-hangs", Defect.ZERO_LENGTH, "segmented-download.empty")
class EmptyDownloadHangs(Server):
    """Waits for the data of a download of 0 bytes for ever."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        if isinstance(self.transfer, Download) and self.transfer.size == 0:
            return []
        return super().on_download_segment(request)


@fault(
    "download-n-not-stated-overruns", Defect.UNUSED_COUNT, "segmented-download.unused-not-stated"
)
class NotStatedOverruns(Server):
    """Stores 7 bytes of a last segment that does not state how many count."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        if request.last and request.unused == 0:
            return request.payload
        return super().segment_data(transfer, request)


@fault(
    "download-n-without-data-silent", Defect.ROBUSTNESS, "segmented-download.unused-without-data"
)
class UnusedWithoutDataSilent(Server):
    """Does not answer a segmented download request with n set."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        if request.unused and not request.expedited:
            return []
        return super().on_download_initiate(request)


@fault("download-response-toggle-missing", Defect.STATE, "segmented-download.size")
class ResponseToggleMissing(Server):
    """Confirms every segment with 20h."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        return [
            DownloadSegmentResponse(0)
            if isinstance(response, DownloadSegmentResponse)
            else response
            for response in super().on_download_segment(request)
        ]


@fault("refusal-leaves-size", Defect.LEAK, "segmented-download.refused-is-over")
class RefusalLeavesSize(Server):
    """Puts bytes of a refused download at the end of the next one."""

    left = b""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        if isinstance(self.transfer, Download) and code is AbortCode.LENGTH_TOO_LOW:
            self.left = bytes(self.transfer.data[-2:])
        return super().refuse(request, code)

    def store(self, entry: Entry, data: bytes) -> None:
        if self.left and entry.data_type.length is None:
            data, self.left = data[:-2] + self.left, b""
        super().store(entry, data)


@fault(
    "segmented-download-offset-16-bit",
    Defect.FIELD_WIDTH,
    "segmented-download.beyond-16-bits",
    about=About.LENGTHS,
)
class SegmentedOffsetOf16Bits(Server):
    """Keeps the last 65,535 bytes of any download."""

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data[-0xFFFF:])


@fault("unsized-downloads-refused", Defect.ACCESS_OR_SIZE, "segmented-download.size-not-indicated")
class UnsizedDownloadsRefused(Server):
    """Refuses segmented and block downloads that do not indicate their size."""

    code = AbortCode.LENGTH_MISMATCH

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        if not request.expedited and not request.sized:
            raise Refusal(self.code)
        return super().on_download_initiate(request)

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        if not request.sized:
            raise Refusal(self.code)
        return super().on_block_download_initiate(request)


@fault(
    "unsized-downloads-unsupported", Defect.ACCESS_OR_SIZE, "segmented-download.size-not-indicated"
)
class UnsizedDownloadsUnsupported(UnsizedDownloadsRefused):
    """Refuses downloads that do not indicate their size as access that it does not support."""

    code = AbortCode.UNSUPPORTED_ACCESS
