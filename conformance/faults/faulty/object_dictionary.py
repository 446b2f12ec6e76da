"""Servers whose object dictionary is not what their EDS says: what they read, lack and count."""

from functools import partial

from conformance.device.numbers import encode_number
from conformance.faults import registry
from conformance.faults.block_servers import KnowsBlockUploads
from conformance.faults.registry import About, Defect
from conformance.reference.dictionary import GAPPY
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.frames import (
    BlockUploadInitiate,
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry, ObjectDictionary, Refusal

fault = partial(registry.fault, about=About.OBJECTS)
DEVICE_TYPE = Multiplexer(0x1000)
FIRST_OF_APPLICATION = 0x2000


class _Reads(Server):
    """Reads some entries otherwise than they are."""

    reading = DEVICE_TYPE

    def react(self, request: Request) -> list[Response]:
        if isinstance(request, UploadInitiate | BlockUploadInitiate):
            self.reading = request.mux
            self.check_readable(request.mux)
        return super().react(request)

    def check_readable(self, mux: Multiplexer) -> None:
        """Refuse what is said not to be there."""


@fault("listed-objects-missing", Defect.ACCESS_OR_SIZE, "od.read[2001h:00]")
class ListedMissing(_Reads):
    """Lacks every object of its EDS but the device type."""

    def check_readable(self, mux: Multiplexer) -> None:
        if mux != DEVICE_TYPE:
            raise Refusal(AbortCode.OBJECT_MISSING)


@fault("device-type-missing", Defect.ACCESS_OR_SIZE, "od.read[1000h:00]")
class DeviceTypeMissing(_Reads):
    """Lacks the device type."""

    def check_readable(self, mux: Multiplexer) -> None:
        if mux == DEVICE_TYPE:
            raise Refusal(AbortCode.OBJECT_MISSING)


@fault("numbers-read-one-byte-long", Defect.FIELD_WIDTH, "od.length")
class NumbersLong(Server):
    """Reads every number with a byte more than its type has."""

    def value_to_read(self, entry: Entry) -> bytes:
        return entry.value if entry.data_type.length is None else entry.value + b"\0"


@fault("numbers-read-one-byte-short", Defect.FIELD_WIDTH, "od.length[2004h:00]")
class NumbersShort(Server):
    """Leaves the highest byte of long numbers out."""

    def value_to_read(self, entry: Entry) -> bytes:
        return entry.value[:-1] if (entry.data_type.length or 0) > 1 else entry.value


@fault("short-numbers-read-as-4-bytes", Defect.FIELD_WIDTH, "od.length[2001h:00]")
class ShortNumbersWide(Server):
    """Reads numbers of 1 to 3 bytes with 4."""

    def value_to_read(self, entry: Entry) -> bytes:
        return entry.value if entry.data_type.length is None else entry.value.ljust(4, b"\0")


@fault("value-outside-its-limits", Defect.ACCESS_OR_SIZE, "od.within-limits")
class OutsideLimits(Server):
    """Reads numbers with limits as one more than the high limit."""

    def value_to_read(self, entry: Entry) -> bytes:
        if entry.high is None:
            return entry.value
        return encode_number(entry.data_type, entry.high + 1)


@fault("constants-differ-from-eds", Defect.ACCESS_OR_SIZE, "od.default")
class ConstantsDiffer(Server):
    """Has other constants than its EDS states."""

    def value_to_read(self, entry: Entry) -> bytes:
        if entry.access is not Access.CONST:
            return entry.value
        return bytes([entry.value[0] ^ 1]) + entry.value[1:]


@fault("parameters-differ-from-eds", Defect.ACCESS_OR_SIZE, "od.default-of-parameter")
class ParametersDiffer(Server):
    """Has other defaults than its EDS states, not of what is written in an order of its own."""

    def __init__(self, objects: ObjectDictionary) -> None:
        super().__init__(objects)
        for mux, entry in objects.items():
            of_application = mux.index >= FIRST_OF_APPLICATION
            if of_application and entry.access is Access.RW and entry.value:
                entry.value = bytes([entry.value[0] ^ 1]) + entry.value[1:]


@fault("other-revision-than-eds", Defect.ACCESS_OR_SIZE, "od.identity[revision-number]")
class OtherRevision(_Reads):
    """Is of another revision than its EDS."""

    def value_to_read(self, entry: Entry) -> bytes:
        if self.reading != Multiplexer(0x1018, 3):
            return entry.value
        return (int.from_bytes(entry.value, "little") + 1).to_bytes(4, "little")


@fault("empty-errors-read-as-0", Defect.ACCESS_OR_SIZE, "od.error-list", soft=True)
class EmptyErrorsRead(_Reads):
    """Serves the places of the error list that hold no error, as 0."""

    def check_readable(self, mux: Multiplexer) -> None:
        if mux.index == ERROR_LIST:
            self.objects.find(mux).has_data = True


@fault("cleared-errors-read", Defect.LEAK, "od.error-list")
class ClearedErrorsRead(EmptyErrorsRead):
    """Serves the places of the error list that hold no error, with errors that are over."""

    def value_to_read(self, entry: Entry) -> bytes:
        is_place = self.reading.index == ERROR_LIST and self.reading.sub_index
        return b"\x10\x81\0\0" if is_place and not any(entry.value) else entry.value


@fault("constant-text-ends-in-00h", Defect.FIELD_WIDTH, "od.default[1008h:00]", soft=True)
class TextEndsInZero(Server):
    """Sends a text that its EDS states with a 00h behind it."""

    def value_to_read(self, entry: Entry) -> bytes:
        is_text = entry.data_type is DataType.VISIBLE_STRING and entry.access is Access.CONST
        return entry.value + b"\0" if is_text else entry.value


@fault("block-read-of-other-bytes", Defect.LEAK, "od.block-read")
class BlockReadsOther(KnowsBlockUploads):
    """Reads other bytes in blocks than in segments."""

    def value_to_read(self, entry: Entry) -> bytes:
        return bytes(byte ^ self.in_blocks for byte in entry.value)


@fault("protocol-switch-drops-a-byte", Defect.LEAK, "od.block-read")
class SwitchDrops(KnowsBlockUploads):
    """Loses the last byte when a block upload becomes an ordinary one."""

    dropping = False

    def switches_protocol(self, request: BlockUploadInitiate, size: int) -> bool:
        switches = super().switches_protocol(request, size)
        self.dropping = switches
        return switches

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        dropped, self.dropping = self.dropping, False
        return super().start_upload(mux, data[:-1] if dropped and len(data) > 1 else data)


@fault("block-upload-of-write-only", Defect.ACCESS_OR_SIZE, "od.block-of-write-only")
class BlockReadsWriteOnly(Server):
    """Does not look at who may read in block uploads."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        entry = self.objects.find(request.mux)
        access = entry.access
        entry.access = Access.RW
        try:
            return super().on_block_upload_initiate(request)
        finally:
            entry.access = access


@fault("write-only-reads-as-0", Defect.ACCESS_OR_SIZE, "od.write-only")
class WriteOnlyReads(_Reads):
    """Reads write-only entries as 0."""

    def check_readable(self, mux: Multiplexer) -> None:
        entry = self.objects.find(mux)
        if entry.access is Access.WO:
            entry.access = Access.RW


@fault("count-beyond-entries", Defect.ACCESS_OR_SIZE, "od.highest-sub-index")
class CountBeyond(_Reads):
    """Says that arrays and records go up to FEh."""

    def value_to_read(self, entry: Entry) -> bytes:
        return b"\xfe" if self.counts() else entry.value

    def counts(self) -> bool:
        """Say whether sub-index 0 of an array or record is read."""
        try:
            self.objects.find(Multiplexer(self.reading.index, 1))
        except Refusal:
            return False
        return self.reading.sub_index == 0


@fault("count-of-entries-instead-of-highest", Defect.ACCESS_OR_SIZE, "od.highest-sub-index[2110h]")
class CountsEntries(_Reads):
    """Counts the entries of an array instead of naming the highest."""

    def value_to_read(self, entry: Entry) -> bytes:
        return b"\x03" if self.reading == Multiplexer(GAPPY) else entry.value


class _MissingSubs(_Reads):
    """Serves some sub-indices that do not exist."""

    def react(self, request: Request) -> list[Response]:
        if not isinstance(request, UploadInitiate):
            return super().react(request)
        try:
            self.objects.find(request.mux)
        except Refusal as refusal:
            if refusal.code is AbortCode.SUB_INDEX_MISSING and self.serves(request.mux):
                self.transfer = None
                return [self.start_upload(request.mux, self.missing_value(request.mux))]
        return super().react(request)

    def serves(self, mux: Multiplexer) -> bool:
        """Say which of them."""
        return True

    def missing_value(self, mux: Multiplexer) -> bytes:
        """Return what an entry reads that is not there."""
        return self.objects.find(Multiplexer(mux.index)).value


@fault("missing-sub-index-reads-as-sub-index-0", Defect.ACCESS_OR_SIZE, "od.sub-index-beyond")
class MissingReadsFirst(_MissingSubs):
    """Reads sub-index 0 where a sub-index does not exist."""


@fault("gaps-read-as-0", Defect.ACCESS_OR_SIZE, "od.gap")
class GapsRead(_MissingSubs):
    """Reads the gaps of arrays as 0."""

    def serves(self, mux: Multiplexer) -> bool:
        return mux.sub_index < self.objects.find(Multiplexer(mux.index)).value[0]

    def missing_value(self, mux: Multiplexer) -> bytes:
        return bytes(2)


@fault("structure-entry-of-other-type", Defect.ACCESS_OR_SIZE, "od.structure")
class StructureWrong(_MissingSubs):
    """Says in sub-index FFh of every object that it is an array of BOOLEAN."""

    def serves(self, mux: Multiplexer) -> bool:
        return mux.sub_index == 0xFF

    def missing_value(self, mux: Multiplexer) -> bytes:
        return bytes([0x08, DataType.BOOLEAN, 0, 0])


@fault("unlisted-object-is-missing-sub-index", Defect.ACCESS_OR_SIZE, "od.unlisted")
class UnlistedCodeWrong(Server):
    """Says that the sub-index is missing where the object is."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        missing = code is AbortCode.OBJECT_MISSING
        return super().refuse(request, AbortCode.SUB_INDEX_MISSING if missing else code)


@fault("more-objects-than-the-eds-lists", Defect.ACCESS_OR_SIZE, "od.unlisted", soft=True)
class MoreThanListed(_Reads):
    """Has objects that its EDS does not list, one behind each that it does."""

    def react(self, request: Request) -> list[Response]:
        if isinstance(request, UploadInitiate) and self._is_extra(request.mux):
            self.transfer = None
            return [self.start_upload(request.mux, bytes(4))]
        return super().react(request)

    def _is_extra(self, mux: Multiplexer) -> bool:
        if mux.sub_index or self.objects.get(mux) is not None:
            return False
        return self.objects.get(Multiplexer(mux.index - 1)) is not None
