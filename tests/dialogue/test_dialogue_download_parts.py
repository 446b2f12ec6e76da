"""How much of a download a server may have written through when it is aborted."""

import pytest

from conformance.dialogue.download_parts import Delivered, is_written_through
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEndResponse,
    BlockSegment,
    DownloadInitiate,
    DownloadSegment,
    DownloadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer

MUX = Multiplexer(0x2010)
ABORT = Abort(MUX, AbortCode.GENERAL_ERROR)


def begun(*segments: DownloadSegment) -> Delivered:
    delivered = Delivered()
    delivered.request(DownloadInitiate.with_size(MUX, 21))
    for segment in segments:
        delivered.request(segment)
    return delivered


def segment(data: bytes, toggle: int, *, last: bool = False) -> DownloadSegment:
    return DownloadSegment.with_data(data, toggle=toggle, last=last)


def test_segments_in_sequence() -> None:
    delivered = begun(segment(b"ABCDEFG", 0), segment(b"#######", 0), segment(b"HIJKLMN", 1))
    assert delivered.of(MUX) == [b"ABCDEFGHIJKLMN"]
    assert delivered.of(Multiplexer(0x2011)) == []


@pytest.mark.parametrize("by_server", [True, False])
def test_nothing_behind_an_abort(by_server: bool) -> None:
    delivered = begun(segment(b"ABCDEFG", 0))
    if by_server:
        delivered.response(ABORT)
    else:
        delivered.request(ABORT)
    delivered.request(segment(b"HIJKLMN", 1))
    assert delivered.of(MUX) == [b"ABCDEFG"]


def test_a_sub_block_with_a_gap() -> None:
    delivered = Delivered()
    delivered.request(BlockDownloadInitiate.with_size(MUX, 21))
    delivered.request(BlockSegment(1, b"ABCDEFG"))
    delivered.request(BlockSegment(3, b"#######"))
    delivered.response(BlockAck(1, 127))
    delivered.request(BlockSegment(1, b"HIJKLMN"))
    assert delivered.of(MUX) == [b"ABCDEFGHIJKLMN"]
    delivered.response(BlockEndResponse())
    assert delivered.of(MUX) == []


def test_a_download_that_is_complete_leaves_nothing() -> None:
    delivered = begun(segment(b"ABCDEFG", 0))
    delivered.response(DownloadSegmentResponse(0))
    assert delivered.of(MUX) == [b"ABCDEFG"]
    delivered.request(segment(b"HIJ", 1, last=True))
    delivered.response(DownloadSegmentResponse(1))
    assert delivered.of(MUX) == []


@pytest.mark.parametrize(
    ("found", "due"),
    [
        (b"ABCDEFG", True),  # cut
        (b"ABCDEFGhijk", True),  # in place
        (b"ABCDEFG\0\0\0\0", True),  # filled up
        (b"abcdefghijk", True),
        (b"", True),
        (b"ABCDEFGH", False),
        (b"BCDEFG", False),
    ],
)
def test_what_may_be_there(found: bytes, due: bool) -> None:
    assert is_written_through(found, b"abcdefghijk", [b"ABCDEFG"]) is due
