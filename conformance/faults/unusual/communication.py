"""Nodes that are right in their objects for SYNC, TIME, EMCY and PDOs in their own way."""

from functools import partial

from conformance.faults import registry
from conformance.faults.altered_nodes import AlteredNode
from conformance.faults.registry import About
from conformance.reference.communication import (
    EMERGENCY,
    ENTRIES,
    PRODUCES,
    RECEIVED,
    SENT,
    SYNC,
    TIME,
    Mapping,
    is_valid,
)
from conformance.reference.dictionary import TYPES
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.channel_parameters import Check, CheckedEntry
from conformance.sdo.cob_id import EXTENDED, NOT_VALID
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry, Refusal
from conformance.sdo.pdos import (
    COB_ID,
    INHIBIT_TIME,
    MAPPING_OF,
    MULTIPLEXED,
    SYNC_START,
    Mapped,
)

unusual = partial(registry.unusual, about=About.OBJECTS)
DUMMY = Mapped(Multiplexer(DataType.UNSIGNED8), bits=8)
BIT = Mapped(Multiplexer(TYPES, 1), bits=1)


@unusual("pdo-compatibility-entry")
class CompatibilityEntry(AlteredNode):
    """Has sub-index 04h of 1800h, as DS-301 4.02 has it, and in its EDS."""

    def alter(self) -> None:
        self.objects.add({Multiplexer(SENT, 4): Entry(b"\0", DataType.UNSIGNED8)})
        count = self.objects.find(Multiplexer(SENT))
        count.value = max(count.value, b"\4")
        self.defaults = self.power_on = self.present()


@unusual("pdo-mapping-fixed")
class FixedMapping(AlteredNode):
    """Maps an object for ever, and lists places for more of them in its EDS."""

    def alter(self) -> None:
        for index in (RECEIVED + MAPPING_OF, SENT + MAPPING_OF):
            for mux, entry in self.objects.items():
                if mux.index == index:
                    entry.access = Access.CONST


class _Multiplexed(FixedMapping):
    """Has multiplexed PDOs of one kind."""

    kind = 0

    def alter(self) -> None:
        super().alter()
        for index in (RECEIVED + MAPPING_OF, SENT + MAPPING_OF):
            self.objects.find(Multiplexer(index)).value = bytes([self.kind])
        self.defaults = self.power_on = self.present()


@unusual("pdo-multiplexed-by-list")
class MultiplexedByList(_Multiplexed):
    """Has multiplexed PDOs (MPDO) of source addressing: FEh in the place of a number of entries."""

    kind = MULTIPLEXED[0]


@unusual("pdo-multiplexed-by-address")
class MultiplexedByAddress(_Multiplexed):
    """Has multiplexed PDOs (MPDO) of destination addressing: FFh in the place of a number."""

    kind = MULTIPLEXED[1]


@unusual("cob-id-flags-refused")
class FlagsRefused(AlteredNode):
    """Refuses COB-IDs of 29 bits, to produce SYNC, and to change bit 30 of a PDO."""

    def alter(self) -> None:
        for mux in (
            SYNC,
            TIME,
            EMERGENCY,
            Multiplexer(RECEIVED, COB_ID),
            Multiplexer(SENT, COB_ID),
        ):
            entry = self.objects.find(mux)
            if isinstance(entry, CheckedEntry):
                kept = EXTENDED if mux == TIME else EXTENDED | PRODUCES
                entry.check = partial(self.check, entry.check, kept)

    def check(self, known: Check, kept: int, old: bytes, new: bytes) -> None:
        """Refuse to change some bits, then whatever else is refused."""
        changed = int.from_bytes(old, "little") ^ int.from_bytes(new, "little")
        if changed & kept:
            raise Refusal(AbortCode.VALUE_INVALID)
        known(old, new)


class _CheckedAtTheEnd(Mapping):
    """Takes any entries, and refuses the number of them."""

    def check_mapped(self, mapped: Mapped) -> None:
        """Take it for now."""

    def check_count(self, old: bytes, new: bytes) -> None:
        super().check_count(old, new)
        for sub_index in range(1, new[0] + 1):
            entry = self.objects.find(Multiplexer(self.index, sub_index))
            super().check_mapped(Mapped.of(int.from_bytes(entry.value, "little")))


class _OtherCodes(Mapping):
    """Refuses a change by another code."""

    def check_unused(self) -> None:
        if any(self.count.value):
            raise Refusal(AbortCode.UNSUPPORTED_ACCESS)

    def check_changeable(self) -> None:
        try:
            super().check_changeable()
        except Refusal:
            raise Refusal(AbortCode.UNSUPPORTED_ACCESS) from None


class _Mappings(AlteredNode):
    """Checks mappings in another way."""

    mapping: type[Mapping] = Mapping

    def alter(self) -> None:
        for index in (RECEIVED + MAPPING_OF, SENT + MAPPING_OF):
            self.mapping(self.objects, index).attach()


@unusual("pdo-mapping-checked-at-the-end")
class CheckedAtTheEnd(_Mappings):
    """Takes any entries of a mapping, and refuses the number of them."""

    mapping = _CheckedAtTheEnd


@unusual("pdo-changes-are-unsupported-access")
class OtherCodes(_Mappings):
    """Calls a change of a mapping in use an unsupported access, and one of its times invalid."""

    mapping = _OtherCodes

    def alter(self) -> None:
        super().alter()
        cob_id = self.objects.find(Multiplexer(SENT, COB_ID))
        for sub_index in (INHIBIT_TIME, SYNC_START):
            entry = self.objects.find(Multiplexer(SENT, sub_index))
            if isinstance(entry, CheckedEntry):
                entry.check = partial(self.check, cob_id)

    def check(self, cob_id: Entry, old: bytes, new: bytes) -> None:
        """Refuse a change of a valid PDO."""
        if new != old and is_valid(int.from_bytes(cob_id.value, "little")):
            raise Refusal(AbortCode.VALUE_INVALID)


class _RefusesAnyWrite(_OtherCodes):
    """Refuses what is there already as well."""

    def check_entry(self, old: bytes, new: bytes) -> None:
        self.check_changeable()
        self.check_unused()
        super().check_entry(old, new)

    def check_count(self, old: bytes, new: bytes) -> None:
        self.check_changeable()
        super().check_count(old, new)


@unusual("pdo-in-use-refuses-any-write")
class RefusesAnyWrite(OtherCodes):
    """Refuses even their own values for what may not change while a PDO is valid.

    Its EDS states limits for them.
    """

    mapping = _RefusesAnyWrite

    def alter(self) -> None:
        super().alter()
        limits = {
            Multiplexer(RECEIVED + MAPPING_OF): ENTRIES,
            Multiplexer(SENT + MAPPING_OF): ENTRIES,
            Multiplexer(SENT, INHIBIT_TIME): 0x7FFF,
            Multiplexer(SENT, SYNC_START): 240,
        }
        for mux, high in limits.items():
            entry = self.objects.find(mux)
            entry.low, entry.high = 0, high

    def check(self, cob_id: Entry, old: bytes, new: bytes) -> None:
        """Refuse any value of a valid PDO."""
        if is_valid(int.from_bytes(cob_id.value, "little")):
            raise Refusal(AbortCode.VALUE_INVALID)


@unusual("pdo-maps-dummy-and-bit")
class MapsDummyAndBit(AlteredNode):
    """Maps a dummy for 8 bits that it receives and has no use for, and 1 bit of a BOOLEAN."""

    def alter(self) -> None:
        self.objects.find(Multiplexer(RECEIVED + MAPPING_OF, 2)).value = bytes(DUMMY)
        self.objects.find(Multiplexer(RECEIVED + MAPPING_OF)).value = b"\2"
        self.objects.find(Multiplexer(SENT + MAPPING_OF, 1)).value = bytes(BIT)
        self.defaults = self.power_on = self.present()


@unusual("pdo-not-in-use")
class NotInUse(AlteredNode):
    """Has PDOs that are not valid and map nothing until they are configured."""

    def alter(self) -> None:
        for index in (RECEIVED, SENT):
            cob_id = self.objects.find(Multiplexer(index, COB_ID))
            number = int.from_bytes(cob_id.value, "little") | NOT_VALID
            cob_id.value = number.to_bytes(4, "little")
            self.objects.find(Multiplexer(index + MAPPING_OF)).value = b"\0"
            self.objects.find(Multiplexer(index + MAPPING_OF, 1)).value = bytes(4)
        self.defaults = self.power_on = self.present()
