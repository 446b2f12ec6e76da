"""How many bytes an upload may bring of an object before it has no end."""

from dataclasses import replace

import pytest

from conformance.device.known_objects import KnownObject
from conformance.device.upload_limits import PADDING, Extents
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


def test_a_number_may_bring_a_segment_more_than_its_length() -> None:
    number = KnownObject(MUX, DataType.UNSIGNED32, Access.RO)
    assert Extents().longest(number, None) == 11


def test_a_text_that_only_the_suite_writes_is_as_long_as_what_was_there() -> None:
    assert Extents().longest(TEXT, b"as it was") == 9 + PADDING


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
    assert Extents().longest(known, value) == MOST_UPLOADED + len(value or b"")


def test_a_text_that_was_not_read_yet_is_no_book() -> None:
    assert Extents().longest(TEXT, None) == 131072
    stated = KnownObject(MUX, DataType.VISIBLE_STRING, Access.CONST, default=b"a name")
    assert Extents().longest(stated, None) == 16384 + 6


def test_what_was_written_counts_in_whatever_way_it_went() -> None:
    extents = Extents()
    extents.request(DownloadInitiate.with_size(MUX, 0xFFFF_FFFF))
    for number in range(300):
        extents.request(DownloadSegment(bytes(7), toggle=number % 2))
    assert extents.longest(TEXT, b"") == 2100 + PADDING
    extents.request(BlockDownloadInitiate.with_size(MUX, 9000))
    for number in range(400):
        extents.request(BlockSegment(number % 127 + 1, bytes(7)))
    assert extents.longest(TEXT, b"") == 2800 + PADDING
    assert extents.longest(KnownObject(Multiplexer(0x2011), DataType.DOMAIN), b"") == PADDING


def test_whether_the_latest_download_has_brought_a_byte() -> None:
    extents = Extents()
    assert not extents.may_be_empty(MUX), "there was none"
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
        extents.request(request)
        assert extents.may_be_empty(MUX) is is_empty


def test_a_device_that_brings_data_without_an_end_is_given_less() -> None:
    extents = Extents()
    allowed = []
    for extents.endless in range(5):
        allowed.append(extents.longest(None, None))
    assert extents.longest(TEXT, b"as it was") == 9 + 64
    for request in (
        DownloadInitiate.with_size(MUX, 5),
        DownloadSegment.with_data(b"other", toggle=0),
    ):
        extents.request(request)
    assert extents.longest(TEXT, b"as it was") == 7 + 64
    keeps_tails = replace(TEXT, habits=Habits(keeps_tails=True))
    assert extents.longest(keeps_tails, b"as it was") == 9 + PADDING, "whatever is written to it"
    assert allowed == [MOST_UPLOADED, 16384, 16384, 16384, 1024]
