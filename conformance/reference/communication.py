"""The reference node's objects for SYNC, TIME, EMCY and PDOs: what they may be configured to.

The node sends and takes none of these; it only checks what is written.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import takewhile

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.channel_parameters import Check, CheckedEntry
from conformance.sdo.cob_id import DYNAMIC, NOT_VALID, CobId
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import EMERGENCY_BASE
from conformance.sdo.objects import Access, DataType, Entry, ObjectDictionary, Refusal
from conformance.sdo.pdos import (
    COB_ID,
    INHIBIT_TIME,
    MAPPING_OF,
    MOST_BITS,
    MOST_MAPPED,
    RECEIVED_MAPPINGS,
    RESERVED_TYPES,
    SYNC_START,
    Mapped,
)

SYNC, TIME, EMERGENCY = Multiplexer(0x1005), Multiplexer(0x1012), Multiplexer(0x1014)
RECEIVED, SENT = 0x1400, 0x1800
SYNC_ID, TIME_ID = 0x080, 0x100
RECEIVED_BASE, SENT_BASE = 0x200, 0x180
PRODUCES, CONSUMES = DYNAMIC, NOT_VALID
EVENT_DRIVEN = b"\xff"
ENTRIES = 3
_PLACES = range(1, MOST_MAPPED + 1)
FIRST_MAPPABLE = 0x2000

InUse = Callable[[int], bool]


def cob_id_check(in_use: InUse, is_used: InUse | None = None) -> Check:
    """Return what refuses a COB-ID: ``in_use`` says of a value whether it may not be moved.

    ``is_used`` says whether it means an object at all, if that is another question: without one,
    000h may stand there.
    """
    exists = is_used or in_use

    def check(old: bytes, new: bytes) -> None:
        before, wanted = CobId.from_bytes(old), CobId.from_bytes(new)
        same = (before.can_id, before.extended) == (wanted.can_id, wanted.extended)
        moved = in_use(_number(old)) and not same
        restricted = wanted.is_restricted and (wanted.can_id or exists(_number(new)))
        if wanted.has_stray_bits or moved or restricted:
            raise Refusal(AbortCode.VALUE_INVALID)

    return check


def sync_in_use(number: int) -> bool:
    """Say whether SYNC is produced."""
    return bool(number & PRODUCES)


def always(number: int) -> bool:
    """Say of SYNC that it is consumed: no bit says that it is not."""
    return True


def time_in_use(number: int) -> bool:
    """Say whether TIME is produced or consumed."""
    return bool(number & (PRODUCES | CONSUMES))


def is_valid(number: int) -> bool:
    """Say whether an EMCY or a PDO exists."""
    return not number & NOT_VALID


def type_check(old: bytes, new: bytes) -> None:
    """Refuse a transmission type that has no meaning."""
    if new[0] in RESERVED_TYPES:
        raise Refusal(AbortCode.VALUE_INVALID)


def while_invalid(cob_id: Entry) -> Check:
    """Return what refuses every change as long as a PDO is valid (7.5.2.37)."""

    def check(old: bytes, new: bytes) -> None:
        if new != old and is_valid(_number(cob_id.value)):
            raise Refusal(AbortCode.DEVICE_STATE)

    return check


def is_mappable(mux: Multiplexer, entry: Entry) -> bool:
    """Say whether a PDO may map an entry, by itself a number of the application."""
    if entry.mappable is not None:
        return entry.mappable
    return mux.index >= FIRST_MAPPABLE and entry.data_type.length is not None


def communication_entries(node_id: int, received: Mapped, sent: Mapped) -> dict[Multiplexer, Entry]:
    """Return the objects for SYNC, TIME, EMCY and one PDO in each direction with what it maps."""
    sent_id = _cob_id(DYNAMIC | SENT_BASE + node_id, is_valid)
    return {
        SYNC: _cob_id(SYNC_ID, sync_in_use, always),
        TIME: _cob_id(CONSUMES | TIME_ID, time_in_use),
        EMERGENCY: _cob_id(EMERGENCY_BASE + node_id, is_valid),
        **_pdo(RECEIVED, _cob_id(RECEIVED_BASE + node_id, is_valid), received),
        **_pdo(SENT, sent_id, sent),
        Multiplexer(SENT): Entry(bytes([SYNC_START]), DataType.UNSIGNED8, Access.CONST),
        Multiplexer(SENT, INHIBIT_TIME): CheckedEntry(
            bytes(2), DataType.UNSIGNED16, check=while_invalid(sent_id)
        ),
        Multiplexer(SENT, SYNC_START): CheckedEntry(
            bytes(1), DataType.UNSIGNED8, check=while_invalid(sent_id)
        ),
    }


def _cob_id(number: int, in_use: InUse, is_used: InUse | None = None) -> Entry:
    value = number.to_bytes(4, "little")
    return CheckedEntry(value, DataType.UNSIGNED32, check=cob_id_check(in_use, is_used))


def _pdo(index: int, cob_id: Entry, mapped: Mapped) -> dict[Multiplexer, Entry]:
    mapping = index + MAPPING_OF
    entries: dict[Multiplexer, Entry] = {
        Multiplexer(index): Entry(b"\2", DataType.UNSIGNED8, Access.CONST),
        Multiplexer(index, COB_ID): cob_id,
        Multiplexer(index, 2): CheckedEntry(EVENT_DRIVEN, DataType.UNSIGNED8, check=type_check),
        Multiplexer(mapping): CheckedEntry(b"\1", DataType.UNSIGNED8),
    }
    for sub in range(1, ENTRIES + 1):
        value = (int(mapped) if sub == 1 else 0).to_bytes(4, "little")
        entries[Multiplexer(mapping, sub)] = CheckedEntry(value, DataType.UNSIGNED32)
    return entries


@dataclass(slots=True)
class Mapping:
    """What one PDO maps: a change takes a PDO that is not valid, and a number of entries of 0."""

    objects: ObjectDictionary
    index: int
    count: Entry = field(init=False)
    most: int = field(init=False)

    def __post_init__(self) -> None:
        self.count = self.objects.find(Multiplexer(self.index))
        there = (self.objects.get(Multiplexer(self.index, sub)) for sub in _PLACES)
        self.most = sum(1 for _ in takewhile(bool, there))

    def attach(self) -> None:
        """Let the entries ask before they change."""
        for sub in range(self.most + 1):
            entry = self.objects.get(Multiplexer(self.index, sub))
            if isinstance(entry, CheckedEntry):
                entry.check = self.check_entry if sub else self.check_count

    def check_entry(self, old: bytes, new: bytes) -> None:
        """Refuse what cannot be mapped, and any other entry while some are in use."""
        if new == old:
            return
        self.check_changeable()
        self.check_unused()
        if any(new):
            self.check_mapped(Mapped.of(_number(new)))

    def check_mapped(self, mapped: Mapped) -> None:
        """Refuse an object that is not there, that has another length, or that no PDO may map."""
        entry = self.objects.get(mapped.mux)
        if entry is None or (entry.data_type.length or 0) * 8 != mapped.bits:
            raise Refusal(AbortCode.NOT_MAPPABLE)
        if not (self.may_map(mapped.mux, entry) and self.has_access(entry)):
            raise Refusal(AbortCode.NOT_MAPPABLE)

    def may_map(self, mux: Multiplexer, entry: Entry) -> bool:
        """Say whether any PDO may map an entry."""
        return is_mappable(mux, entry)

    def has_access(self, entry: Entry) -> bool:
        """Say whether a PDO in this direction may read or write an entry."""
        received = self.index in RECEIVED_MAPPINGS
        return entry.access.writable if received else entry.access.readable

    def check_count(self, old: bytes, new: bytes) -> None:
        """Refuse more entries than there are, and more bytes than a frame holds."""
        if new == old:
            return
        self.check_changeable()
        if new[0] > self.most:
            raise Refusal(AbortCode.MAPPING_TOO_LONG)
        self.check_length(
            _number(self.objects.find(Multiplexer(self.index, sub)).value) & 0xFF
            for sub in range(1, new[0] + 1)
        )

    def check_length(self, lengths: Iterable[int]) -> None:
        """Refuse more bits than a frame holds."""
        if sum(lengths) > MOST_BITS:
            raise Refusal(AbortCode.MAPPING_TOO_LONG)

    def check_unused(self) -> None:
        """Refuse a change of entries as long as some are in use."""
        if any(self.count.value):
            raise Refusal(AbortCode.DEVICE_STATE)

    def check_changeable(self) -> None:
        """Refuse a change while the PDO is valid."""
        cob_id = self.objects.get(Multiplexer(self.index - MAPPING_OF, 1))
        if cob_id is not None and is_valid(_number(cob_id.value)):
            raise Refusal(AbortCode.DEVICE_STATE)


def _number(value: bytes) -> int:
    return int.from_bytes(value, "little")
