"""The list of an EDS: objects, their entries, and the properties of each (CiA 306-1)."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum

from conformance.device.known_objects import KnownObject
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType

STRUCTURE_OF_OBJECT = 0xFF
MANDATORY = (
    KnownObject(Multiplexer(0x1000), DataType.UNSIGNED32, Access.RO),
    KnownObject(Multiplexer(0x1001), DataType.UNSIGNED8, Access.RO),
    KnownObject(Multiplexer(0x1018, 0), DataType.UNSIGNED8, Access.CONST),
    KnownObject(Multiplexer(0x1018, 1), DataType.UNSIGNED32, Access.CONST),
)


class ObjectType(IntEnum):
    """The object codes of CiA 301 (7.4.3) that an object of a device may have."""

    DOMAIN = 0x02
    VAR = 0x07
    ARRAY = 0x08
    RECORD = 0x09


@dataclass(frozen=True, slots=True)
class ListedObject:
    """One index: its entries by sub-index. A type code of None is not stated.

    The ``unclear`` sub-indices exist, and no case is about them: the file describes them in a way
    that cannot be read, or contradicts itself. An unclear sub-index 0 stands for the highest
    sub-index, FFh for the type of the object.
    """

    index: int
    object_type: ObjectType
    entries: Mapping[int, KnownObject]
    name: str = ""
    type_code: int | None = None
    unclear: frozenset[int] = frozenset()

    @property
    def is_structured(self) -> bool:
        """Whether the object has sub-indices, and their highest in sub-index 0."""
        return self.object_type in (ObjectType.ARRAY, ObjectType.RECORD)

    @property
    def highest(self) -> int:
        """The highest sub-index, that of the structure (FFh) left out."""
        there = self.unclear.union(self.entries)
        return max((sub for sub in there if sub != STRUCTURE_OF_OBJECT), default=0)

    @property
    def gaps(self) -> list[int]:
        """The sub-indices below the highest that are not listed."""
        there = self.unclear.union(self.entries)
        return [sub for sub in range(1, self.highest) if sub not in there]


@dataclass(frozen=True, slots=True)
class Listing:
    """All that is known of the objects of a device before anything was asked.

    ``is_complete`` says that an object that is not listed does not exist: an EDS lists everything.
    The ``identity`` of the device in the EDS is by sub-index of 1018h. If the user asked for it,
    the device is ``to_scan``: all indices are read, listed or not. ``revision`` is the version of
    the EDS itself.
    """

    objects: Mapping[int, ListedObject] = field(default_factory=dict)
    is_complete: bool = False
    identity: Mapping[int, int] = field(default_factory=dict)
    to_scan: bool = False
    revision: str = ""

    @property
    def entries(self) -> list[KnownObject]:
        """All entries, in the order of their multiplexers."""
        return [
            known
            for _, listed in sorted(self.objects.items())
            for _, known in sorted(listed.entries.items())
        ]

    def find(self, mux: Multiplexer) -> KnownObject | None:
        """Return an entry, or None where it is not listed."""
        listed = self.objects.get(mux.index)
        return listed.entries.get(mux.sub_index) if listed else None


def mandatory_and(named: Iterable[KnownObject]) -> Listing:
    """Return the listing without an EDS: the objects of every device, and those of the user."""
    by_index: defaultdict[int, dict[int, KnownObject]] = defaultdict(dict)
    for known in (*MANDATORY, *named):
        if known.data_type is not None:
            by_index[known.mux.index][known.mux.sub_index] = known
    return Listing(
        {
            index: ListedObject(
                index, ObjectType.RECORD if max(entries) else ObjectType.VAR, entries
            )
            for index, entries in by_index.items()
        }
    )
