"""The reference server's object dictionary: entries, their types, and who may do what to them."""

import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import IntEnum, StrEnum

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH

DEFAULT_CAPACITY = 1 << 20


class DataType(IntEnum):
    """The data types of CiA 301 (7.4.7) by their index in the object dictionary."""

    BOOLEAN = 0x01
    INTEGER8 = 0x02
    INTEGER16 = 0x03
    INTEGER32 = 0x04
    UNSIGNED8 = 0x05
    UNSIGNED16 = 0x06
    UNSIGNED32 = 0x07
    REAL32 = 0x08
    VISIBLE_STRING = 0x09
    OCTET_STRING = 0x0A
    UNICODE_STRING = 0x0B
    TIME_OF_DAY = 0x0C
    TIME_DIFFERENCE = 0x0D
    DOMAIN = 0x0F
    INTEGER24 = 0x10
    REAL64 = 0x11
    INTEGER40 = 0x12
    INTEGER48 = 0x13
    INTEGER56 = 0x14
    INTEGER64 = 0x15
    UNSIGNED24 = 0x16
    UNSIGNED40 = 0x18
    UNSIGNED48 = 0x19
    UNSIGNED56 = 0x1A
    UNSIGNED64 = 0x1B

    @property
    def length(self) -> int | None:
        """The number of bytes of a value; None for strings and domains, whose length varies."""
        return _LENGTHS.get(self)


_LENGTHS = {
    DataType.BOOLEAN: 1,
    DataType.REAL32: 4,
    DataType.REAL64: 8,
    DataType.TIME_OF_DAY: 6,
    DataType.TIME_DIFFERENCE: 6,
    **{
        data_type: int(data_type.name.removeprefix("UNSIGNED").removeprefix("INTEGER")) // 8
        for data_type in DataType
        if data_type.name.startswith(("UNSIGNED", "INTEGER"))
    },
}


# What is commonly shorter than it might be; other strings and domains may have fixed lengths.
TEXT_TYPES = (DataType.VISIBLE_STRING, DataType.UNICODE_STRING)


@dataclass(frozen=True, slots=True)
class Habits:
    """How an entry reads otherwise than it was written, as was seen of a device.

    Shorter values than ``filled`` bytes are filled up with its ``padding``; ``beyond`` its room are
    these where no value of so many bytes may be written. Of longer values than ``cut`` bytes, where
    that is not 0, the first of them are kept. One that ``keeps_tails`` leaves the end of a longer
    value behind a shorter one. The last bytes of a value are left out, as many as it ``lacks``. A
    number that is ``too_long`` reads with bytes behind those that its type has, a value that is
    ``miscounted`` with another number of the 4 bytes of its answer than it has.
    """

    filled: int = 0
    beyond: bool = False
    keeps_tails: bool = False
    lacks: int = 0
    too_long: bool = False
    miscounted: bool = False
    padding: bytes = b"\0"
    cut: int = 0

    @property
    def adapts(self) -> bool:
        """Whether values are made to fit, where CiA 301 asks that they be kept or refused."""
        return self.cut > 0 or (self.filled > 0 and self.padding.strip(b"\0") != b"")

    def filling(self, data: bytes) -> bytes:
        """Return what is read where ``data`` were written, as far as it is about filling up."""
        return data.ljust(self.filled, self.padding)


AS_WRITTEN = Habits()


def same_data(
    data_type: DataType | None, found: bytes, due: bytes, habits: Habits = AS_WRITTEN
) -> bool:
    """Compare values; the 00h that ends a string is optional. None is a type that is not known.

    >>> same_data(DataType.VISIBLE_STRING, b"name", b"name" + bytes(1))
    True
    """
    if data_type is DataType.VISIBLE_STRING:
        found, due = found.rstrip(b"\0"), due.rstrip(b"\0")
    if habits.miscounted and len(due) <= EXPEDITED_LENGTH:
        return due.ljust(EXPEDITED_LENGTH, b"\0").startswith(found)
    if habits.keeps_tails or habits.too_long:
        return found.startswith(due)
    if habits.cut:
        due = due[: habits.cut]
    return found in (due, habits.filling(due), due[: len(due) - habits.lacks])


class Access(StrEnum):
    """What a client may do to an entry (CiA 306-1)."""

    RW = "rw"
    RO = "ro"
    WO = "wo"
    CONST = "const"

    @property
    def readable(self) -> bool:
        """Whether an upload is allowed."""
        return self is not Access.WO

    @property
    def writable(self) -> bool:
        """Whether a download is allowed."""
        return self in (Access.RW, Access.WO)


class Refusal(Exception):
    """The server aborts with ``code``."""

    def __init__(self, code: AbortCode) -> None:
        """Take the code that goes into the abort."""
        super().__init__(code.name)
        self.code = code


@dataclass(slots=True)
class Entry:
    """One entry: its value as it goes over the wire, and what may be written.

    ``capacity`` is the most bytes that a string or domain holds, ``fewest`` the fewest; ``low`` and
    ``high`` are limits of an integer, both included. Whether PDOs may map it follows from index and
    type where ``mappable`` is None.
    """

    value: bytes
    data_type: DataType = DataType.DOMAIN
    access: Access = Access.RW
    low: int | float | None = None
    high: int | float | None = None
    capacity: int = DEFAULT_CAPACITY
    has_data: bool = True
    fewest: int = 0
    mappable: bool | None = None

    @property
    def longest(self) -> int:
        """The most bytes that a value may have."""
        return self.data_type.length or self.capacity

    @property
    def shortest(self) -> int:
        """The fewest bytes that a value may have."""
        return self.data_type.length or self.fewest

    def check_length(self, length: int) -> None:
        """Refuse a value whose length in bytes the type does not have."""
        if length > self.longest:
            raise Refusal(AbortCode.LENGTH_TOO_HIGH)
        if length < self.shortest:
            raise Refusal(AbortCode.LENGTH_TOO_LOW)

    def number(self, data: bytes) -> int | float:
        """Return the number that bytes stand for in the type of the entry."""
        if self.data_type in (DataType.REAL32, DataType.REAL64):
            form = "<f" if self.data_type is DataType.REAL32 else "<d"
            return float(struct.unpack(form, data)[0])
        return int.from_bytes(data, "little", signed=self.data_type.name.startswith("INTEGER"))

    def check_limits(self, data: bytes) -> None:
        """Refuse a value outside the limits."""
        if self.low is None and self.high is None:
            return
        value = self.number(data)
        if self.high is not None and value > self.high:
            raise Refusal(AbortCode.VALUE_TOO_HIGH)
        if self.low is not None and value < self.low:
            raise Refusal(AbortCode.VALUE_TOO_LOW)


class ObjectDictionary:
    """Entries by multiplexer. What does not exist or may not be done is a Refusal."""

    def __init__(self, entries: dict[Multiplexer, Entry]) -> None:
        """Take the entries as they are: the server writes into them."""
        self._entries = dict(entries)
        self._indices = {mux.index for mux in entries}

    def add(self, entries: dict[Multiplexer, Entry]) -> None:
        """Add entries, in the place of those that have their multiplexers."""
        self._entries |= entries
        self._indices |= {mux.index for mux in entries}

    def remove(self, index: int) -> None:
        """Take an object out, with all its sub-indices."""
        self._entries = {mux: entry for mux, entry in self._entries.items() if mux.index != index}
        self._indices.discard(index)

    def items(self) -> Iterable[tuple[Multiplexer, Entry]]:
        """Return all entries with their multiplexers."""
        return self._entries.items()

    def __iter__(self) -> Iterator[Entry]:
        """Go through all entries."""
        return iter(self._entries.values())

    def get(self, mux: Multiplexer) -> Entry | None:
        """Return the entry, None where there is none."""
        return self._entries.get(mux)

    def find(self, mux: Multiplexer) -> Entry:
        """Return the entry, or refuse: no such object, or no such sub-index of it."""
        entry = self._entries.get(mux)
        if entry is None:
            known = mux.index in self._indices
            raise Refusal(AbortCode.SUB_INDEX_MISSING if known else AbortCode.OBJECT_MISSING)
        return entry

    def readable(self, mux: Multiplexer) -> Entry:
        """Return the entry to read from, or refuse."""
        entry = self.find(mux)
        if not entry.access.readable:
            raise Refusal(AbortCode.READ_OF_WRITE_ONLY)
        if not entry.has_data:
            raise Refusal(AbortCode.NO_DATA)
        return entry

    def writable(self, mux: Multiplexer) -> Entry:
        """Return the entry to write to, or refuse."""
        entry = self.find(mux)
        if not entry.access.writable:
            raise Refusal(AbortCode.WRITE_OF_READ_ONLY)
        return entry
