"""Frames in words, as failures and traces show them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.sdo_strategies import FRAMES, REQUESTS, RESPONSES, UNHURRIED

from conformance.sdo.decoding import decode_request, decode_response
from conformance.sdo.describe import describe, hex_bytes, in_words
from conformance.sdo.frames import (
    Unknown,
)
from conformance.sdo.layout import Message
from conformance.sdo.line import Line

ODD_REQUESTS = [
    ("E0 00 10 00 00 00 00 00", "command specifier E0h, which is not defined"),
    ("40 00 10", "3 bytes instead of 8: 40 00 10"),
    ("", "frame without data"),
    (
        "2E 00 20 00 01 02 03 04",
        "download initiate 2000h:00, expedited, size not indicated, n=3: 01 02 03 04",
    ),
    ("24 00 20 00 00 00 00 00", "download initiate 2000h:00, segmented, size not indicated, n=1"),
    (
        "22 00 20 00 01 00 00 00",
        "download initiate 2000h:00, expedited, size not indicated: 01 00 00 00",
    ),
    ("0F 00 00 00 00 00 00 00", "download segment, t=0, last, 0 bytes: no data"),
    (
        "5F 00 10 00 00 00 00 01",
        "upload initiate 1000h:00; reserved bits of byte 0 are 1Fh; "
        "reserved bytes 4 to 7 are 00 00 00 01",
    ),
    ("C4 00 20 00 00 00 00 00", "block download initiate 2000h:00, size not indicated, with CRC"),
    ("A4 00 10 00 80 FF 00 00", "block upload initiate 1000h:00, blksize 128, pst 255, with CRC"),
    ("80 00 10 00 03 00 01 06", "abort 1000h:00, 06010003h (not an abort code of CiA 301)"),
]
ODD_RESPONSES = [
    ("4F 00 20 00 01 00 00 00", "upload initiate response 2000h:00, expedited, 1 byte: 01"),
    ("40 00 20 00 00 00 00 00", "upload initiate response 2000h:00, segmented, size not indicated"),
    (
        "A0 00 20 00 15 00 00 00",
        "block download initiate response 2000h:00, blksize 21, without CRC",
    ),
    ("38 00 00 00 00 00 00 00", "download segment response, t=1; reserved bits of byte 0 are 08h"),
    ("A3 00 00 00 00 00 00 00", "command specifier A3h, which is not defined"),
]


@pytest.mark.parametrize(("frame", "words"), ODD_REQUESTS)
def test_unusual_request(frame: str, words: str) -> None:
    assert describe(decode_request(bytes.fromhex(frame))) == words


@pytest.mark.parametrize(("frame", "words"), ODD_RESPONSES)
def test_unusual_response(frame: str, words: str) -> None:
    assert describe(decode_response(bytes.fromhex(frame))) == words


def test_a_response_is_shown_with_its_bytes() -> None:
    assert in_words(decode_response(bytes.fromhex("6017100000000000"))) == (
        "download initiate response 1017h:00 [60 17 10 00 00 00 00 00]"
    )


def test_bytes_as_the_field_writes_them() -> None:
    assert hex_bytes(bytes.fromhex("401810aF")) == "40 18 10 AF"
    assert hex_bytes(b"") == "no data"


@UNHURRIED
@given(st.one_of(*REQUESTS.values(), *RESPONSES.values()))
def test_one_line_that_names_reserved_fields(message: Message) -> None:
    words = describe(message)
    assert len(words.splitlines()) == 1
    assert all(found in words for found in message.reserved_fields())
    assert ("reserved" in words) == bool(message.reserved_fields())


@UNHURRIED
@given(st.lists(st.tuples(st.booleans(), st.one_of(FRAMES, st.binary(max_size=8)))))
def test_any_conversation_can_be_read(conversation: list[tuple[bool, bytes]]) -> None:
    line = Line()
    for from_client, frame in conversation:
        message = line.request(frame) if from_client else line.response(frame)
        assert message.encode() == frame
        assert describe(message)
        assert isinstance(message, Unknown) or len(frame) == 8
