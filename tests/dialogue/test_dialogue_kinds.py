"""Of which kind an answer is, or a request: what differs in numbers alone is of one kind."""

import pytest

from conformance.dialogue.causes import MOST_WORDS, kind_of_answer, kind_of_request
from conformance.dialogue.rule_families import NO_ANSWER
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_response
from conformance.sdo.describe import in_words
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    DownloadSegment,
    Request,
    Unknown,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer

MUX = Multiplexer(0x2010, 1)
READ = UploadInitiate(MUX)
ABORT = Abort(MUX, AbortCode.GENERAL_ERROR)


def from_hex(frame: str) -> str:
    return in_words(decode_response(bytes.fromhex(frame)))


# The kind of answer


@pytest.mark.parametrize(
    ("frame", "kind"),
    [
        ("80 18 10 01 01 00 04 05", "abort 05040001h"),
        ("80 00 00 00 01 00 04 05", "abort 05040001h"),
        ("80 18 10 01 FF 00 00 00", "abort 000000FFh"),
        ("9F 18 10 01 00 00 00 08", "abort 08000000h"),
        ("60 10 20 00 00 00 00 00", "download initiate response"),
        ("60 10 20 00 01 02 03 04", "download initiate response"),
        ("43 00 10 00 91 01 0F 00", "upload initiate response"),
        ("41 10 20 00 15 00 00 00", "upload initiate response"),
        ("20 00 00 00 00 00 00 00", "download segment response"),
        ("30 00 00 00 00 00 00 00", "download segment response"),
        ("0D 41 00 00 00 00 00 00", "upload segment response"),
        ("A4 10 20 00 7F 00 00 00", "block download initiate response"),
        ("C6 10 20 00 15 00 00 00", "block upload initiate response"),
        ("A2 05 7F 00 00 00 00 00", "block acknowledgement"),
        ("A1 00 00 00 00 00 00 00", "block end response"),
        ("C9 34 12 00 00 00 00 00", "block end"),
        ("E0 00 00 00 00 00 00 00", "command specifier"),
        ("FF 18 10 01 00 00 00 00", "command specifier"),
    ],
)
def test_the_kind_of_a_frame_has_no_numbers_but_the_code_of_an_abort(frame: str, kind: str) -> None:
    assert kind_of_answer(from_hex(frame)) == kind


@pytest.mark.parametrize(
    "actual",
    [
        "",
        "nothing within 1000 ms",
        "no answer",
        f"no answer; {from_hex('80 18 10 01 01 00 04 05')}",
        "none within 50 ms",
        "nothing within 250 ms; received on other identifiers: 586#4300100091010F00",
    ],
)
def test_silence_is_one_kind(actual: str) -> None:
    assert kind_of_answer(actual) == NO_ANSWER


@pytest.mark.parametrize(
    "actual", ["4 bytes: 11 22 33 44", "1 byte: 00", "2010h:01 reads 3 bytes: 61 62 63"]
)
def test_data_is_one_kind(actual: str) -> None:
    assert kind_of_answer(actual) == "other data"


@pytest.mark.parametrize(
    ("one", "other", "kind"),
    [
        ("ackseq 5", "ackseq 126", "ackseq …"),
        ("n=3", "n=6", "n=…"),
        ("2010h:01 has CRC 1D0Fh", "2011h:00 has CRC 0000h", "has CRC …"),
        (
            "585#4300100091 (DLC 5)",
            "585#430010009101 (DLC 6)",
            "DLC …",
        ),
        (
            "585#R8 (a remote frame, DLC 0)",
            "585#R8 (a remote frame, DLC 4)",
            "a remote frame, DLC …",
        ),
        (
            "12 segments behind number 3",
            "1,270 segments behind number 127",
            "… segments behind number …",
        ),
    ],
)
def test_what_differs_in_numbers_alone_is_of_one_kind(one: str, other: str, kind: str) -> None:
    assert kind_of_answer(one) == kind_of_answer(other) == kind


def test_the_first_of_several_frames_says_the_kind() -> None:
    abort, read = from_hex("80 18 10 01 01 00 04 05"), from_hex("43 00 10 00 91 01 0F 00")
    assert kind_of_answer(f"{read}; {abort}") == "upload initiate response"
    assert kind_of_answer(f"{abort}; {read}; 17 more") == "abort 05040001h"


def test_a_kind_is_a_line_and_short() -> None:
    assert kind_of_answer("it said\nmuch more") == "it said"
    assert kind_of_answer("word " * 40) == ("word " * 40)[:MOST_WORDS]


# The kind of request


@pytest.mark.parametrize(
    ("request_", "kind"),
    [
        (READ, "upload initiate"),
        (UploadSegment(toggle=1), "upload segment request"),
        (DownloadInitiate.with_data(MUX, b"\1\2"), "download initiate, expedited"),
        (DownloadInitiate.with_size(MUX, 20), "download initiate, segmented"),
        (DownloadInitiate.with_size(MUX, None), "download initiate, size not indicated"),
        (DownloadSegment.with_data(b"ABC", toggle=1, last=True), "download segment"),
        (BlockUploadInitiate(MUX, 127), "block upload initiate"),
        (BlockUploadStart(), "block upload start"),
        (BlockDownloadInitiate.with_size(MUX, 20), "block download initiate"),
        (BlockSegment(7, b"ABCDEFG", last=True), "block segment …"),
        (BlockAck(5, 127), "block acknowledgement"),
        (BlockEnd(3, 0x1D0F), "block end"),
        (ABORT, "abort"),
        (
            Unknown(bytes.fromhex("E0 10 20 01 00 00 00 00")),
            "command specifier …",
        ),
        (Unknown(b"\x40\x10"), "… bytes instead of …"),
    ],
)
def test_a_request_has_neither_object_nor_numbers(request_: Request, kind: str) -> None:
    assert kind_of_request(request_) == kind
