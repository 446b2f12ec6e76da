"""The reference client: what it sends, and that it sees what is wrong with a response."""

import itertools
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sdo_conversation import Ended, drive, frames, served
from support.sdo_strategies import UNHURRIED
from support.sdo_vectors import mux

from conformance.reference.server import Server
from conformance.sdo.checks import ResponseChecks, ServerAborted
from conformance.sdo.client import Client, Uploaded
from conformance.sdo.objects import DataType, Entry, ObjectDictionary
from conformance.sdo.rules import Violation

MUX = mux("1008")
INITIATED = "41 08 10 00 09 00 00 00"
UNSIZED = "40 08 10 00 00 00 00 00"
FIRST = "00 6E 65 77 20 73 6C 61"
CONFIRMED = "60 08 10 00 00 00 00 00"

# What a server answers to the upload of 1008h, and the rule that the last of it breaks.
BAD_UPLOADS = [
    (["43 08 10 01 01 02 03 04"], "response.multiplexer"),
    (["43 09 10 00 01 02 03 04"], "response.multiplexer"),
    (["60 08 10 00 00 00 00 00"], "response.specifier"),
    (["00 08 10 00 00 00 00 00"], "response.specifier"),
    (["E0 08 10 00 00 00 00 00"], "response.specifier"),
    (["C6 08 10 00 09 00 00 00"], "response.specifier"),
    (["53 08 10 00 01 02 03 04"], "response.reserved"),
    (["40 08 10 00 09 00 00 00"], "response.reserved"),
    (["46 08 10 00 01 02 03 04"], "response.unused-count"),
    (["45 08 10 00 09 00 00 00"], "response.unused-count"),
    (["44 08 10 00 00 00 00 00"], "response.unused-count"),
    (["4B 08 10 00 01 02 03 00"], "response.filler"),
    (["4F 08 10 00 01 00 00 04"], "response.filler"),
    (["43 08 10 00 01 02 03"], "response.frame"),
    ([""], "response.frame"),
    ([INITIATED, "10 6E 65 77 20 73 6C 61"], "response.toggle"),
    ([INITIATED, FIRST, "0B 76 65 00 00 00 00 00"], "response.toggle"),
    ([INITIATED, "20 00 00 00 00 00 00 00"], "response.specifier"),
    ([INITIATED, "41 08 10 00 09 00 00 00"], "response.specifier"),
    ([INITIATED, "00 6E 65 77"], "response.frame"),
    ([INITIATED, FIRST, "1B 76 65 01 00 00 00 00"], "response.filler"),
    ([INITIATED, "01 6E 65 77 20 73 6C 61"], "upload.size"),
    ([INITIATED, FIRST, "10 76 65 20 6E 61 6D 65"], "upload.size"),
    ([INITIATED, FIRST, "19 76 65 20 00 00 00 00"], "upload.size"),
    (["41 08 10 00 04 00 00 00", "05 54 69 6E 79 20 00 00"], "upload.size"),  # V65
    (["41 08 10 00 00 00 00 00", "0D 01 00 00 00 00 00 00"], "upload.size"),
]
BAD_DOWNLOADS = [
    (["60 08 10 01 00 00 00 00"], "response.multiplexer"),
    (["43 08 10 00 00 00 00 00"], "response.specifier"),
    (["20 00 00 00 00 00 00 00"], "response.specifier"),
    (["61 08 10 00 00 00 00 00"], "response.reserved"),
    (["60 08 10 00 00 00 00 01"], "response.reserved"),
    (["60 08 10 00"], "response.frame"),
    ([CONFIRMED, "30 00 00 00 00 00 00 00"], "response.toggle"),
    ([CONFIRMED, "20 00 00 00 00 00 00 00", "20 00 00 00 00 00 00 00"], "response.toggle"),
    ([CONFIRMED, "60 08 10 00 00 00 00 00"], "response.specifier"),
    ([CONFIRMED, "00 00 00 00 00 00 00 00"], "response.specifier"),
    ([CONFIRMED, "20 08 10 00 00 00 00 00"], "response.reserved"),
    ([CONFIRMED, "21 00 00 00 00 00 00 00"], "response.reserved"),
    ([CONFIRMED, "20 00 00 00 00 00 00 00 00"], "response.frame"),
]
# Aborts that are not as they have to be, whatever the transfer.
BAD_ABORTS = [
    ("80 08 10 01 00 00 02 06", "response.multiplexer"),
    ("80 00 00 00 01 00 04 05", "response.multiplexer"),
    ("80 08 10 00 03 00 01 06", "abort.code"),
    ("80 08 10 00 00 00 00 00", "abort.code"),
    ("81 08 10 00 00 00 02 06", "response.reserved"),
]


def upload(*responses: str) -> Ended:
    return drive(Client().upload(MUX), frames(*responses))


def download(*responses: str) -> Ended:
    return drive(Client().download(MUX, b"new slave name"), frames(*responses))


@pytest.mark.parametrize(("responses", "rule"), BAD_UPLOADS)
def test_bad_upload(responses: list[str], rule: str) -> None:
    assert not upload(*responses[:-1]).finished
    assert upload(*responses).broken_rule == rule


@pytest.mark.parametrize(("responses", "rule"), BAD_DOWNLOADS)
def test_bad_download(responses: list[str], rule: str) -> None:
    assert not download(*responses[:-1]).finished
    assert download(*responses).broken_rule == rule


@pytest.mark.parametrize(("abort", "rule"), BAD_ABORTS)
def test_bad_abort(abort: str, rule: str) -> None:
    assert upload(abort).broken_rule == rule
    assert upload(INITIATED, abort).broken_rule == rule
    assert download(abort).broken_rule == rule
    assert download(CONFIRMED, abort).broken_rule == rule


@pytest.mark.parametrize("before", [[], [INITIATED], [INITIATED, FIRST]])
def test_an_upload_may_be_aborted(before: list[str]) -> None:
    ended = upload(*before, "80 08 10 00 00 00 04 05")
    assert isinstance(ended.error, ServerAborted)
    assert ended.error.abort.code == 0x05040000
    assert str(ended.error) == ("the server aborted 1008h:00: 05040000h (SDO protocol timed out)")


@pytest.mark.parametrize("before", [[], [CONFIRMED]])
def test_a_download_may_be_aborted(before: list[str]) -> None:
    ended = download(*before, "80 08 10 00 02 00 01 06")
    assert isinstance(ended.error, ServerAborted)
    assert ended.error.abort.code == 0x06010002


def test_a_breach_says_what_was_expected_and_what_came() -> None:
    error = upload(INITIATED, "10 6E 65 77 20 73 6C 61").error
    assert str(error) == (
        "response.toggle: expected upload segment response with t=0; got upload segment response, "
        "t=1, 7 bytes: 6E 65 77 20 73 6C 61 [10 6E 65 77 20 73 6C 61]"
    )


@pytest.mark.parametrize("begin", [INITIATED, UNSIZED, "41 08 10 00 FF FF FF FF"])
def test_an_upload_of_empty_segments_is_ended(begin: str) -> None:
    empty = frames("0E 00 00 00 00 00 00 00", "1E 00 00 00 00 00 00 00")
    responses = itertools.islice(itertools.cycle(empty), 100)
    ended = drive(Client().upload(MUX), [*frames(begin), *responses])
    assert ended.broken_rule == "upload.ends"


def test_an_upload_without_a_size_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conformance.sdo.client.MOST_UPLOADED", 70)
    full = frames("00 01 02 03 04 05 06 07", "10 01 02 03 04 05 06 07")
    responses = itertools.islice(itertools.cycle(full), 100)
    ended = drive(Client().upload(MUX), [*frames(UNSIZED), *responses])
    assert ended.broken_rule == "upload.ends"


def test_all_bytes_may_come_before_the_segment_that_is_marked_as_last() -> None:
    ended = upload("41 08 10 00 07 00 00 00", FIRST, "1F 00 00 00 00 00 00 00")
    assert ended.result == Uploaded(b"new sla", True, 7, 2)


@pytest.mark.parametrize(
    ("responses", "uploaded"),
    [
        (["4F 08 10 00 01 00 00 00"], Uploaded(b"\x01")),
        (["43 08 10 00 01 02 03 04"], Uploaded(b"\x01\x02\x03\x04")),
        (["42 08 10 00 01 00 00 00"], Uploaded(b"\x01\x00\x00\x00", counted=False)),
        ([INITIATED, FIRST, "1B 76 65 00 00 00 00 00"], Uploaded(b"new slave", True, 9, 2)),
        ([UNSIZED, FIRST, "1B 76 65 00 00 00 00 00"], Uploaded(b"new slave", True, None, 2)),
        (
            [INITIATED, "06 6E 65 77 20 00 00 00", "15 73 6C 61 76 65 00 00"],
            Uploaded(b"new slave", True, 9, 2),
        ),
        ([UNSIZED, "0F 00 00 00 00 00 00 00"], Uploaded(b"", True, None, 1)),
    ],
    ids=["1-byte", "4-bytes", "not-counted", "sized", "unsized", "short-segment", "empty"],
)
def test_uploaded(responses: list[str], uploaded: Uploaded) -> None:
    assert upload(*responses).result == uploaded


def test_minor_breaches_are_noted_and_the_transfer_goes_on() -> None:
    """So that a device with that one flaw can be tested for everything else (V60)."""
    noted: list[Violation] = []
    client = Client(ResponseChecks(noted.append))
    ended = drive(
        client.download(MUX, b"A long string"),
        frames(CONFIRMED, "20 08 10 00 00 00 00 00", "31 08 10 00 00 00 00 00"),
    )
    assert ended.finished
    assert ended.error is None
    assert [violation.rule.id for violation in noted] == ["response.reserved"] * 3
    noted.clear()
    ended = drive(client.upload(MUX), frames("4F 08 10 00 01 00 FF 00"))
    assert ended.result == Uploaded(b"\x01")
    assert [violation.rule.id for violation in noted] == ["response.filler"]


@pytest.mark.parametrize("data", [b"", b"12345"])
def test_data_that_cannot_go_expedited(data: bytes) -> None:
    with pytest.raises(ValueError, match="1 to 4 bytes"):
        next(Client().download(MUX, data, segmented=False))


@UNHURRIED
@given(
    data=st.binary(max_size=60),
    segmented=st.booleans(),
    sized=st.booleans(),
)
def test_what_is_downloaded_can_be_uploaded(data: bytes, segmented: bool, sized: bool) -> None:
    server = Server(ObjectDictionary({MUX: Entry(b"old", DataType.OCTET_STRING)}))
    expedited = not segmented and 1 <= len(data) <= 4
    transfer = Client().download(MUX, data, segmented=not expedited, sized=sized or expedited)
    assert served(transfer, server.receive) is None
    assert served(Client().upload(MUX), server.receive).data == data


@pytest.mark.parametrize("size", [65_535, 65_536, 70_000])
def test_more_than_16_bits_count_in_segments(size: int) -> None:
    data = Random(size).randbytes(size)
    server = Server(ObjectDictionary({MUX: Entry(b"old", DataType.DOMAIN)}))
    served(Client().download(MUX, data, segmented=True), server.receive)
    assert served(Client().upload(MUX), server.receive).data == data


@pytest.mark.parametrize("sized", [True, False])
def test_a_number_goes_expedited_with_and_without_its_count(sized: bool) -> None:
    entry = Entry(bytes(4), DataType.UNSIGNED32)
    server = Server(ObjectDictionary({MUX: entry}))
    served(Client().download(MUX, b"\x01\x02\x03\x04", sized=sized), server.receive)
    assert entry.value == b"\x01\x02\x03\x04"
