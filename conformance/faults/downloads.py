"""Servers that are wrong in downloads: what they accept, what they store, how they confirm."""

from dataclasses import replace

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    Response,
    UploadInitiate,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.segmented_server import Download
from conformance.sdo.server import Server

COUNT = DefectClass.UNUSED_COUNT
FIRST_OF_DEVICE = 0x2000
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


class _AnySubIndex(Server):
    """Takes any sub-index of a simple object for its sub-index 0, in downloads."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        """Look for sub-index 0 where there is no other."""
        index = request.mux.index
        simple = self.objects.get(Multiplexer(index, 1)) is None
        known = self.objects.get(Multiplexer(index)) is not None
        if index >= FIRST_OF_DEVICE and simple and known:
            request = replace(request, mux=Multiplexer(index))
        return super().entry_to_write(request)


@fault("variable-written-by-any-sub-index", CHECK, "download.sub-index-of-variable")
class VariableWritten(_AnySubIndex):
    """Refuses to read a sub-index of a variable of its own, and takes a download to it."""


@fault("variable-served-by-any-sub-index", CHECK, "download.sub-index-of-variable")
class VariableServed(_AnySubIndex):
    """Serves any sub-index of a variable of its own as the variable, reads and downloads alike."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Read sub-index 0."""
        mux = Multiplexer(request.mux.index)
        missing = self.objects.get(request.mux) is None
        entry = self.objects.get(mux)
        if request.mux.index < FIRST_OF_DEVICE or not missing or entry is None:
            return super().on_upload_initiate(request)
        self.transfer = None
        return [self.start_upload(request.mux, self.value_to_read(entry))]
