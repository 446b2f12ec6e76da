"""Which objects a case on the object dictionary is run for."""

from dataclasses import replace
from typing import Any

from conformance.device.eds_listing import ListedObject, Listing, ObjectType, mandatory_and
from conformance.device.effort import INDICES_BESIDE
from conformance.device.known_objects import KnownObject
from conformance.run import object_choices as choose
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType

U8, U16 = DataType.UNSIGNED8, DataType.UNSIGNED16


def entry(sub: int, data_type: DataType, access: Access, **more: Any) -> KnownObject:
    return replace(KnownObject(Multiplexer(0x2000, sub), data_type, access), **more)


RECORD = ListedObject(
    0x2000,
    ObjectType.RECORD,
    {
        0: entry(0, U8, Access.CONST, default=b"\x07"),
        1: entry(1, U8, Access.RW, low=0, high=200),
        2: entry(2, U16, Access.RW, low=10, high=0xFFFF, default=bytes(2)),
        3: entry(3, U16, Access.RO),
        4: entry(4, U16, Access.WO),
        5: entry(5, DataType.VISIBLE_STRING, Access.RW, flags=2),
        7: entry(7, DataType.DOMAIN, Access.RW),
        0xFF: entry(0xFF, DataType.UNSIGNED32, Access.RO),
    },
)
ERRORS = ListedObject(
    0x1003,
    ObjectType.ARRAY,
    {
        0: KnownObject(Multiplexer(0x1003), U8),
        1: KnownObject(Multiplexer(0x1003, 1), DataType.UNSIGNED32, Access.RO),
    },
)
LISTING = Listing({0x1003: ERRORS, 0x2000: RECORD}, is_complete=True, identity={1: 5})
# A file says that they are there, and of the record that it goes to 4, 5 or 6.
UNCLEAR = Listing(
    {
        0x2100: ListedObject(0x2100, ObjectType.VAR, {}, unclear=frozenset((0, 0xFF))),
        0x2000: ListedObject(
            0x2000,
            ObjectType.RECORD,
            {sub: entry(sub, U8, Access.RW) for sub in (0, 1, 4)},
            unclear=frozenset((0, 3)),
        ),
    },
    is_complete=True,
)


def subs(chosen: dict[str, KnownObject]) -> list[int]:
    assert all(label == str(known.mux) for label, known in chosen.items())
    return [known.mux.sub_index for known in chosen.values() if known.mux.index == 0x2000]


def test_what_is_unclear_is_chosen_for_nothing() -> None:
    assert list(choose.structured(UNCLEAR)) == []
    assert [mux.sub_index for mux in choose.gaps(UNCLEAR).values()] == [2]
    assert list(choose.beyond(UNCLEAR)) == ["2000h"]
    assert list(choose.listed_objects(UNCLEAR)) == ["2000h"]
    assert "2100h" not in choose.unlisted(UNCLEAR)
    assert list(choose.unlisted(UNCLEAR)) == ["2001h", "2101h"]


def test_entries() -> None:
    assert subs(choose.readable(LISTING)) == [0, 1, 2, 3, 7], "ObjFlags say not to read 5"
    assert subs(choose.of_fixed_length(LISTING)) == [0, 1, 2, 3]
    assert subs(choose.writable(LISTING)) == [1, 2, 7]
    assert subs(choose.longer_than_a_byte(LISTING)) == [2]
    assert subs(choose.protected(LISTING)) == [0, 3]
    assert subs(choose.write_only(LISTING)) == [4]
    assert subs(choose.fixed(LISTING)) == [0]
    assert subs(choose.parameters(LISTING)) == [2]
    assert subs(choose.limited(LISTING)) == [1, 2]


def test_beyond_limits_there_has_to_be_a_value() -> None:
    assert subs(choose.with_low_limit(LISTING)) == [1, 2]
    assert subs(choose.undercuttable(LISTING)) == [2]
    assert subs(choose.exceedable(LISTING)) == [1]


def test_limits_of_what_is_in_use_are_not_written() -> None:
    """A mapping changes in an order of its own, and not while its PDO is valid."""
    count = KnownObject(Multiplexer(0x1A00), U8, low=0, high=4)
    mapping = ListedObject(0x1A00, ObjectType.RECORD, {0: count})
    listing = Listing({0x1A00: mapping}, is_complete=True)
    assert list(choose.writable(listing)) == ["1A00h:00"]
    for choice in (
        choose.with_low_limit,
        choose.with_high_limit,
        choose.exceedable,
        choose.undercuttable,
    ):
        assert choice(listing) == {}


def test_the_error_list_is_special() -> None:
    assert "1003h:00" in choose.readable(LISTING)
    assert "1003h:01" not in choose.readable(LISTING)
    assert "1003h:00" not in choose.writable(LISTING), "it takes no value but 0"
    assert list(choose.error_places(LISTING)) == ["1003h:01"]


def test_what_is_not_there() -> None:
    assert choose.gaps(LISTING) == {"2000h:06": Multiplexer(0x2000, 6)}
    assert choose.beyond(LISTING)["2000h"] == Multiplexer(0x2000, 8)
    assert list(choose.unlisted(LISTING)) == ["1004h", "2001h"]
    assert list(choose.structured(LISTING)) == ["1003h", "2000h"]
    assert choose.identity(LISTING) == {}, "the EDS lists no 1018h:01 to compare with"


def test_the_mappings_of_pdos() -> None:
    indices = (0x1400, 0x1600, 0x17FF, 0x1A01, 0x1BFF, 0x2000)
    objects = {index: replace(RECORD, index=index) for index in indices}
    listed = choose.mappings(Listing(objects, is_complete=True))
    assert list(listed.values()) == [0x1600, 0x17FF, 0x1A01, 0x1BFF]
    assert choose.mappings(Listing()) == {"1600h": 0x1600, "1A00h": 0x1A00}


def test_unlisted_indices_are_few_and_from_everywhere() -> None:
    objects = {
        index: replace(RECORD, index=index, entries={0: KnownObject(Multiplexer(index), U8)})
        for index in range(0x2000, 0x6000, 2)
    }
    chosen = [mux.index for mux in choose.unlisted(Listing(objects, True)).values()]
    assert len(chosen) <= INDICES_BESIDE
    assert chosen[0] == 0x2001
    assert chosen[-1] > 0x5C00
    assert not set(chosen) & set(objects)


def test_without_an_eds_nothing_is_said_of_what_is_missing() -> None:
    listing = mandatory_and([KnownObject(Multiplexer(0x2001, 1), U16)])
    assert list(choose.readable(listing)) == [
        "1000h:00",
        "1001h:00",
        "1018h:00",
        "1018h:01",
        "2001h:01",
    ]
    for nothing in (choose.gaps, choose.beyond, choose.unlisted, choose.structured):
        assert nothing(listing) == {}
    assert choose.listed_objects(listing) == {}


def test_ranges_are_scanned_when_asked_for() -> None:
    assert choose.ranges(LISTING) == {}
    chosen = choose.ranges(replace(LISTING, to_scan=True))
    assert list(chosen)[:2] == ["0000h-0FFFh", "1000h-1FFFh"]
    assert sorted(index for part in chosen.values() for index in part) == list(range(1, 0x10000))
