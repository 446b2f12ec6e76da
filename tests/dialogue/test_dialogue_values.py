"""What a case expects of values: those that are read, and those that a case must not change."""

import pytest
from support.run_bench import DOMAIN, NODE_ID, NUMBER, RULE, TEXT, discovered, recording

from conformance.device.known_objects import KnownObject
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.values import is_written_through, same_value, with_spaces
from conformance.faults.catalogue import build_node
from conformance.sdo.frames import DownloadInitiate, DownloadSegment, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType
from conformance.sdo.rules import PART_WRITTEN, Violation

READ = UploadInitiate(Multiplexer(0x1018, 1))


def test_a_value() -> None:
    with discovered(recording()) as bench:
        sdo = bench.dialogue()
        sdo.expect_value(TEXT, b"text\0")
        with pytest.raises(Violation) as raised:
            sdo.expect_value(TEXT, b"test")
    assert raised.value.rule is RULE
    assert raised.value.expected == "2010h:00 reads 4 bytes: 74 65 73 74"
    assert raised.value.actual == "2010h:00 reads 4 bytes: 74 65 78 74"


def test_unchanged() -> None:
    with discovered(recording()) as bench:
        sdo = bench.dialogue()
        with sdo.unchanged(NUMBER) as value:
            assert value == bytes.fromhex("11223344")
        with pytest.raises(Violation, match="2004h:00 reads"), sdo.unchanged(NUMBER):
            sdo.download(NUMBER, b"\1\2\3\4")


def test_unchanged_ends_the_transfer_that_is_left_open() -> None:
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        with sdo.unchanged(TEXT):
            sdo.initiate_download(TEXT, 14)
            sdo.download_segment(b"ABCDEFG", toggle=0)
        assert server.transfer is None
    assert server.writes == []


@pytest.mark.parametrize("known", [TEXT, DOMAIN], ids=["string", "domain"])
def test_what_is_written_of_an_aborted_download_counts_as_a_should(known: KnownObject) -> None:
    with discovered(build_node("string-keeps-part-of-aborted-write", NODE_ID)) as bench:
        sdo = bench.dialogue()
        with sdo.unchanged(known):
            sdo.initiate_download(known, 14)
            sdo.download_segment(b"ABCDEFG", toggle=0)
        assert sdo.upload(known) == b"ABCDEFG"
    assert [found.rule for found in sdo.record.minor] == [PART_WRITTEN]
    assert not sdo.record.own


def test_what_came_behind_an_abort_is_never_written() -> None:
    """A string may hold what came before it, at its place, and nothing else."""
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        before = sdo.upload(TEXT)
        sdo.initiate_download(TEXT, 14)
        sdo.download_segment(b"ABCDEFG", toggle=0)
        sdo.end_transfer()
        sdo.send(DownloadSegment.with_data(b"HIJKLMN", toggle=1, last=True))
        sdo.fence()
        server.entries[TEXT.mux].value = b"ABCDEFGHIJKLMN"
        with pytest.raises(Violation, match="2010h:00 reads"):
            sdo.expect_kept(TEXT, before)


def test_of_a_number_no_part_is_written() -> None:
    server = recording()
    known = KnownObject(Multiplexer(0x2008), DataType.UNSIGNED64)
    with discovered(server) as bench:
        sdo = bench.dialogue()
        before = sdo.upload(known)
        sdo.initiate_download(known, 8)
        sdo.download_segment(b"ABCDEFG", toggle=0)
        sdo.end_transfer()
        server.entries[known.mux].value = b"ABCDEFG\x88"
        with pytest.raises(Violation, match="2008h:00 reads"):
            sdo.expect_kept(known, before)


def test_a_case_that_fails_by_itself_keeps_its_failure() -> None:
    """What ``unchanged`` would find then is of no interest."""

    def case(sdo: Dialogue) -> None:
        with sdo.unchanged(NUMBER):
            sdo.download(NUMBER, b"\1\2\3\4")
            raise ZeroDivisionError

    with discovered(recording()) as bench, pytest.raises(ZeroDivisionError):
        case(bench.dialogue())


def test_a_request_that_writes_is_remembered() -> None:
    with discovered(recording()) as bench:
        sdo = bench.dialogue()
        sdo.send(READ)
        assert sdo.record.written == set()
        sdo.send(DownloadInitiate.with_data(NUMBER.mux, b"\1\2\3\4"))
        assert sdo.record.written == {NUMBER.mux}


@pytest.mark.parametrize("stated", ["a text", "a text\0", "", "another"])
@pytest.mark.parametrize("found", ["a text", " a text", "a text  ", " a text\0", "   "])
def test_an_eds_loses_the_spaces_around_a_text(found: str, stated: str) -> None:
    due = with_spaces(TEXT, stated.encode(), found.encode())
    alike = found.strip(" \0") == stated.strip(" \0")
    assert same_value(TEXT, found.encode(), due) == alike


def test_the_spaces_of_other_objects_count() -> None:
    assert with_spaces(DOMAIN, b"data", b" data") == b"data"


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
def test_how_much_of_an_aborted_download_may_be_there(found: bytes, due: bool) -> None:
    assert is_written_through(found, b"abcdefghijk", [b"ABCDEFG"]) is due
