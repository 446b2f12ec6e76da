"""Servers that are wrong in expedited downloads: what they take, store and refuse."""

from conformance.faults.faulty.expedited_upload import Twice
from conformance.faults.registry import Defect, fault
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    DownloadInitiate,
    DownloadInitiateResponse,
    Response,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH
from conformance.sdo.objects import DataType, Entry, ObjectDictionary, Refusal

# Bytes of every string and domain of a server that knows no other length; text fills its segments.
KEPT = 40
FIXED_LENGTH, FIXED_TEXT = 300, 301


@fault("response-on-other-id", Defect.FRAME_SHAPE, "download.")
class ResponseOnOtherId(Node):
    """Confirms downloads with the identifier of the next node."""

    def respond(self, data: bytes) -> CanFrame:
        return CanFrame(self.response_id + (data[:1] == b"\x60"), data)


@fault("download-confirmation-echoes-data", Defect.FRAME_SHAPE, "download.confirmation")
class ConfirmationEchoesData(Server):
    """Sends the request's bytes 4 to 7 back in the reserved bytes of 60h."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        super().on_download_initiate(request)
        return [DownloadInitiateResponse(request.mux, reserved=request.payload)]


@fault("download-confirmation-reserved-bits", Defect.FRAME_SHAPE, "download.reserved")
class ConfirmationReservedBits(Server):
    """Repeats n, e and s of the request in the confirmation."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        super().on_download_initiate(request)
        return [DownloadInitiateResponse(request.mux, request.encode()[0] & 0x0F)]


@fault("download-multiplexer-of-record", Defect.FRAME_SHAPE, "download.")
class ConfirmationWithoutIndex(Server):
    """Confirms a download with index 0."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        super().on_download_initiate(request)
        return [DownloadInitiateResponse(Multiplexer(0))]


@fault("download-n-ignored", Defect.UNUSED_COUNT, "download.stored[1]")
class UnusedIgnored(Server):
    """Takes 4 bytes of every expedited download."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        return request.payload


@fault("download-n-ignored-for-text", Defect.UNUSED_COUNT, "download.unused-bytes-of-text")
class UnusedIgnoredForText(Server):
    """Takes 4 bytes of every expedited download to a string."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        if entry.data_type.length is None:
            return request.payload
        return super().expedited_data(request, entry)


@fault("download-unused-bytes-checked", Defect.UNUSED_COUNT, "download.unused-bytes-ignored")
class UnusedBytesChecked(Server):
    """Refuses an expedited download whose unused bytes are not 0."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        if any(request.payload[len(request.data) :]):
            raise Refusal(AbortCode.VALUE_INVALID)
        return super().expedited_data(request, entry)


@fault("download-n-without-size-honoured", Defect.UNUSED_COUNT, "download.unused-without-size")
class UnusedHonouredWithoutSize(Server):
    """Shortens an expedited download by n though no size is indicated, and pads it again."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        data = super().expedited_data(request, entry)
        if request.sized or not request.unused:
            return data
        return data[: 4 - request.unused].ljust(len(data), b"\0")


@fault("download-22h-refused", Defect.UNUSED_COUNT, "download.size-not-indicated")
class UncountedRefused(Server):
    """Refuses expedited downloads that do not indicate their size."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        if not request.sized:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().expedited_data(request, entry)


@fault("download-22h-wrong-bytes", Defect.UNUSED_COUNT, "download.size-not-indicated-short")
class UncountedWrongBytes(Server):
    """Stores the high bytes of an expedited download that does not indicate its size."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        if request.sized:
            return super().expedited_data(request, entry)
        return request.payload[-min(entry.longest, 4) :]


@fault("download-one-byte-stored", Defect.FIELD_WIDTH, "download.stored[2]")
class OneByteStored(Server):
    """Stores the first byte of a number only."""

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data)
        if entry.data_type.length == 2:
            entry.value = data[:1] + b"\x22"


@fault(
    "download-not-stored",
    Defect.ACCESS_OR_SIZE,
    "download.unused-bytes-of-text",
    "random.sequences",
)
class NotStored(Server):
    """Confirms a download and does nothing."""

    def store(self, entry: Entry, data: bytes) -> None:
        entry.check_length(len(data))


@fault("download-stored-in-neighbour", Defect.ACCESS_OR_SIZE, "download.neighbours")
class StoredInNeighbour(Server):
    """Writes beyond the end of a number into the next one."""

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data)
        if entry.data_type.length == 4:
            neighbour = self.objects.find(Multiplexer(0x2001))
            neighbour.value = data[-1:]


@fault("download-too-long-accepted", Defect.ACCESS_OR_SIZE, "download.too-long")
class TooLongAccepted(Server):
    """Cuts an expedited download that is too long for the type."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        return super().expedited_data(request, entry)[: entry.longest]


@fault("download-too-short-accepted", Defect.ACCESS_OR_SIZE, "download.too-short")
class TooShortAccepted(Server):
    """Pads an expedited download that is too short for the type."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        return super().expedited_data(request, entry).ljust(entry.shortest, b"\0")


@fault("download-too-short-refused-and-stored", Defect.ACCESS_OR_SIZE, "download.too-short")
class RefusedAndStored(Server):
    """Refuses an expedited download that is too short after it has stored the bytes."""

    def store(self, entry: Entry, data: bytes) -> None:
        if len(data) < entry.shortest:
            entry.value = data[::-1].ljust(entry.shortest, b"\x55")
        super().store(entry, data)


@fault("length-codes-swapped", Defect.ACCESS_OR_SIZE, "download.too-long")
class LengthCodesSwapped(Server):
    """Says too low for too high and the other way round."""

    def store(self, entry: Entry, data: bytes) -> None:
        swapped = {
            AbortCode.LENGTH_TOO_HIGH: AbortCode.LENGTH_TOO_LOW,
            AbortCode.LENGTH_TOO_LOW: AbortCode.LENGTH_TOO_HIGH,
        }
        try:
            super().store(entry, data)
        except Refusal as refusal:
            raise Refusal(swapped.get(refusal.code, refusal.code)) from refusal


@fault(
    "download-reserved-bit-silent",
    Defect.ROBUSTNESS,
    "download.request-reserved-bit",
    "segmented-download.request-reserved-bit",
)
class DownloadReservedBitSilent(Server):
    """Does not answer a download request with bit 4 set."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        return [] if request.reserved_bits else super().on_download_initiate(request)


@fault("second-write-to-number-lost", Defect.LEAK, "download.twice")
class SecondWriteLost(Server):
    """Ignores a write to a number that gives it back the value before the last write."""

    before: bytes | None = None

    def store(self, entry: Entry, data: bytes) -> None:
        if data == self.before and entry.data_type.length:
            entry.check_length(len(data))
            return
        self.before = entry.value
        super().store(entry, data)


@fault("same-value-refused", Defect.ACCESS_OR_SIZE, "download.same-value")
class SameValueRefused(Server):
    """Refuses to write the value that an object has."""

    def store(self, entry: Entry, data: bytes) -> None:
        if data == entry.value:
            raise Refusal(AbortCode.VALUE_INVALID)
        super().store(entry, data)


@fault("refusal-blocks-next-write", Defect.LEAK, "download.refused-is-over")
class RefusalBlocksNext(Server):
    """Ignores the write after one that was refused for its length."""

    blocked = False

    def store(self, entry: Entry, data: bytes) -> None:
        try:
            entry.check_length(len(data))
        except Refusal:
            self.blocked = True
            raise
        if self.blocked and data != entry.value:
            self.blocked = False
            return
        super().store(entry, data)


@fault("refused-download-confirmed", Defect.ABORT, "download.refused-once")
class DownloadConfirmed(Twice):
    """Sends the confirmation behind the abort of a refused download."""

    request_kind = DownloadInitiate

    def second(self, mux: Multiplexer) -> Response:
        return DownloadInitiateResponse(mux)


@fault("short-text-refused", Defect.ACCESS_OR_SIZE, "download.text")
class ShortTextRefused(Server):
    """Refuses an expedited download to a string or domain unless it has 4 bytes."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        data = super().expedited_data(request, entry)
        if not entry.shortest and len(data) < EXPEDITED_LENGTH:
            raise Refusal(AbortCode.LENGTH_TOO_LOW)
        return data


@fault("strings-padded", Defect.ACCESS_OR_SIZE, "download.text")
class StringsPadded(Server):
    """Has strings and domains of 300 or 301 bytes only, and fills up with 0 what comes shorter."""

    def __init__(self, objects: ObjectDictionary) -> None:
        super().__init__(objects)
        for entry in objects:
            if self.is_fixed(entry):
                entry.capacity = self.length_of(entry)
                entry.value = entry.value.ljust(entry.capacity, b"\0")

    def store(self, entry: Entry, data: bytes) -> None:
        if self.is_fixed(entry):
            data = data.ljust(entry.capacity, b"\0")
        super().store(entry, data)

    def length_of(self, entry: Entry) -> int:
        """Return the only length that an entry has."""
        return FIXED_TEXT if entry.data_type is DataType.VISIBLE_STRING else FIXED_LENGTH

    def is_fixed(self, entry: Entry) -> bool:
        """Say whether an entry ought to take values of different lengths."""
        return entry.data_type.length is None and entry.access.writable


@fault("strings-cut-to-40-bytes", Defect.ACCESS_OR_SIZE, "download.as-written", soft=True)
class StringsCutToCapacity(Server):
    """Takes strings of any length and keeps their first 40 bytes."""

    def store(self, entry: Entry, data: bytes) -> None:
        if entry.data_type is DataType.VISIBLE_STRING:
            data = data[:KEPT]
        super().store(entry, data)
