"""Objects as users name them: an entry, or all that can be written of an array or record."""

import pytest

from conformance.device.eds_listing import ListedObject, Listing, ObjectType
from conformance.device.known_objects import KnownObject
from conformance.device.named_objects import NamedObject
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType


def entry(index: int, sub: int, access: Access = Access.RW) -> KnownObject:
    return KnownObject(Multiplexer(index, sub), DataType.UNSIGNED8, access)


ARRAY = ListedObject(
    0x2040,
    ObjectType.ARRAY,
    {0: entry(0x2040, 0, Access.RO), 1: entry(0x2040, 1), 2: entry(0x2040, 2, Access.WO)},
)
FIXED = ListedObject(0x2041, ObjectType.RECORD, {0: entry(0x2041, 0, Access.CONST)})
VARIABLE = ListedObject(0x2042, ObjectType.VAR, {0: entry(0x2042, 0)})
LISTING = Listing({each.index: each for each in (ARRAY, FIXED, VARIABLE)}, is_complete=True)


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("2040", ["2040h:01", "2040h:02"]),
        ("2040:01", ["2040h:01"]),
        ("2040:00", ["2040h:00"]),
        ("2040=unsigned8", ["2040h:00"]),
        ("2041", ["2041h:00"]),
        ("2042", ["2042h:00"]),
        ("2050", ["2050h:00"]),
    ],
)
def test_an_array_or_record_is_named_with_its_writable_entries(text: str, meant: list[str]) -> None:
    found = NamedObject.parse(text).entries(LISTING)
    assert [str(known.mux) for known in found] == meant


def test_without_an_eds_an_entry_is_meant() -> None:
    assert [str(one.mux) for one in NamedObject.parse("2040").entries(Listing())] == ["2040h:00"]
