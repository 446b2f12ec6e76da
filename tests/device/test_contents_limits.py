"""How many bytes an upload may bring of an object before it has no end."""

from dataclasses import replace

import pytest

from conformance.device.contents import Contents
from conformance.device.effort import PADDING
from conformance.device.known_objects import KnownObject
from conformance.sdo.client import MOST_UPLOADED
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    BlockSegment,
    DownloadInitiate,
    DownloadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Habits

MUX = Multiplexer(0x2010)
TEXT = KnownObject(MUX, DataType.VISIBLE_STRING)


def longest(known: KnownObject | None, own: bytes | None, contents: Contents | None = None) -> int:
    """Return the limit of an object that is known so, and held its ``own`` value at first."""
    contents = contents or Contents()
    mux = MUX if known is None else known.mux
    contents.known = {} if known is None else {mux: known}
    contents.own = {} if own is None else {mux: own}
    return contents.longest(mux)


def test_a_number_may_bring_a_segment_more_than_its_length() -> None:
    number = KnownObject(MUX, DataType.UNSIGNED32, Access.RO)
    assert longest(number, None) == 11


def test_a_text_that_only_the_suite_writes_is_as_long_as_what_was_there() -> None:
    assert longest(TEXT, b"as it was") == 9 + PADDING


@pytest.mark.parametrize(
    ("known", "value"),
    [
        (None, None),
        (KnownObject(MUX, DataType.DOMAIN), None),
        (KnownObject(MUX), None),
        (KnownObject(MUX, DataType.DOMAIN, Access.RO), b"a log that grows"),
        (KnownObject(MUX, DataType.DOMAIN, Access.RW, floats=True), b"a log that grows"),
    ],
)
def test_of_what_may_change_by_itself_nothing_is_known(
    known: KnownObject | None, value: bytes | None
) -> None:
    assert longest(known, value) == MOST_UPLOADED + len(value or b"")


def test_a_text_that_was_not_read_yet_is_no_book() -> None:
    assert longest(TEXT, None) == 131072
    stated = KnownObject(MUX, DataType.VISIBLE_STRING, Access.CONST, default=b"a name")
    assert longest(stated, None) == 16384 + 6


def test_what_was_written_counts_in_whatever_way_it_went() -> None:
    contents = Contents()
    contents.sent(DownloadInitiate.with_size(MUX, 0xFFFF_FFFF))
    for number in range(300):
        contents.sent(DownloadSegment(bytes(7), toggle=number % 2))
    assert longest(TEXT, b"", contents) == 2100 + PADDING
    contents.sent(BlockDownloadInitiate.with_size(MUX, 9000))
    for number in range(400):
        contents.sent(BlockSegment(number % 127 + 1, bytes(7)))
    assert longest(TEXT, b"", contents) == 2800 + PADDING
    assert longest(KnownObject(Multiplexer(0x2011), DataType.DOMAIN), b"", contents) == PADDING


def test_whether_the_latest_download_has_brought_a_byte() -> None:
    contents = Contents()
    assert not contents.latest(MUX).is_empty, "there was none"
    requests = (
        (DownloadInitiate.with_data(MUX, b"abc"), False),
        (DownloadInitiate.with_size(MUX, 0), True),
        (DownloadSegment.with_data(b"", toggle=0, last=True), True),
        (DownloadInitiate.with_size(MUX, 9), True),
        (DownloadSegment.with_data(b"a", toggle=0), False),
        (DownloadSegment.with_data(b"", toggle=1, last=True), False),
        (BlockDownloadInitiate.with_size(MUX, 9), True),
        (BlockSegment(1, bytes(7)), False),
    )
    for request, is_empty in requests:
        contents.sent(request)
        assert contents.latest(MUX).is_empty is is_empty


def test_a_device_that_brings_data_without_an_end_is_given_less() -> None:
    contents = Contents()
    allowed = []
    for contents.endless in range(5):
        allowed.append(longest(None, None, contents))
    assert longest(TEXT, b"as it was", contents) == 9 + 64
    for request in (
        DownloadInitiate.with_size(MUX, 5),
        DownloadSegment.with_data(b"other", toggle=0),
    ):
        contents.sent(request)
    assert longest(TEXT, b"as it was", contents) == 7 + 64
    keeps_tails = replace(TEXT, habits=Habits(keeps_tails=True))
    assert longest(keeps_tails, b"as it was", contents) == 9 + PADDING, "whatever is written to it"
    assert allowed == [MOST_UPLOADED, 16384, 16384, 16384, 1024]
