"""Nodes that are wrong in their objects for errors, SYNC, TIME, EMCY and PDOs."""

from collections.abc import Iterable
from functools import partial

from conformance.faults import registry
from conformance.faults.altered_nodes import AlteredNode
from conformance.faults.block_servers import KnowsBlockUploads
from conformance.faults.registry import About, Defect
from conformance.reference.communication import (
    EMERGENCY,
    PRODUCES,
    RECEIVED,
    SENT,
    SYNC,
    TIME,
    Mapping,
)
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.channel_parameters import Check, CheckedEntry
from conformance.sdo.cob_id import EXTENDED, CobId
from conformance.sdo.emergency import ERROR_LIST, ERROR_REGISTER
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry, Refusal
from conformance.sdo.pdos import MAPPING_OF, Mapped
from conformance.sdo.storage_commands import COMMANDS

fault = partial(registry.fault, about=About.OBJECTS)
COB_IDS = (SYNC, TIME, EMERGENCY, Multiplexer(RECEIVED, 1), Multiplexer(SENT, 1))


class _Checks(AlteredNode):
    """Checks some entries otherwise."""

    entries: tuple[Multiplexer, ...] = ()

    def alter(self) -> None:
        for mux in self.entries:
            entry = self.objects.get(mux)
            if isinstance(entry, CheckedEntry):
                entry.check = self.check

    def check(self, old: bytes, new: bytes) -> None:
        """Take anything."""


class _Passes(AlteredNode):
    """Checks COB-IDs as it should, all but some."""

    def alter(self) -> None:
        for mux in COB_IDS:
            entry = self.objects.get(mux)
            if isinstance(entry, CheckedEntry):
                entry.check = partial(self.check, entry.check)

    def check(self, right: Check, old: bytes, new: bytes) -> None:
        """Refuse what a ``right`` server refuses."""
        right(old, new)


@fault("vendor-id-0", Defect.ACCESS_OR_SIZE, "communication.vendor-id")
class VendorId0(AlteredNode):
    """Has no vendor-ID."""

    def alter(self) -> None:
        self.objects.find(Multiplexer(0x1018, 1)).value = bytes(4)


@fault("error-register-without-generic", Defect.ACCESS_OR_SIZE, "communication.error-register")
class RegisterWithoutGeneric(AlteredNode):
    """Tells of a communication error in 1001h and leaves bit 0 out."""

    def alter(self) -> None:
        self.objects.add({ERROR_REGISTER: Entry(b"\x10", DataType.UNSIGNED8, Access.RO)})


@fault("storage-capability-as-text", Defect.ACCESS_OR_SIZE, "communication.storage-capability")
class CapabilityAsText(AlteredNode):
    """Reads "save" and "load" in 1010h:01 and 1011h:01, as it was written."""

    def alter(self) -> None:
        for index in COMMANDS:
            for mux, entry in self.objects.items():
                if mux == Multiplexer(index, 1):
                    entry.value = b"save"


@fault("stored-eds-empty", Defect.ACCESS_OR_SIZE, "communication.stored-eds")
class StoredEdsEmpty(AlteredNode):
    """Has no EDS in 1021h, which it serves."""

    def alter(self) -> None:
        self.objects.find(Multiplexer(0x1021)).value = b"not available"


@fault("stored-eds-cut-in-blocks", Defect.FIELD_WIDTH, "communication.stored-eds")
class StoredEdsCut(KnowsBlockUploads):
    """Sends the first 100 bytes of what is longer and read-only in blocks."""

    def value_to_read(self, entry: Entry) -> bytes:
        cut = self.in_blocks and entry.access is Access.RO
        return entry.value[:100] if cut else entry.value


@fault("error-list-not-cleared", Defect.ACCESS_OR_SIZE, "communication.error-list-cleared")
class ListNotCleared(_Checks):
    """Refuses to clear its list of errors."""

    entries = (Multiplexer(ERROR_LIST),)

    def check(self, old: bytes, new: bytes) -> None:
        raise Refusal(AbortCode.VALUE_INVALID)


@fault("error-list-takes-counts", Defect.ACCESS_OR_SIZE, "communication.error-list-count")
class ListTakesCounts(_Checks):
    """Takes any number of errors for 1003h:00."""

    entries = (Multiplexer(ERROR_LIST),)


@fault(
    "communication-restricted-identifier",
    Defect.ACCESS_OR_SIZE,
    "communication.restricted-identifier",
)
class Restricted(_Checks):
    """Takes CAN-IDs that are kept for other services for SYNC, TIME, EMCY and PDOs."""

    entries = COB_IDS

    def check(self, old: bytes, new: bytes) -> None:
        if CobId.from_bytes(new).has_stray_bits:
            raise Refusal(AbortCode.VALUE_INVALID)


class _TakesRange(_Passes):
    """Takes some CAN-IDs that are kept for another service."""

    first, last = 0, 0

    def check(self, right: Check, old: bytes, new: bytes) -> None:
        if not self.first <= CobId.from_bytes(new).can_id <= self.last:
            right(old, new)


@fault(
    "communication-nmt-identifier",
    Defect.ACCESS_OR_SIZE,
    "communication.restricted-identifier",
)
class NmtIdentifier(_TakesRange):
    """Takes 000h, on which NMT commands come, for SYNC, TIME, EMCY and PDOs."""


@fault(
    "communication-sdo-identifiers",
    Defect.ACCESS_OR_SIZE,
    "communication.restricted-identifier",
)
class SdoIdentifiers(_TakesRange):
    """Takes 601h to 67Fh, on which requests to other nodes come, for SYNC, TIME, EMCY and PDOs."""

    first, last = 0x601, 0x67F


@fault("communication-identifier-bits", Defect.ACCESS_OR_SIZE, "communication.identifier-bits")
class StrayBits(_Passes):
    """Ignores bits 28 to 11 of the COB-IDs of SYNC, TIME, EMCY and PDOs."""

    def check(self, right: Check, old: bytes, new: bytes) -> None:
        low = int.from_bytes(new, "little") & ~(0x1FFF_FFFF & ~0x7FF)
        right(old, low.to_bytes(4, "little"))


@fault("communication-valid-moved", Defect.ACCESS_OR_SIZE, "communication.valid-keeps-identifier")
class ValidMoved(_Passes):
    """Lets the COB-IDs of SYNC, TIME, EMCY and PDOs move while they are in use."""

    def check(self, right: Check, old: bytes, new: bytes) -> None:
        right(new, new)


@fault(
    "cob-id-flags-lost",
    Defect.ACCESS_OR_SIZE,
    "communication.extended-bit",
    "communication.sync-producer",
    "communication.remote-bit",
)
class FlagsLost(Server):
    """Takes the COB-IDs of SYNC, TIME, EMCY and PDOs and leaves their bits 29 and 30 out."""

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data)
        if any(entry is self.objects.get(mux) for mux in COB_IDS):
            number = int.from_bytes(data, "little") & ~(EXTENDED | PRODUCES)
            entry.value = number.to_bytes(4, "little")


@fault("pdo-reserved-entry-served", Defect.ACCESS_OR_SIZE, "communication.reserved-entry")
class ReservedEntry(AlteredNode):
    """Serves sub-index 04h of 1800h."""

    def alter(self) -> None:
        self.objects.add({Multiplexer(SENT, 4): Entry(b"\0", DataType.UNSIGNED8)})


@fault("pdo-transmission-type-any", Defect.ACCESS_OR_SIZE, "communication.transmission-type")
class AnyType(_Checks):
    """Takes any transmission type."""

    entries = (Multiplexer(RECEIVED, 2), Multiplexer(SENT, 2))


class _MappingOf(Mapping):
    """Maps what it should not."""

    def check_mapped(self, mapped: Mapped) -> None:
        """Map anything."""


class _LongMapping(Mapping):
    """Maps too much."""

    def check_length(self, lengths: Iterable[int]) -> None:
        """Map any number of bytes."""


class _Mappings(AlteredNode):
    """Maps otherwise."""

    mapping: type[Mapping] = Mapping

    def alter(self) -> None:
        for index in (RECEIVED, SENT):
            self.mapping(self.objects, index + MAPPING_OF).attach()


@fault("pdo-maps-missing-object", Defect.ACCESS_OR_SIZE, "communication.mapped-object")
class MapsMissing(_Mappings):
    """Maps objects that do not exist."""

    mapping = _MappingOf


@fault("pdo-maps-more-than-8-bytes", Defect.ACCESS_OR_SIZE, "communication.mapped-length")
class MapsTooMuch(_Mappings):
    """Maps 12 bytes."""

    mapping = _LongMapping
