"""Servers that are right in their object dictionary in their own way."""

from functools import partial

from conformance.faults import registry
from conformance.faults.registry import About
from conformance.faults.unusual.abort import OtherCodes
from conformance.reference.dictionary import GAPPY, IDENTITY, TYPES, all_entries
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.frames import (
    BlockUploadInitiate,
    DownloadInitiate,
    Request,
    Response,
    UploadInitiate,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry, ObjectDictionary, Refusal

unusual = partial(registry.unusual, about=About.OBJECTS)
STRUCTURE = 0xFF
NOT_COUNTED = (DataType.BOOLEAN, DataType.REAL32, DataType.REAL64)
_RECORDS = {0x1018: 0x23, 0x1200: 0x22, 0x1280: 0x22}
ERROR_REGISTER = Multiplexer(0x1001)


@unusual("structure-entry-implemented")
class StructureImplemented(Server):
    """Tells in sub-index FFh the types of each object."""

    def react(self, request: Request) -> list[Response]:
        if isinstance(request, UploadInitiate) and request.mux.sub_index == STRUCTURE:
            self.transfer = None
            data = self.structure(request.mux.index)
            return [self.start_upload(request.mux, data)]
        return super().react(request)

    def structure(self, index: int) -> bytes:
        """Return object type and data type."""
        entry = self.objects.find(Multiplexer(index))
        try:
            place = self.objects.find(Multiplexer(index, 1))
        except Refusal:
            is_domain = entry.data_type is DataType.DOMAIN
            return bytes([0x02 if is_domain else 0x07, entry.data_type, 0, 0])
        if index in (ERROR_LIST, GAPPY):
            return bytes([0x08, place.data_type, 0, 0])
        return bytes([0x09, _RECORDS.get(index, 0x40), 0, 0])


@unusual("measured-values-float")
class ValuesFloat(Server):
    """Measures anew with every read of what is read-only."""

    count = 0

    def value_to_read(self, entry: Entry) -> bytes:
        """Count instead; neither its EDS nor its errors are measured."""
        fixed = entry.data_type is DataType.DOMAIN or entry is self.objects.find(ERROR_REGISTER)
        if entry.access is not Access.RO or fixed:
            return entry.value
        self.count = (self.count + 1) % 100
        return bytes([self.count]) * len(entry.value)


@unusual("an-error-in-the-list")
class ErrorInList(Server):
    """Has had an error, and keeps it in 1003h until 0 is written there."""

    def __init__(self, objects: ObjectDictionary) -> None:
        super().__init__(objects)
        objects.find(Multiplexer(ERROR_LIST)).value = b"\x01"
        objects.find(Multiplexer(ERROR_LIST, 1)).has_data = True


@unusual("no-serial-number", lacking=frozenset({Multiplexer(IDENTITY, 4)}))
class NoSerialNumber(Server):
    """Has an identity of three entries, as its EDS says."""


@unusual(
    "smallest-device",
    lacking=frozenset(all_entries(1))
    - {Multiplexer(4096), Multiplexer(4097), Multiplexer(IDENTITY), Multiplexer(IDENTITY, 1)},
)
class SmallestDevice(Server):
    """Has the mandatory objects and nothing else, as its EDS says."""


@unusual("generic-limit-code")
class GenericLimit(OtherCodes):
    """Says "invalid value" for too high and for too low."""

    codes = {
        AbortCode.VALUE_TOO_HIGH: AbortCode.VALUE_INVALID,
        AbortCode.VALUE_TOO_LOW: AbortCode.VALUE_INVALID,
    }


@unusual("no-data-is-general-error")
class NoDataGeneral(OtherCodes):
    """Says "general error" for a place of an array that is empty."""

    codes = {AbortCode.NO_DATA: AbortCode.GENERAL_ERROR}


@unusual("no-places-without-errors", soft=True)
class NoPlacesWithoutErrors(Server):
    """Has a place in the list of errors (1003h) only for an error that there was."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        match request:
            case UploadInitiate(mux) | BlockUploadInitiate(mux) if mux.index == ERROR_LIST:
                code = AbortCode.SUB_INDEX_MISSING if code is AbortCode.NO_DATA else code
        return super().refuse(request, code)


@unusual("locked-for-now")
class LockedForNow(Server):
    """Refuses to write the array 2110h in the state that it is in."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        """Look at the state once the length is right."""
        if request.mux.index == GAPPY and self.has_right_length(request):
            self.objects.writable(request.mux)
            raise Refusal(AbortCode.DEVICE_STATE)
        return super().entry_to_write(request)

    def has_right_length(self, request: DownloadInitiate) -> bool:
        """Say whether nothing but the state is in the way."""
        return (len(request.data) if request.expedited else request.size) == 2


@unusual("limits-checked-before-lengths")
class LimitsFirst(Server):
    """Looks at the limits of a number first, and then at its length."""

    def store(self, entry: Entry, data: bytes) -> None:
        if data:
            entry.check_limits(data.ljust(entry.shortest, b"\0")[: entry.longest])
        super().store(entry, data)

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if entry.low is None and entry.high is None:
            super().check_announced_size(entry, size)


@unusual("rw-values-count")
class RwValuesCount(Server):
    """Counts on with every read of the numbers in 2120h, which its EDS calls rw."""

    pace = 1
    reads = 0

    def value_to_read(self, entry: Entry) -> bytes:
        if not self.counts(entry):
            return entry.value
        self.reads += 1
        if self.reads % self.pace == 0:
            count = int.from_bytes(entry.value, "little") + 1
            entry.value = (count % 100).to_bytes(len(entry.value), "little")
        return entry.value

    def counts(self, entry: Entry) -> bool:
        """Say whether an entry is a number of the record."""
        plain = entry.data_type.length is not None and entry.data_type not in NOT_COUNTED
        return plain and any(
            own is entry
            for mux, own in self.objects.items()
            if mux.index == TYPES and mux.sub_index
        )


@unusual("rw-values-count-now-and-then")
class RwValuesCountSlowly(RwValuesCount):
    """Counts on with every seventh read of the numbers in 2120h, which its EDS calls rw."""

    pace = 7
