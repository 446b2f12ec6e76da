"""Data types, access and lengths of the reference server's object dictionary."""

import pytest
from support.sdo_vectors import mux

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.objects import Access, DataType, Entry, ObjectDictionary, Refusal

# CiA 301 by the index of the type, and the bytes of a value (None: they vary).
TYPES = {
    0x01: ("BOOLEAN", 1),
    0x02: ("INTEGER8", 1),
    0x03: ("INTEGER16", 2),
    0x04: ("INTEGER32", 4),
    0x05: ("UNSIGNED8", 1),
    0x06: ("UNSIGNED16", 2),
    0x07: ("UNSIGNED32", 4),
    0x08: ("REAL32", 4),
    0x09: ("VISIBLE_STRING", None),
    0x0A: ("OCTET_STRING", None),
    0x0B: ("UNICODE_STRING", None),
    0x0C: ("TIME_OF_DAY", 6),
    0x0D: ("TIME_DIFFERENCE", 6),
    0x0F: ("DOMAIN", None),
    0x10: ("INTEGER24", 3),
    0x11: ("REAL64", 8),
    0x12: ("INTEGER40", 5),
    0x13: ("INTEGER48", 6),
    0x14: ("INTEGER56", 7),
    0x15: ("INTEGER64", 8),
    0x16: ("UNSIGNED24", 3),
    0x18: ("UNSIGNED40", 5),
    0x19: ("UNSIGNED48", 6),
    0x1A: ("UNSIGNED56", 7),
    0x1B: ("UNSIGNED64", 8),
}


def test_types() -> None:
    assert {int(kind): (kind.name, kind.length) for kind in DataType} == TYPES


@pytest.mark.parametrize(
    ("access", "readable", "writable"),
    [
        (Access.RW, True, True),
        (Access.RO, True, False),
        (Access.CONST, True, False),
        (Access.WO, False, True),
    ],
)
def test_access(access: Access, readable: bool, writable: bool) -> None:
    assert (access.readable, access.writable) == (readable, writable)


@pytest.mark.parametrize(
    ("name", "read", "write"),
    [
        ("2000", None, None),
        ("2001", None, AbortCode.WRITE_OF_READ_ONLY),
        ("2002", None, AbortCode.WRITE_OF_READ_ONLY),
        ("2003", AbortCode.READ_OF_WRITE_ONLY, None),
        ("2000:01", AbortCode.SUB_INDEX_MISSING, AbortCode.SUB_INDEX_MISSING),
        ("2010", AbortCode.OBJECT_MISSING, AbortCode.OBJECT_MISSING),
    ],
)
def test_who_may_do_what(name: str, read: AbortCode | None, write: AbortCode | None) -> None:
    entries = {
        mux("2000"): Entry(b"", access=Access.RW),
        mux("2001"): Entry(b"", access=Access.RO),
        mux("2002"): Entry(b"", access=Access.CONST),
        mux("2003"): Entry(b"", access=Access.WO),
    }
    objects = ObjectDictionary(entries)
    for look_up, code in ((objects.readable, read), (objects.writable, write)):
        if code is None:
            assert look_up(mux(name)) is entries[mux(name)]
        else:
            with pytest.raises(Refusal) as refusal:
                look_up(mux(name))
            assert refusal.value.code is code


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"\x7f", AbortCode.VALUE_TOO_HIGH),
        (b"\xf6", AbortCode.VALUE_TOO_LOW),
        (b"\x80", AbortCode.VALUE_TOO_LOW),
    ],
)
def test_limits_are_signed_for_signed_types(data: bytes, code: AbortCode) -> None:
    entry = Entry(b"\0", DataType.INTEGER8, low=-9, high=126)
    with pytest.raises(Refusal) as refusal:
        entry.check_limits(data)
    assert refusal.value.code is code


def test_limits_are_unsigned_for_unsigned_types() -> None:
    entry = Entry(b"\0", DataType.UNSIGNED8, low=1, high=0x80)
    entry.check_limits(b"\x80")
    entry.check_limits(b"\x01")
    with pytest.raises(Refusal):
        entry.check_limits(b"\x81")
    with pytest.raises(Refusal):
        entry.check_limits(b"\x00")
