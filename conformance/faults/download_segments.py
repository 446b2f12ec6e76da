"""Servers that are wrong in segmented downloads: sizes, counts, toggle bits."""

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    DownloadInitiate,
    DownloadSegment,
    DownloadSegmentResponse,
    Response,
)
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.segmented_server import Download, Upload
from conformance.sdo.server import Server

COUNT = DefectClass.UNUSED_COUNT
CHECK = DefectClass.ACCESS_OR_SIZE
WIDTH = DefectClass.FIELD_WIDTH


@fault("download-20h-refused", CHECK, "segmented-download.size-not-indicated")
class UnsizedRefused(Server):
    """Refuses segmented downloads that do not indicate their size."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Insist on s = 1."""
        if size is None:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        super().check_announced_size(entry, size)


@fault(
    "download-20h-takes-reserved-bytes-for-size", CHECK, "segmented-download.request-reserved-bytes"
)
class ReservedTakenForSize(Server):
    """Takes bytes 4 to 7 of a download without size for its size."""

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        """Look at the bytes whether or not s is set."""
        size = int.from_bytes(request.payload, "little")
        return Download(request.mux, entry, request.size if size == 0 else size)


@fault("segmented-short-object-refused", CHECK, "segmented-download.number")
class ShortSegmentedRefused(Server):
    """Refuses to take up to 4 bytes in segments."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Insist on an expedited transfer."""
        if entry.longest <= 4 or (size is not None and 1 <= size <= 4):
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        super().check_announced_size(entry, size)


@fault("announced-size-8-bit", WIDTH, "segmented-download.size[256]")
class AnnouncedSizeOf8Bits(Server):
    """Looks at the low byte of an announced size only."""

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        """Cut the size."""
        size = None if request.size is None else request.size & 0xFF
        return Download(request.mux, entry, size)


@fault("download-buffer-wraps-at-1000", WIDTH, "segmented-download.size[4096]")
class BufferWraps(Server):
    """Starts to overwrite the beginning of a download after 1000 bytes."""

    def finish_download(self, transfer: Download) -> None:
        """Lay the data over itself."""
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


@fault("download-too-many-accepted", CHECK, "segmented-download.too-many")
class TooManyAccepted(_Taking):
    """Drops the bytes beyond the announced size in silence."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        """Take what fits."""
        return request.data[: transfer.room]


@fault("number-too-long-accepted-segmented", CHECK, "segmented-download.number-too-long")
class NumberTooLongSegmented(Server):
    """Cuts a number that comes in segments and is too long."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Do not check."""

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        """Forget the size of a number."""
        size = request.size if entry.data_type.length is None else None
        return Download(request.mux, entry, size)

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        """Cut a number."""
        if transfer.entry.data_type.length is not None:
            return request.data[: transfer.room]
        return super().segment_data(transfer, request)


@fault(
    "number-too-long-not-indicated-accepted",
    CHECK,
    "segmented-download.number-too-long-not-indicated",
)
class NumberTooLongUnsized(Server):
    """Cuts a number that comes in segments without its size and is too long."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        """Cut a number."""
        if transfer.size is None and transfer.entry.data_type.length is not None:
            return request.data[: transfer.room]
        return super().segment_data(transfer, request)


@fault("number-too-short-accepted-segmented", CHECK, "segmented-download.number-too-short")
class NumberTooShortSegmented(Server):
    """Pads a number that comes in segments and is too short, an empty one included."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Check the upper end only."""
        if size is not None and size > entry.longest:
            super().check_announced_size(entry, size)

    def finish_download(self, transfer: Download) -> None:
        """Fill up with 0."""
        transfer.size = None
        self.store(transfer.entry, bytes(transfer.data).ljust(transfer.entry.shortest, b"\0"))


@fault("download-too-few-accepted", CHECK, "segmented-download.too-few")
class TooFewAccepted(Server):
    """Stores a download that ends before the announced size."""

    def finish_download(self, transfer: Download) -> None:
        """Forget the size."""
        transfer.size = None
        super().finish_download(transfer)


@fault("download-too-few-refused-and-stored", CHECK, "segmented-download.too-few", soft=True)
class TooFewStored(Server):
    """Stores what came of a download before it refuses it as too short."""

    def finish_download(self, transfer: Download) -> None:
        """Store first."""
        self.store(transfer.entry, bytes(transfer.data))
        super().finish_download(transfer)


@fault("download-filler-stored", COUNT, "segmented-download.filler-ignored[8-unsized]")
class FillerStored(_Taking):
    """Stores all 7 bytes of a last segment when no size was announced."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        """Do not look at n."""
        if transfer.size is None:
            return request.payload
        return super().segment_data(transfer, request)

    def finish_download(self, transfer: Download) -> None:
        """Cut numbers to their type."""
        del transfer.data[transfer.entry.longest :]
        super().finish_download(transfer)


@fault("download-filler-checked", COUNT, "segmented-download.filler-ignored")
class FillerChecked(_Taking):
    """Refuses a last segment whose unused bytes are not 0."""

    def taken(self, request: DownloadSegment) -> bytes:
        """Look at bytes without meaning."""
        if any(request.payload[len(request.data) :]):
            raise Refusal(AbortCode.LENGTH_TOO_HIGH)
        return request.data


@fault("download-short-segments-padded", COUNT, "segmented-download.short-segments")
class ShortSegmentsPadded(_Taking):
    """Takes all 7 bytes of every segment but the last."""

    def taken(self, request: DownloadSegment) -> bytes:
        """Look at n in the last segment only."""
        return request.data if request.last else request.payload


@fault("download-empty-last-refused", DefectClass.ZERO_LENGTH, "segmented-download.empty-last")
class EmptyLastRefused(_Taking):
    """Refuses a last segment without data."""

    def taken(self, request: DownloadSegment) -> bytes:
        """Insist on a byte."""
        if not request.data:
            raise Refusal(AbortCode.LENGTH_TOO_LOW)
        return request.data


@fault("download-empty-hangs", DefectClass.ZERO_LENGTH, "segmented-download.empty")
class EmptyDownloadHangs(Server):
    """Waits for the data of a download of 0 bytes for ever."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Do not answer a segment without data."""
        if isinstance(self.transfer, Download) and self.transfer.size == 0:
            return []
        return super().on_download_segment(request)


@fault("download-n-not-stated-overruns", COUNT, "segmented-download.unused-not-stated")
class NotStatedOverruns(Server):
    """Stores 7 bytes of a last segment that does not state how many count."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        """Take all bytes of a last segment with n = 0."""
        if request.last and request.unused == 0:
            return request.payload
        return super().segment_data(transfer, request)


@fault("huge-size-crashes", DefectClass.ROBUSTNESS, "segmented-download.huge-size")
class HugeSizeCrashes(Server):
    """Never answers again once a download has announced more than it has memory for."""

    crashed = False

    def receive(self, frame: bytes) -> list[bytes]:
        """Be dead."""
        self.crashed |= frame[:1] == b"\x21" and frame[7:8] >= b"\x80"
        return [] if self.crashed else super().receive(frame)


@fault("download-reserved-bit-silent", DefectClass.ROBUSTNESS, "download.request-reserved-bit")
class DownloadReservedBitSilent(Server):
    """Does not answer a download request with bit 4 set."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        """Ignore it."""
        return [] if request.reserved_bits else super().on_download_initiate(request)


@fault(
    "download-n-without-data-silent",
    DefectClass.ROBUSTNESS,
    "segmented-download.unused-without-data",
)
class UnusedWithoutDataSilent(Server):
    """Does not answer a segmented download request with n set."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        """Ignore it."""
        if request.unused and not request.expedited:
            return []
        return super().on_download_initiate(request)


@fault("download-response-toggle-missing", DefectClass.STATE, "segmented-download.size")
class ResponseToggleMissing(Server):
    """Confirms every segment with 20h."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Clear the toggle bit."""
        return [
            DownloadSegmentResponse(0)
            if isinstance(response, DownloadSegmentResponse)
            else response
            for response in super().on_download_segment(request)
        ]


@fault("download-toggle-ignored", DefectClass.STATE, "segmented-download.toggle")
class DownloadToggleIgnored(Server):
    """Takes segments whatever their toggle bit."""

    def check_toggle(self, transfer: Download | Upload, toggle: int) -> None:
        """Check it in uploads only; follow the client in downloads."""
        if isinstance(transfer, Upload):
            super().check_toggle(transfer, toggle)
        else:
            transfer.toggle = toggle


@fault(
    "download-repeated-segment-stored", DefectClass.STATE, "segmented-download.toggle-ignored-data"
)
class RepeatedSegmentStored(Server):
    """Stores a repeated segment without a confirmation."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Keep silent about the wrong toggle bit, but take the bytes."""
        transfer = self.transfer
        if isinstance(transfer, Download) and request.toggle != transfer.toggle:
            transfer.data[:] = transfer.data[:-7] + request.data[::-1]
            return []
        return super().on_download_segment(request)


@fault("download-toggle-not-reset", DefectClass.LEAK, "segmented-download.toggle-afterwards[1]")
class DownloadToggleNotReset(Server):
    """Expects the toggle bit of an aborted download to go on in the next one."""

    due = 0

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        """Start with what was due."""
        transfer = super().start_download(request, entry)
        transfer.toggle = self.due
        return transfer

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Remember what is due; a whole transfer resets it."""
        responses = super().on_download_segment(request)
        self.due = self.transfer.toggle if isinstance(self.transfer, Download) else 0
        return responses
