"""Servers that are wrong in downloads: what they accept, what they store, how they confirm."""

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    Response,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.server import Download, Server, Upload

COUNT = DefectClass.UNUSED_COUNT
CHECK = DefectClass.ACCESS_OR_SIZE
SHAPE = DefectClass.FRAME_SHAPE
WIDTH = DefectClass.FIELD_WIDTH


@fault("download-confirmation-echoes-data", SHAPE, "download.confirmation")
class ConfirmationEchoesData(Server):
    """Sends the request's bytes 4 to 7 back in the reserved bytes of 60h."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        """Fill the reserved bytes."""
        super().on_download_initiate(request)
        return [DownloadInitiateResponse(request.mux, reserved=request.payload)]


@fault("download-confirmation-reserved-bits", SHAPE, "download.reserved")
class ConfirmationReservedBits(Server):
    """Repeats n, e and s of the request in the confirmation."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        """Fill the reserved bits."""
        super().on_download_initiate(request)
        return [DownloadInitiateResponse(request.mux, request.encode()[0] & 0x0F)]


@fault("download-segment-response-echoes-multiplexer", SHAPE, "segmented-download.reserved")
class SegmentResponseEchoes(Server):
    """Puts the multiplexer into the reserved bytes of 20h and 30h."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Fill the reserved bytes."""
        transfer = self.transfer
        responses = super().on_download_segment(request)
        if not isinstance(transfer, Download):
            return responses
        mux = DownloadInitiateResponse(transfer.mux).encode()[1:4]
        return [DownloadSegmentResponse(request.toggle, reserved=mux + bytes(4))]


@fault("download-multiplexer-of-record", SHAPE, "download.")
class ConfirmationWithoutIndex(Server):
    """Confirms a download with index 0."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        """Forget the multiplexer."""
        super().on_download_initiate(request)
        return [DownloadInitiateResponse(Multiplexer(0))]


@fault("download-n-ignored", COUNT, "download.stored[1]")
class UnusedIgnored(Server):
    """Takes 4 bytes of every expedited download."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        """Do not look at n."""
        return request.payload


@fault("download-n-ignored-for-text", COUNT, "download.unused-bytes-of-text")
class UnusedIgnoredForText(Server):
    """Takes 4 bytes of every expedited download to a string."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        """Look at the type instead of n."""
        if entry.data_type.length is None:
            return request.payload
        return super().expedited_data(request, entry)


@fault("download-unused-bytes-checked", COUNT, "download.unused-bytes-ignored")
class UnusedBytesChecked(Server):
    """Refuses an expedited download whose unused bytes are not 0."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        """Look at bytes without meaning."""
        if any(request.payload[len(request.data) :]):
            raise Refusal(AbortCode.VALUE_INVALID)
        return super().expedited_data(request, entry)


@fault("download-n-without-size-honoured", COUNT, "download.unused-without-size")
class UnusedHonouredWithoutSize(Server):
    """Shortens an expedited download by n though no size is indicated, and pads it again."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        """Look at n always."""
        data = super().expedited_data(request, entry)
        if request.sized or not request.unused:
            return data
        return data[: 4 - request.unused].ljust(len(data), b"\0")


@fault("download-22h-refused", COUNT, "download.size-not-indicated")
class UncountedRefused(Server):
    """Refuses expedited downloads that do not indicate their size."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        """Insist on s = 1."""
        if not request.sized:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().expedited_data(request, entry)


@fault("download-22h-wrong-bytes", COUNT, "download.size-not-indicated-short")
class UncountedWrongBytes(Server):
    """Stores the high bytes of an expedited download that does not indicate its size."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        """Take the bytes from the other end."""
        if request.sized:
            return super().expedited_data(request, entry)
        return request.payload[-min(entry.longest, 4) :]


@fault("download-one-byte-stored", WIDTH, "download.stored[2]")
class OneByteStored(Server):
    """Stores the first byte of a number only."""

    def store(self, entry: Entry, data: bytes) -> None:
        """Keep the high bytes."""
        super().store(entry, data)
        if entry.data_type.length == 2:
            entry.value = data[:1] + b"\x22"


@fault("download-not-stored", CHECK, "download.stored")
class NotStored(Server):
    """Confirms a download and does nothing."""

    def store(self, entry: Entry, data: bytes) -> None:
        """Check, and forget."""
        entry.check_length(len(data))


@fault("download-stored-in-neighbour", CHECK, "download.neighbours")
class StoredInNeighbour(Server):
    """Writes beyond the end of a number into the next one."""

    def store(self, entry: Entry, data: bytes) -> None:
        """Overwrite the low byte of 2001h as well."""
        super().store(entry, data)
        if entry.data_type.length == 4:
            neighbour = self.objects.find(Multiplexer(0x2001))
            neighbour.value = data[-1:]


@fault("segmented-download-stored-in-neighbour", CHECK, "segmented-download.other-objects")
class SegmentsStoredInNeighbour(Server):
    """Writes the end of a long string into the number before it."""

    def finish_download(self, transfer: Download) -> None:
        """Overwrite 2004h as well."""
        super().finish_download(transfer)
        if len(transfer.data) > 13:
            self.objects.find(Multiplexer(0x2004)).value = bytes(transfer.data[-4:])


@fault("download-too-long-accepted", CHECK, "download.too-long")
class TooLongAccepted(Server):
    """Cuts an expedited download that is too long for the type."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        """Take what fits."""
        return super().expedited_data(request, entry)[: entry.longest]


@fault("download-too-short-accepted", CHECK, "download.too-short")
class TooShortAccepted(Server):
    """Pads an expedited download that is too short for the type."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        """Fill up with 0."""
        return super().expedited_data(request, entry).ljust(entry.shortest, b"\0")


@fault("download-too-short-refused-and-stored", CHECK, "download.too-short")
class RefusedAndStored(Server):
    """Refuses an expedited download that is too short after it has stored the bytes."""

    def store(self, entry: Entry, data: bytes) -> None:
        """Store first, check then."""
        if len(data) < entry.shortest:
            entry.value = data[::-1].ljust(entry.shortest, b"\x55")
        super().store(entry, data)


@fault("length-codes-swapped", CHECK, "download.too-long")
class LengthCodesSwapped(Server):
    """Says too low for too high and the other way round."""

    def store(self, entry: Entry, data: bytes) -> None:
        """Swap the codes."""
        swapped = {
            AbortCode.LENGTH_TOO_HIGH: AbortCode.LENGTH_TOO_LOW,
            AbortCode.LENGTH_TOO_LOW: AbortCode.LENGTH_TOO_HIGH,
        }
        try:
            super().store(entry, data)
        except Refusal as refusal:
            raise Refusal(swapped.get(refusal.code, refusal.code)) from refusal


class _ReadOnlyWritten(Server):
    """Writes read-only objects on one kind of transfer."""

    expedited = False

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        """Forget the access on that kind."""
        if request.expedited is self.expedited:
            return self.objects.find(request.mux)
        return super().entry_to_write(request)


@fault("read-only-written-expedited", CHECK, "download.read-only")
class ReadOnlyWrittenExpedited(_ReadOnlyWritten):
    """Accepts expedited downloads to read-only objects."""

    expedited = True


@fault("read-only-written-segmented", CHECK, "segmented-download.read-only")
class ReadOnlyWrittenSegmented(_ReadOnlyWritten):
    """Accepts segmented downloads to read-only objects."""


@fault("read-only-refused-and-written", CHECK, "segmented-download.read-only")
class ReadOnlyRefusedAndWritten(Server):
    """Refuses a download to a read-only object and changes the object all the same."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        """Write before the check."""
        try:
            return super().entry_to_write(request)
        except Refusal:
            if request.mux == Multiplexer(0x1018, 1):
                entry = self.objects.find(request.mux)
                entry.value = bytes([entry.value[0] ^ 1]) + entry.value[1:]
            raise


class _LookupForWrite(Server):
    """Changes why a download is refused."""

    codes: dict[AbortCode, AbortCode] = {}  # noqa: RUF012 - subclasses replace it

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        """Replace the code."""
        try:
            return super().entry_to_write(request)
        except Refusal as refusal:
            raise Refusal(self.codes.get(refusal.code, refusal.code)) from refusal


@fault("download-read-only-code-wrong", CHECK, "download.read-only")
class ReadOnlyCodeWrong(_LookupForWrite):
    """Says write-only where it means read-only."""

    codes = {AbortCode.WRITE_OF_READ_ONLY: AbortCode.READ_OF_WRITE_ONLY}  # noqa: RUF012


@fault("download-missing-object-code-wrong", CHECK, "download.object-missing")
class MissingForWriteCodeWrong(_LookupForWrite):
    """Says read-only where a download meets no object."""

    codes = {AbortCode.OBJECT_MISSING: AbortCode.WRITE_OF_READ_ONLY}  # noqa: RUF012


@fault("download-missing-sub-index-code-wrong", CHECK, "download.sub-index-missing")
class MissingSubForWriteCodeWrong(_LookupForWrite):
    """Says that the object is missing where a download meets no sub-index."""

    codes = {AbortCode.SUB_INDEX_MISSING: AbortCode.OBJECT_MISSING}  # noqa: RUF012


@fault("write-only-refused", CHECK, "download.write-only")
class WriteOnlyRefused(Server):
    """Refuses downloads to what cannot be read."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        """Ask for read access, wrongly."""
        entry = super().entry_to_write(request)
        if not entry.access.readable:
            raise Refusal(AbortCode.WRITE_OF_READ_ONLY)
        return entry


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


@fault("download-too-few-refused-and-stored", CHECK, "segmented-download.too-few")
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


@fault("download-response-toggle-missing", DefectClass.STATE, "segmented-download.")
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
