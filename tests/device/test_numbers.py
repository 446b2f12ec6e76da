"""Numbers as bytes on the wire, and the values next to a limit."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conformance.device.numbers import beyond, bounds, decode_number, encode_number, is_number
from conformance.sdo.objects import DataType

INTEGERS = [one for one in DataType if one.name.startswith(("INTEGER", "UNSIGNED"))]


@pytest.mark.parametrize(
    ("data_type", "number", "data"),
    [
        (DataType.UNSIGNED8, 0x12, "12"),
        (DataType.UNSIGNED24, 0x123456, "563412"),
        (DataType.INTEGER8, -1, "FF"),
        (DataType.INTEGER8, 0xFF, "FF"),  # as files write it
        (DataType.INTEGER32, 0x80000000, "00000080"),
        (DataType.INTEGER40, -2, "FEFFFFFFFF"),
        (DataType.BOOLEAN, 1, "01"),
        (DataType.REAL32, 1.0, "0000803F"),
        (DataType.REAL64, -2.0, "00000000000000C0"),
        (DataType.TIME_OF_DAY, 1, "010000000000"),
    ],
)
def test_bytes(data_type: DataType, number: float, data: str) -> None:
    assert encode_number(data_type, number) == bytes.fromhex(data)


@given(st.sampled_from(INTEGERS), st.data())
def test_there_and_back(data_type: DataType, data: st.DataObject) -> None:
    number = data.draw(st.integers(*bounds(data_type)))
    assert decode_number(data_type, encode_number(data_type, number)) == number


@pytest.mark.parametrize(
    ("data_type", "number"),
    [
        (DataType.UNSIGNED8, 256),
        (DataType.UNSIGNED8, -1),
        (DataType.INTEGER8, 256),
        (DataType.INTEGER8, -129),
        (DataType.UNSIGNED16, 1.5),
        (DataType.REAL32, 1e39),
        (DataType.REAL64, 10**400),
        (DataType.DOMAIN, 1),
    ],
)
def test_what_a_type_does_not_hold(data_type: DataType, number: float) -> None:
    with pytest.raises(OverflowError):
        encode_number(data_type, number)


@pytest.mark.parametrize(
    ("data_type", "limit", "direction", "data"),
    [
        (DataType.UNSIGNED8, 100, 1, "65"),
        (DataType.UNSIGNED8, 255, 1, None),
        (DataType.UNSIGNED8, 0, -1, None),
        (DataType.INTEGER8, 127, 1, None),
        (DataType.INTEGER8, 0, -1, "FF"),
        (DataType.INTEGER8, -128, -1, None),
        (DataType.REAL32, 12.5, 1, "0000C841"),
        (DataType.REAL32, 3e38, 1, None),
    ],
)
def test_beyond_a_limit(
    data_type: DataType, limit: float, direction: int, data: str | None
) -> None:
    assert beyond(data_type, limit, direction) == (None if data is None else bytes.fromhex(data))


def test_what_numbers_are() -> None:
    assert all(is_number(data_type) for data_type in INTEGERS)
    assert is_number(DataType.BOOLEAN)
    assert is_number(DataType.REAL32)
    assert not is_number(DataType.TIME_OF_DAY)
    assert not is_number(DataType.VISIBLE_STRING)
    assert not is_number(None)
