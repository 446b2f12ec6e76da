"""Reserved bits and bytes: each one that is set is named (CiA 301, 7.2.4.3)."""

import pytest
from hypothesis import given
from support.sdo_strategies import FRAMES, UNHURRIED

from conformance.sdo.decoding import decode_request, decode_response
from conformance.sdo.frames import (
    Unknown,
)
from conformance.sdo.layout import Message

CLEAN_RESPONSES = [
    "60 17 10 00 00 00 00 00",
    "20 00 00 00 00 00 00 00",
    "30 00 00 00 00 00 00 00",
    "43 18 10 01 04 00 00 00",
    "0B 33 32 00 00 00 00 00",
    "80 00 10 00 02 00 01 06",
    "A4 17 10 00 7F 00 00 00",
    "A2 01 7F 00 00 00 00 00",
    "A1 00 00 00 00 00 00 00",
    "C6 00 10 00 04 00 00 00",
    "DD FF FF 00 00 00 00 00",
]
SET_IN_RESPONSES = [
    ("61 17 10 00 00 00 00 00", ["reserved bits of byte 0 are 01h"]),
    ("7F 17 10 00 00 00 00 00", ["reserved bits of byte 0 are 1Fh"]),
    ("60 17 10 00 00 00 00 01", ["reserved bytes 4 to 7 are 00 00 00 01"]),
    ("28 00 00 00 00 00 00 00", ["reserved bits of byte 0 are 08h"]),
    ("20 00 20 00 00 00 00 00", ["reserved bytes 1 to 7 are 00 20 00 00 00 00 00"]),
    ("53 18 10 01 04 00 00 00", ["reserved bits of byte 0 are 10h"]),
    ("81 00 10 00 02 00 01 06", ["reserved bits of byte 0 are 01h"]),
    ("B8 17 10 00 7F 00 00 00", ["reserved bits of byte 0 are 18h"]),
    ("A4 17 10 00 7F 01 02 03", ["reserved bytes 5 to 7 are 01 02 03"]),
    ("A6 01 7F 00 00 00 00 00", ["reserved bits of byte 0 are 04h"]),
    ("A2 01 7F 00 00 FF 00 00", ["reserved bytes 3 to 7 are 00 00 FF 00 00"]),
    ("BD 00 00 00 00 00 00 00", ["reserved bits of byte 0 are 1Ch"]),
    ("A1 00 00 00 00 00 00 09", ["reserved bytes 1 to 7 are 00 00 00 00 00 00 09"]),
    ("CE 00 10 00 04 00 00 00", ["reserved bits of byte 0 are 08h"]),
    ("C3 00 00 00 00 00 00 00", ["reserved bits of byte 0 are 02h"]),
    ("C1 FF FF 01 00 00 00 00", ["reserved bytes 3 to 7 are 01 00 00 00 00"]),
    (
        "2F 01 00 00 00 00 00 00",
        ["reserved bits of byte 0 are 0Fh", "reserved bytes 1 to 7 are 01 00 00 00 00 00 00"],
    ),
]
SET_IN_REQUESTS = [
    ("5F 00 10 00 00 00 00 00", ["reserved bits of byte 0 are 1Fh"]),
    ("40 00 10 00 AA 00 00 00", ["reserved bytes 4 to 7 are AA 00 00 00"]),
    ("30 00 10 00 00 00 00 00", ["reserved bits of byte 0 are 10h"]),
    ("61 00 00 00 00 00 00 00", ["reserved bits of byte 0 are 01h"]),
    ("60 0A 10 00 00 00 00 00", ["reserved bytes 1 to 7 are 0A 10 00 00 00 00 00"]),
    ("A8 00 10 00 7F 00 00 00", ["reserved bits of byte 0 are 08h"]),
    ("A0 00 10 00 7F 00 01 00", ["reserved bytes 6 to 7 are 01 00"]),
    ("A7 00 00 00 00 00 00 00", ["reserved bits of byte 0 are 04h"]),
    ("D8 00 10 00 00 00 00 00", ["reserved bits of byte 0 are 18h"]),
]


def message(decoded: object) -> Message:
    assert isinstance(decoded, Message)
    return decoded


@pytest.mark.parametrize("frame", CLEAN_RESPONSES)
def test_clean_response_has_none(frame: str) -> None:
    assert message(decode_response(bytes.fromhex(frame))).reserved_fields() == []


@pytest.mark.parametrize(("frame", "fields"), SET_IN_RESPONSES)
def test_set_in_a_response(frame: str, fields: list[str]) -> None:
    assert message(decode_response(bytes.fromhex(frame))).reserved_fields() == fields


@pytest.mark.parametrize(("frame", "fields"), SET_IN_REQUESTS)
def test_set_in_a_request(frame: str, fields: list[str]) -> None:
    assert message(decode_request(bytes.fromhex(frame))).reserved_fields() == fields


@UNHURRIED
@given(FRAMES)
def test_what_is_named_is_all_that_differs_from_the_clean_message(frame: bytes) -> None:
    """Clearing the reserved fields changes a frame exactly if one is named."""
    decoded = decode_response(frame)
    if isinstance(decoded, Unknown):
        return
    clean = bytearray(frame)
    if hasattr(decoded, "reserved_bits"):
        clean[0] &= 0xFF ^ decoded.LAYOUT.bits["reserved_bits"]
    if hasattr(decoded, "reserved"):
        start, stop = decoded.LAYOUT.body["reserved"]
        clean[start:stop] = bytes(stop - start)
    assert (bytes(clean) != frame) == bool(decoded.reserved_fields())
