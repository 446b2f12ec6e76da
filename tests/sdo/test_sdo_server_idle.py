"""The idle reference server: how it reacts to each kind of frame."""

import pytest
from sdo_server_bench import Bench, objects

# The request, and the answers.
EXCHANGES = [
    pytest.param("40 00 10 00 00 00 00 00", ["43 00 10 00 91 01 0F 00"], id="upload-4"),
    pytest.param("40 18 10 00 00 00 00 00", ["4F 18 10 00 04 00 00 00"], id="upload-1"),
    pytest.param("40 03 20 00 00 00 00 00", ["4B 03 20 00 05 00 00 00"], id="upload-2"),
    pytest.param("40 08 10 00 00 00 00 00", ["41 08 10 00 1A 00 00 00"], id="upload-26"),
    pytest.param("40 04 20 00 00 00 00 00", ["41 04 20 00 00 00 00 00"], id="upload-0"),
    pytest.param("23 00 20 00 01 02 03 04", ["60 00 20 00 00 00 00 00"], id="download-4"),
    pytest.param("2F 06 20 00 7F 00 00 00", ["60 06 20 00 00 00 00 00"], id="download-1"),
    pytest.param("21 01 20 00 08 00 00 00", ["60 01 20 00 00 00 00 00"], id="download-8"),
    pytest.param("40 04 10 00 00 00 00 00", ["80 04 10 00 00 00 02 06"], id="missing-upload"),
    pytest.param("2F 04 10 07 00 00 00 00", ["80 04 10 07 00 00 02 06"], id="missing-download"),
    pytest.param("40 00 10 01 00 00 00 00", ["80 00 10 01 11 00 09 06"], id="sub-of-var"),
    pytest.param("40 18 10 FF 00 00 00 00", ["80 18 10 FF 11 00 09 06"], id="no-sub-index-FFh"),
    pytest.param(
        "23 18 10 09 00 00 00 00", ["80 18 10 09 11 00 09 06"], id="no-sub-index-download"
    ),
    pytest.param("40 02 20 00 00 00 00 00", ["80 02 20 00 01 00 01 06"], id="read-of-wo"),
    pytest.param("23 00 10 00 91 01 0F 00", ["80 00 10 00 02 00 01 06"], id="write-to-ro"),
    pytest.param("21 08 10 00 1A 00 00 00", ["80 08 10 00 02 00 01 06"], id="write-to-const"),
    pytest.param("20 00 10 00 00 00 00 00", ["80 00 10 00 02 00 01 06"], id="write-to-ro-no-size"),
    pytest.param("E0 00 10 00 00 00 00 00", ["80 00 00 00 01 00 04 05"], id="unknown-E0h"),
    pytest.param("FF FF FF FF FF FF FF FF", ["80 00 00 00 01 00 04 05"], id="unknown-FFh"),
    pytest.param("00 01 02 03 04 05 06 07", ["80 00 00 00 01 00 04 05"], id="segment"),
    pytest.param("60 00 00 00 00 00 00 00", ["80 00 00 00 01 00 04 05"], id="upload-segment"),
    pytest.param("C1 00 00 00 00 00 00 00", ["80 00 00 00 01 00 04 05"], id="block-end"),
    pytest.param("A1 00 00 00 00 00 00 00", ["80 00 00 00 01 00 04 05"], id="A1h"),
    pytest.param("A2 01 7F 00 00 00 00 00", ["80 00 00 00 01 00 04 05"], id="A2h"),
    pytest.param("A3 00 00 00 00 00 00 00", ["80 00 00 00 01 00 04 05"], id="A3h"),
    pytest.param("80 00 10 00 00 00 00 08", [], id="abort"),
    pytest.param("80 00 00 00 00 00 00 00", [], id="abort-with-a-private-code"),
    pytest.param("9F 00 10 00 00 00 00 08", [], id="abort-with-reserved-bits"),
    pytest.param(
        "5F 00 10 00 00 00 00 00", ["43 00 10 00 91 01 0F 00"], id="request-reserved-bits"
    ),
    pytest.param("33 00 20 00 01 02 03 04", ["60 00 20 00 00 00 00 00"], id="request-reserved-bit"),
    pytest.param(
        "40 00 10 00 AA BB CC DD", ["43 00 10 00 91 01 0F 00"], id="request-reserved-bytes"
    ),
    pytest.param("27 06 20 00 01 02 03 00", ["80 06 20 00 12 00 07 06"], id="too-long"),
    pytest.param("2B 00 20 00 01 02 00 00", ["80 00 20 00 13 00 07 06"], id="too-short"),
    pytest.param(
        "22 00 20 00 01 02 03 04",
        ["60 00 20 00 00 00 00 00"],
        id="size-not-indicated-size-not-indicated",
    ),
    pytest.param("22 05 20 00 01 02 03 04", ["80 05 20 00 13 00 07 06"], id="22h-into-8-bytes"),
    pytest.param("21 00 20 00 05 00 00 00", ["80 00 20 00 12 00 07 06"], id="number-too-long"),
    pytest.param("21 00 20 00 03 00 00 00", ["80 00 20 00 13 00 07 06"], id="number-too-short"),
    pytest.param("21 00 20 00 00 00 00 00", ["80 00 20 00 13 00 07 06"], id="number-empty"),
    pytest.param("21 01 20 00 FF FF FF FF", ["80 01 20 00 12 00 07 06"], id="huge-size"),
    pytest.param(
        "20 00 20 00 00 00 00 00",
        ["60 00 20 00 00 00 00 00"],
        id="size-not-indicated-size-not-indicated",
    ),
    pytest.param("20 00 20 00 FF FF FF FF", ["60 00 20 00 00 00 00 00"], id="reserved"),
    pytest.param("2B 03 20 00 65 00 00 00", ["80 03 20 00 31 00 09 06"], id="above"),
    pytest.param("2B 03 20 00 F5 FF 00 00", ["80 03 20 00 32 00 09 06"], id="below"),
    pytest.param("2B 03 20 00 64 00 00 00", ["60 03 20 00 00 00 00 00"], id="highest"),
    pytest.param("2B 03 20 00 F6 FF 00 00", ["60 03 20 00 00 00 00 00"], id="lowest"),
    pytest.param("A6 00 10 00 7F 00 00 00", ["80 00 00 00 01 00 04 05"], id="A6h"),
    pytest.param("C7 00 20 00 04 00 00 00", ["80 00 00 00 01 00 04 05"], id="C7h"),
]
REFUSED_WRITES = [
    "27 06 20 00 01 02 03 00",
    "2B 00 20 00 01 02 00 00",
    "2B 03 20 00 65 00 00 00",
    "2B 03 20 00 F5 FF 00 00",
    "23 00 10 00 01 02 03 04",
    "23 18 10 01 01 02 03 04",
]


@pytest.mark.parametrize(("request_", "answers"), EXCHANGES)
def test_reaction(request_: str, answers: list[str]) -> None:
    assert Bench().ask(request_) == answers


@pytest.mark.parametrize("request_", REFUSED_WRITES)
def test_a_refused_write_changes_nothing(request_: str) -> None:
    bench = Bench()
    assert [answer[:2] for answer in bench.ask(request_)] == ["80"]
    assert {mux: entry.value for mux, entry in bench.entries.items()} == {
        mux: entry.value for mux, entry in objects().items()
    }
    assert bench.is_idle()


@pytest.mark.parametrize(
    ("request_", "name", "value"),
    [
        ("23 00 20 00 01 02 03 04", "2000", b"\x01\x02\x03\x04"),
        ("22 00 20 00 01 02 03 04", "2000", b"\x01\x02\x03\x04"),
        ("22 06 20 00 7F 02 03 04", "2006", b"\x7f"),
        ("23 02 20 00 01 02 03 04", "2002", b"\x01\x02\x03\x04"),
        ("2B 03 20 00 F6 FF 00 00", "2003", b"\xf6\xff"),
        ("2F 06 20 00 7F AA BB CC", "2006", b"\x7f"),
        ("2B 01 20 00 01 02 AA BB", "2001", b"\x01\x02"),
    ],
    ids=[
        "counted",
        "uncounted",
        "uncounted-short",
        "wo",
        "limit",
        "filler-of-fixed-size",
        "filler-of-domain",
    ],
)
def test_an_expedited_write_stores_the_bytes_that_count(
    request_: str, name: str, value: bytes
) -> None:
    bench = Bench()
    assert [answer[:2] for answer in bench.ask(request_)] == ["60"]
    assert bench.value(name) == value
    assert bench.is_idle()


@pytest.mark.parametrize("length", range(8))
def test_short_frames_are_ignored(length: int) -> None:
    bench = Bench()
    assert bench.server.receive(bytes.fromhex("2300200001020304")[:length]) == []
    assert bench.value("2000") == b"\x11\x22\x33\x44"
    assert bench.is_idle()


def test_time_out_without_a_transfer_says_nothing() -> None:
    assert Bench().server.expire() == []


def test_an_entry_may_be_empty_and_is_then_uploaded_in_one_segment() -> None:
    Bench().replay("""
        > 40 04 20 00 00 00 00 00
        < 41 04 20 00 00 00 00 00
        > 60 00 00 00 00 00 00 00
        < 0F 00 00 00 00 00 00 00
        > 40 00 10 00 00 00 00 00
        < 43 00 10 00 91 01 0F 00
    """)
