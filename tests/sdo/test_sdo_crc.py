"""The checksum of block transfers against published values and against its definition."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.sdo_strategies import UNHURRIED

from conformance.sdo.crc import crc16

CHECK_VALUES = [
    (b"", 0x0000),
    (b"123456789", 0x31C3),
    (bytes(2), 0x0000),
    (bytes([1, 2, 3, 4]), 0x0D03),
    (bytes([1, 2, 3, 4, 5]), 0x8208),
    (bytes.fromhex("92010200"), 0x7AA5),
    (b"CANopenDemoPIC32", 0x43F3),
    (b"Tiny Node - Mega Domains !", 0xE140),
    (bytes(range(0x40)), 0x2BF5),
    (b"A really really long string...", 0x6945),
]


def by_definition(data: bytes) -> int:
    """Divide by x^16 + x^12 + x^5 + 1, bit by bit, most significant bit first."""
    remainder = 0
    for byte in data:
        remainder ^= byte << 8
        for _ in range(8):
            remainder <<= 1
            if remainder & 0x10000:
                remainder ^= 0x11021
    return remainder


@pytest.mark.parametrize(("data", "crc"), CHECK_VALUES)
def test_check_value(data: bytes, crc: int) -> None:
    assert crc16(data) == crc


@UNHURRIED
@given(st.binary(max_size=300))
def test_definition(data: bytes) -> None:
    assert crc16(data) == by_definition(data)


@UNHURRIED
@given(st.binary(), st.binary())
def test_piece_by_piece(first: bytes, second: bytes) -> None:
    assert crc16(second, crc16(first)) == crc16(first + second)
