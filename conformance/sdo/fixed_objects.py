"""The objects that CiA 301 itself defines: their entries, types, and access, as data (7.5.2).

A device need not have them, apart from the mandatory ones. What it has at these indices is as it
stands here, whatever its EDS says. Objects of which the editions of CiA 301 say different things
are left out.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType
from conformance.sdo.rules import Rule
from conformance.sdo.rules.channels import DEFAULT_READ_ONLY
from conformance.sdo.rules.communication import ERROR_LIST_COUNT
from conformance.sdo.rules.idle import READ_ONLY
from conformance.sdo.rules.object_dictionary import SIGNATURE
from conformance.sdo.storage_commands import LOAD, SAVE

U8, U16, U32 = DataType.UNSIGNED8, DataType.UNSIGNED16, DataType.UNSIGNED32
TEXT = DataType.VISIBLE_STRING
RW, RO, WO, CONST = Access.RW, Access.RO, Access.WO, Access.CONST
# It is in no list of entries: every object may have it (7.4.2).
STRUCTURE = 0xFF


@dataclass(frozen=True, slots=True)
class FixedEntry:
    """An entry as CiA 301 defines it.

    ``access`` is the widest: an entry that is rw here may be read-only in a device. Where it is ro
    or const every download is refused, by the rule ``read_only``; what is const keeps its value
    until the node is reset. ``takes`` are the only values that a download may bring, by the rule
    ``takes_by``; None for any. A ``data_type`` of None is open.
    """

    data_type: DataType | None
    access: Access
    read_only: Rule = READ_ONLY
    takes: frozenset[bytes] | None = None
    takes_by: Rule | None = None


@dataclass(frozen=True, slots=True)
class FixedObject:
    """One object, or a row of them that are alike; ``entries`` are those that it may have."""

    indices: range
    clause: str
    entries: tuple[tuple[range, FixedEntry], ...]
    mandatory: bool = False

    def entry(self, sub_index: int) -> FixedEntry | None:
        """Return an entry; None for one that no device may have."""
        if sub_index == STRUCTURE:
            return _STRUCTURE_ENTRY
        return next((entry for subs, entry in self.entries if sub_index in subs), None)

    @property
    def is_variable(self) -> bool:
        """Whether it has sub-index 0 only."""
        return self.entry(1) is None

    @property
    def first_forbidden(self) -> int | None:
        """The first sub-index that no such object has; None if it may have all of them."""
        return next((sub for sub in range(STRUCTURE) if self.entry(sub) is None), None)

    def __iter__(self) -> Iterator[tuple[int, FixedEntry]]:
        """Yield the sub-indices of the entries, each with its entry."""
        for sub_indices, entry in self.entries:
            for sub_index in sub_indices:
                yield sub_index, entry


_STRUCTURE_ENTRY = FixedEntry(U32, RO)
_COUNT = FixedEntry(U8, CONST)
_ANY_ENTRY = FixedEntry(None, RW)


def _variable(
    index: int, clause: str, data_type: DataType, access: Access, *, mandatory: bool = False
) -> FixedObject:
    entries = ((range(1), FixedEntry(data_type, access)),)
    return FixedObject(range(index, index + 1), f"7.5.2.{clause}", entries, mandatory)


def _array(index: int, clause: str, highest: int, entry: FixedEntry) -> FixedObject:
    entries = ((range(1), _COUNT), (range(1, highest + 1), entry))
    return FixedObject(range(index, index + 1), f"7.5.2.{clause}", entries)


def _records(
    first: int, last: int, clause: str, *entries: FixedEntry, count: FixedEntry = _COUNT
) -> FixedObject:
    """Return records of which each entry from sub-index 01h on is given."""
    numbered = ((range(sub, sub + 1), entry) for sub, entry in enumerate((count, *entries)))
    return FixedObject(range(first, last + 1), f"7.5.2.{clause}", tuple(numbered))


def _command(signature: bytes) -> FixedEntry:
    return FixedEntry(U32, RW, takes=frozenset((signature,)), takes_by=SIGNATURE)


_DEFAULT_CHANNEL = FixedEntry(U32, RO, read_only=DEFAULT_READ_ONLY)
_MAPPING = ((range(1), FixedEntry(U8, RW)), (range(1, 0x41), FixedEntry(U32, RW)))

FIXED_OBJECTS = (
    _variable(0x1000, "1", U32, RO, mandatory=True),
    _variable(0x1001, "2", U8, RO, mandatory=True),
    _variable(0x1002, "3", U32, RO),
    FixedObject(
        range(0x1003, 0x1004),
        "7.5.2.4",
        (
            (range(1), FixedEntry(U8, RW, takes=frozenset((b"\0",)), takes_by=ERROR_LIST_COUNT)),
            (range(1, 0xFF), FixedEntry(U32, RO)),
        ),
    ),
    _variable(0x1005, "5", U32, RW),
    _variable(0x1006, "6", U32, RW),
    _variable(0x1007, "7", U32, RW),
    _variable(0x1008, "8", TEXT, CONST),
    _variable(0x1009, "9", TEXT, CONST),
    _variable(0x100A, "10", TEXT, CONST),
    _variable(0x100C, "11", U16, RW),
    _variable(0x100D, "12", U8, RW),
    _array(0x1010, "13", 0x7F, _command(SAVE)),
    _array(0x1011, "14", 0x7F, _command(LOAD)),
    _variable(0x1012, "15", U32, RW),
    _variable(0x1013, "16", U32, RW),
    _variable(0x1014, "17", U32, RW),
    _variable(0x1015, "18", U16, RW),
    _array(0x1016, "19", 0x7F, FixedEntry(U32, RW)),
    _variable(0x1017, "20", U16, RW),
    # The vendor-ID stays; product, revision and serial number are read-only.
    replace(
        _records(0x1018, 0x1018, "21", FixedEntry(U32, CONST), *(FixedEntry(U32, RO),) * 3),
        mandatory=True,
    ),
    _variable(0x1019, "22", U8, RW),
    _array(0x1020, "23", 2, FixedEntry(U32, RW)),
    _variable(0x1021, "24", DataType.DOMAIN, RO),
    _array(0x1028, "31", 0x7F, FixedEntry(U32, RW)),
    _array(0x1029, "32", 0xFE, FixedEntry(U8, RW)),
    # DS-301 up to 4.02 has the node-ID of a client in the record of the default channel, too.
    _records(
        0x1200, 0x1200, "33", _DEFAULT_CHANNEL, _DEFAULT_CHANNEL, FixedEntry(U8, RW),
        count=FixedEntry(U8, CONST, read_only=DEFAULT_READ_ONLY),
    ),
    _records(0x1201, 0x127F, "33", FixedEntry(U32, RW), FixedEntry(U32, RW), FixedEntry(U8, RW)),
    _records(0x1280, 0x12FF, "34", FixedEntry(U32, RW), FixedEntry(U32, RW), FixedEntry(U8, RW)),
    # Of 04h, 301 says "reserved", and DS-301 4.02 "compatibility entry".
    _records(
        0x1400, 0x15FF, "35", FixedEntry(U32, RW), FixedEntry(U8, RW), FixedEntry(U16, RW),
        _ANY_ENTRY, FixedEntry(U16, RW), FixedEntry(U8, RW),
    ),
    FixedObject(range(0x1600, 0x1800), "7.5.2.36", _MAPPING),
    _records(
        0x1800, 0x19FF, "37", FixedEntry(U32, RW), FixedEntry(U8, RW), FixedEntry(U16, RW),
        _ANY_ENTRY, FixedEntry(U16, RW), FixedEntry(U8, RW),
    ),
    FixedObject(range(0x1A00, 0x1C00), "7.5.2.38", _MAPPING),
)  # fmt: skip
_INDICES = range(0x1000, 0x1C00)


@cache
def object_at(index: int) -> FixedObject | None:
    """Return the object at an index; None where CiA 301 defines none, or the editions differ."""
    if index not in _INDICES:
        return None
    return next((each for each in FIXED_OBJECTS if index in each.indices), None)


def entry_at(mux: Multiplexer) -> FixedEntry | None:
    """Return how CiA 301 defines an entry; None where it says nothing of it, or forbids it."""
    found = object_at(mux.index)
    return None if found is None else found.entry(mux.sub_index)


def is_forbidden(mux: Multiplexer) -> bool:
    """Say whether an object of CiA 301 has no such entry in any device: 1000h:01."""
    found = object_at(mux.index)
    return found is not None and found.entry(mux.sub_index) is None
