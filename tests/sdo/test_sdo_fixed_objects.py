"""The objects that CiA 301 defines, and the built-in device held against them."""

from itertools import pairwise

import pytest

from conformance.reference.dictionary import all_entries
from conformance.sdo.fixed_objects import FIXED_OBJECTS, entry_at, is_forbidden, object_at
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType

WIDER = {
    Access.RW: frozenset(Access),
    Access.RO: frozenset({Access.RO, Access.CONST}),
    Access.CONST: frozenset({Access.RO, Access.CONST}),
    Access.WO: frozenset({Access.WO}),
}


def test_rows_do_not_overlap_and_clauses_rise() -> None:
    for before, after in pairwise(FIXED_OBJECTS):
        assert before.indices.stop <= after.indices.start
        numbers = [tuple(map(int, each.clause.split("."))) for each in (before, after)]
        assert numbers[0] < numbers[1] or before.clause == after.clause


def test_each_entry_is_found() -> None:
    for row in FIXED_OBJECTS:
        for index in (row.indices.start, row.indices.stop - 1):
            assert object_at(index) is row
            for sub_index, entry in row:
                assert entry_at(Multiplexer(index, sub_index)) is entry


@pytest.mark.parametrize(
    ("index", "sub_index", "data_type", "access"),
    [
        (0x1000, 0, DataType.UNSIGNED32, Access.RO),
        (0x1003, 0, DataType.UNSIGNED8, Access.RW),
        (0x1003, 254, DataType.UNSIGNED32, Access.RO),
        (0x1008, 0, DataType.VISIBLE_STRING, Access.CONST),
        (0x1017, 0, DataType.UNSIGNED16, Access.RW),
        (0x1018, 1, DataType.UNSIGNED32, Access.CONST),
        (0x1018, 4, DataType.UNSIGNED32, Access.RO),
        (0x1018, 255, DataType.UNSIGNED32, Access.RO),
        (0x1200, 2, DataType.UNSIGNED32, Access.RO),
        (0x1201, 3, DataType.UNSIGNED8, Access.RW),
        (0x1805, 5, DataType.UNSIGNED16, Access.RW),
        (0x1BFF, 0x40, DataType.UNSIGNED32, Access.RW),
    ],
)
def test_entries(index: int, sub_index: int, data_type: DataType, access: Access) -> None:
    entry = entry_at(Multiplexer(index, sub_index))
    assert entry is not None
    assert (entry.data_type, entry.access) == (data_type, access)


@pytest.mark.parametrize(
    ("index", "sub_index"), [(0x1000, 1), (0x1017, 254), (0x1018, 5), (0x1201, 4), (0x1A00, 0x41)]
)
def test_what_no_device_may_have(index: int, sub_index: int) -> None:
    assert is_forbidden(Multiplexer(index, sub_index))


@pytest.mark.parametrize("index", [0x0FFF, 0x1004, 0x1022, 0x1C00, 0x2000])
def test_of_other_objects_nothing_is_said(index: int) -> None:
    assert object_at(index) is None
    assert not is_forbidden(Multiplexer(index, 7))


def test_the_built_in_device_is_as_they_are() -> None:
    checked = 0
    for mux, entry in all_entries(5).items():
        fixed = entry_at(mux)
        assert not is_forbidden(mux)
        if fixed is not None and fixed.data_type is not None:
            checked += 1
            assert entry.data_type.length == fixed.data_type.length, mux
            assert entry.access in WIDER[fixed.access], mux
    assert checked > 20
