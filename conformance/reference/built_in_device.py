"""The built-in device: the objects that transfers are tested on, and how the suite knows them."""

from conformance.device.known_objects import KnownObject
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry

UNSIGNED = {
    1: DataType.UNSIGNED8,
    2: DataType.UNSIGNED16,
    3: DataType.UNSIGNED24,
    4: DataType.UNSIGNED32,
    8: DataType.UNSIGNED64,
}


def reference_entries(node_id: int) -> dict[Multiplexer, Entry]:
    """Return the entries of the built-in device that transfers are tested on."""
    entries = {
        Multiplexer(0x1000): _number(4, 0x000F_0191, Access.CONST),
        Multiplexer(0x1001): _number(1, 0, Access.RO),
        Multiplexer(0x1008): _text(b"Conformance reference server", Access.CONST),
        Multiplexer(0x1009): _text(b"rev", Access.CONST),
        Multiplexer(0x100A): _text(b"0.1.0", Access.CONST),
        Multiplexer(0x1018, 0): _number(1, 4, Access.CONST),
        Multiplexer(0x1018, 1): _number(4, 0x5D0C_0000, Access.CONST),
        Multiplexer(0x1018, 2): _number(4, 0x5D0C_0F0E, Access.CONST),
        Multiplexer(0x1018, 3): _number(4, 0x0001_0000, Access.CONST),
        Multiplexer(0x1018, 4): _number(4, 0x1234_5678, Access.CONST),
        Multiplexer(0x1200, 0): _number(1, 2, Access.CONST),
        Multiplexer(0x1200, 1): _number(4, 0x600 + node_id, Access.CONST),
        Multiplexer(0x1200, 2): _number(4, 0x580 + node_id, Access.CONST),
        Multiplexer(0x2010): _text(b"text", Access.RW),
        Multiplexer(0x2011): Entry(b"data", DataType.DOMAIN),
        Multiplexer(0x2020): _number(4, 0, Access.WO),
    }
    for length, value in (
        (1, 0x11),
        (2, 0x2211),
        (3, 0x332211),
        (4, 0x44332211),
        (8, 0x8877 << 48),
    ):
        entries[Multiplexer(0x2000 + length)] = _number(length, value, Access.RW)
    return entries


def _number(length: int, value: int, access: Access) -> Entry:
    return Entry(value.to_bytes(length, "little"), UNSIGNED[length], access)


def _text(value: bytes, access: Access) -> Entry:
    return Entry(value, DataType.VISIBLE_STRING, access)


# What a user of a like device would name with --sdo-object.
REFERENCE_OBJECTS = (
    *(KnownObject(Multiplexer(0x2000 + length), UNSIGNED[length]) for length in (1, 2, 3, 4, 8)),
    KnownObject(Multiplexer(0x2010), DataType.VISIBLE_STRING),
    KnownObject(Multiplexer(0x2011), DataType.DOMAIN),
    KnownObject(Multiplexer(0x2020), DataType.UNSIGNED32, Access.WO),
)
