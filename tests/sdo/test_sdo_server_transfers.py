"""Segmented transfers of the reference server: how it reacts in the middle of them."""

import pytest
from sdo_server_bench import Bench

# Initiates that lead into a transfer; every row below is put behind one of them.
DOWNLOAD = """
    > 21 01 20 00 0E 00 00 00
    < 60 01 20 00 00 00 00 00
"""
DOWNLOAD_WITHOUT_SIZE = """
    > 20 01 20 00 00 00 00 00
    < 60 01 20 00 00 00 00 00
"""
FIRST_SEGMENT = """
    > 00 41 42 43 44 45 46 47
    < 20 00 00 00 00 00 00 00
"""
UPLOAD = """
    > 40 08 10 00 00 00 00 00
    < 41 08 10 00 1A 00 00 00
"""
FIRST_UPLOADED = """
    > 60 00 00 00 00 00 00 00
    < 00 54 69 6E 79 20 4E 6F
"""

# A frame, and the answer that ends the download of 14 bytes after its first segment.
KILLS_DOWNLOAD = [
    pytest.param("00 48 49 4A 4B 4C 4D 4E", "80 01 20 00 00 00 03 05", id="toggle-repeated"),
    pytest.param("1F 00 00 00 00 00 00 00", "80 01 20 00 13 00 07 06", id="too-short"),
    pytest.param("60 00 00 00 00 00 00 00", "80 01 20 00 01 00 04 05", id="60h"),
    pytest.param("70 00 00 00 00 00 00 00", "80 01 20 00 01 00 04 05", id="70h"),
    pytest.param("E0 00 10 00 00 00 00 00", "80 01 20 00 01 00 04 05", id="ccs-7"),
    pytest.param("A1 00 00 00 00 00 00 00", "80 01 20 00 01 00 04 05", id="A1h"),
    pytest.param("A2 01 7F 00 00 00 00 00", "80 01 20 00 01 00 04 05", id="A2h"),
    pytest.param("A3 00 00 00 00 00 00 00", "80 01 20 00 01 00 04 05", id="A3h"),
    pytest.param("DD 00 00 00 00 00 00 00", "80 01 20 00 01 00 04 05", id="DDh"),
]
KILLS_UPLOAD = [
    pytest.param("60 00 00 00 00 00 00 00", "80 08 10 00 00 00 03 05", id="toggle-repeated"),
    pytest.param("10 41 42 43 44 45 46 47", "80 08 10 00 01 00 04 05", id="segment"),
    pytest.param("00 41 42 43 44 45 46 47", "80 08 10 00 01 00 04 05", id="other-toggle"),
    pytest.param("E0 00 10 00 00 00 00 00", "80 08 10 00 01 00 04 05", id="ccs-7"),
    pytest.param("A1 00 00 00 00 00 00 00", "80 08 10 00 01 00 04 05", id="A1h"),
    pytest.param("A2 01 7F 00 00 00 00 00", "80 08 10 00 01 00 04 05", id="A2h"),
    pytest.param("A3 00 00 00 00 00 00 00", "80 08 10 00 01 00 04 05", id="A3h"),
    pytest.param("C1 00 00 00 00 00 00 00", "80 08 10 00 01 00 04 05", id="C1h"),
]
# New initiates in mid-transfer: the old transfer ends, the new one is served.
NEW_INITIATES = [
    pytest.param("40 00 10 00 00 00 00 00", "43 00 10 00 91 01 0F 00", id="upload"),
    pytest.param("40 08 10 00 00 00 00 00", "41 08 10 00 1A 00 00 00", id="upload-in-segments"),
    pytest.param("23 00 20 00 01 02 03 04", "60 00 20 00 00 00 00 00", id="download"),
    pytest.param("21 01 20 00 0E 00 00 00", "60 01 20 00 00 00 00 00", id="download-in-segments"),
    pytest.param("40 04 10 00 00 00 00 00", "80 04 10 00 00 00 02 06", id="refused"),
]


@pytest.mark.parametrize(("frame", "abort"), KILLS_DOWNLOAD)
def test_download_is_aborted_and_writes_nothing(frame: str, abort: str) -> None:
    bench = Bench()
    bench.replay(f"{DOWNLOAD} {FIRST_SEGMENT} > {frame} \n < {abort}")
    assert bench.is_idle()
    assert bench.value("2001") == b"before"


@pytest.mark.parametrize(("frame", "abort"), KILLS_UPLOAD)
def test_upload_is_aborted(frame: str, abort: str) -> None:
    bench = Bench()
    bench.replay(f"{UPLOAD} {FIRST_UPLOADED} > {frame} \n < {abort}")
    assert bench.is_idle()


def test_d3_the_first_segment_has_toggle_0() -> None:
    bench = Bench()
    bench.replay(f"{DOWNLOAD} > 10 41 42 43 44 45 46 47 \n < 80 01 20 00 00 00 03 05")
    assert bench.is_idle()


def test_u2_the_first_request_has_toggle_0() -> None:
    bench = Bench()
    bench.replay(f"{UPLOAD} > 70 00 00 00 00 00 00 00 \n < 80 08 10 00 00 00 03 05")
    assert bench.is_idle()


# Downloads to 2001h that succeed, behind their initiate, and what is written.
COMPLETE = [
    pytest.param(
        DOWNLOAD + FIRST_SEGMENT,
        "> 11 48 49 4A 4B 4C 4D 4E \n < 30 00 00 00 00 00 00 00",
        b"ABCDEFGHIJKLMN",
        id="full-last-segment",
    ),
    pytest.param(
        DOWNLOAD_WITHOUT_SIZE + FIRST_SEGMENT,
        "> 1D 48 FF FF FF FF FF FF \n < 30 00 00 00 00 00 00 00",
        b"ABCDEFGH",
        id="filler-is-not-stored",
    ),
    pytest.param(
        DOWNLOAD_WITHOUT_SIZE,
        "> 0E FF FF FF FF FF FF FF \n < 20 00 00 00 00 00 00 00 \n"
        "> 16 41 42 43 44 00 00 00 \n < 30 00 00 00 00 00 00 00 \n"
        "> 0D 45 00 00 00 00 00 00 \n < 20 00 00 00 00 00 00 00",
        b"ABCDE",
        id="short-segments-in-the-middle",
    ),
    pytest.param(
        DOWNLOAD_WITHOUT_SIZE + FIRST_SEGMENT,
        "> 1F 00 00 00 00 00 00 00 \n < 30 00 00 00 00 00 00 00",
        b"ABCDEFG",
        id="empty-last-segment",
    ),
    pytest.param(
        "> 21 01 20 00 08 00 00 00 \n < 60 01 20 00 00 00 00 00 \n" + FIRST_SEGMENT,
        "> 11 48 00 00 00 00 00 00 \n < 30 00 00 00 00 00 00 00",
        b"ABCDEFGH",
        id="n-not-stated-in-the-last-segment",
    ),
    pytest.param(
        "> 21 01 20 00 00 00 00 00 \n < 60 01 20 00 00 00 00 00 \n",
        "> 0F 00 00 00 00 00 00 00 \n < 20 00 00 00 00 00 00 00",
        b"",
        id="empty-value",
    ),
]


@pytest.mark.parametrize(("begin", "rest", "value"), COMPLETE)
def test_download_is_written_at_its_end(begin: str, rest: str, value: bytes) -> None:
    bench = Bench()
    bench.replay(begin)
    assert bench.value("2001") == b"before"
    bench.replay(rest)
    assert bench.value("2001") == value
    assert bench.is_idle()


TOO_LONG = [
    pytest.param(
        "> 21 01 20 00 08 00 00 00 \n < 60 01 20 00 00 00 00 00 \n" + FIRST_SEGMENT,
        "> 10 48 49 4A 4B 4C 4D 4E \n < 80 01 20 00 12 00 07 06",
        id="announced-8",
    ),
    pytest.param(
        "> 21 01 20 00 08 00 00 00 \n < 60 01 20 00 00 00 00 00 \n" + FIRST_SEGMENT,
        "> 1B 48 49 00 00 00 00 00 \n < 80 01 20 00 12 00 07 06",
        id="last-segment-says-2-instead-of-1",
    ),
    pytest.param(
        DOWNLOAD_WITHOUT_SIZE
        + "> 00 00 00 00 00 00 00 00 \n < 20 00 00 00 00 00 00 00 \n"
        + "> 10 00 00 00 00 00 00 00 \n < 30 00 00 00 00 00 00 00 \n"
        + "> 00 00 00 00 00 00 00 00 \n < 20 00 00 00 00 00 00 00 \n"
        + "> 10 00 00 00 00 00 00 00 \n < 30 00 00 00 00 00 00 00 \n",
        "> 01 00 00 00 00 00 00 00 \n < 80 01 20 00 12 00 07 06",
        id="more-than-the-32-bytes-of-the-object",
    ),
]


@pytest.mark.parametrize(("begin", "rest"), TOO_LONG)
def test_d4_too_many_bytes(begin: str, rest: str) -> None:
    bench = Bench()
    bench.replay(begin + rest)
    assert bench.value("2001") == b"before"
    assert bench.is_idle()


def test_d5_a_number_without_size_may_not_be_too_short() -> None:
    bench = Bench()
    bench.replay("""
        > 20 00 20 00 00 00 00 00
        < 60 00 20 00 00 00 00 00
        > 09 01 02 03 00 00 00 00
        < 80 00 20 00 13 00 07 06
    """)
    assert bench.value("2000") == b"\x11\x22\x33\x44"
    assert bench.is_idle()


def test_limits_hold_for_segmented_downloads() -> None:
    bench = Bench()
    bench.replay("""
        > 21 03 20 00 02 00 00 00
        < 60 03 20 00 00 00 00 00
        > 0B 65 00 00 00 00 00 00
        < 80 03 20 00 31 00 09 06
    """)
    assert bench.value("2003") == b"\x05\x00"
    assert bench.is_idle()


@pytest.mark.parametrize("begin", [DOWNLOAD + FIRST_SEGMENT, UPLOAD + FIRST_UPLOADED])
@pytest.mark.parametrize(("request_", "answer"), NEW_INITIATES)
def test_a_new_initiate_is_served(begin: str, request_: str, answer: str) -> None:
    bench = Bench()
    bench.replay(f"{begin} > {request_} \n < {answer}")
    assert bench.value("2001") == b"before"


def test_u6_a_restarted_upload_begins_anew() -> None:
    Bench().replay(UPLOAD + FIRST_UPLOADED + UPLOAD + FIRST_UPLOADED)


def test_d13_a_restarted_download_begins_anew() -> None:
    bench = Bench()
    bench.replay(DOWNLOAD + FIRST_SEGMENT + DOWNLOAD + FIRST_SEGMENT)
    bench.replay("> 11 48 49 4A 4B 4C 4D 4E \n < 30 00 00 00 00 00 00 00")
    assert bench.value("2001") == b"ABCDEFGHIJKLMN"


@pytest.mark.parametrize("begin", [DOWNLOAD + FIRST_SEGMENT, UPLOAD + FIRST_UPLOADED])
@pytest.mark.parametrize(
    "abort",
    ["80 01 20 00 00 00 00 08", "80 08 10 00 00 00 00 08", "80 FF FF FF 00 00 04 05"],
)
def test_an_abort_ends_the_transfer_without_an_answer(begin: str, abort: str) -> None:
    bench = Bench()
    bench.replay(f"{begin} > {abort}")
    assert bench.is_idle()
    assert bench.value("2001") == b"before"


@pytest.mark.parametrize(
    ("begin", "abort"),
    [
        (DOWNLOAD + FIRST_SEGMENT, "80 01 20 00 00 00 04 05"),
        (UPLOAD + FIRST_UPLOADED, "80 08 10 00 00 00 04 05"),
    ],
    ids=["download", "upload"],
)
def test_time_out(begin: str, abort: str) -> None:
    bench = Bench()
    bench.replay(begin)
    assert [frame.hex(" ").upper() for frame in bench.server.expire()] == [abort]
    assert bench.server.expire() == []
    assert bench.is_idle()
    assert bench.value("2001") == b"before"


def test_u1_the_whole_upload_and_u11_a_request_behind_its_end() -> None:
    Bench().replay(f"""
        {UPLOAD}
        {FIRST_UPLOADED}
        > 70 00 00 00 00 00 00 00
        < 10 64 65 20 2D 20 4D 65
        > 60 00 00 00 00 00 00 00
        < 00 67 61 20 44 6F 6D 61
        > 70 00 00 00 00 00 00 00
        < 15 69 6E 73 20 21 00 00
        > 60 00 00 00 00 00 00 00
        < 80 00 00 00 01 00 04 05
    """)


def test_d19_a_segment_behind_the_end() -> None:
    Bench().replay(f"""
        {DOWNLOAD}
        {FIRST_SEGMENT}
        > 11 48 49 4A 4B 4C 4D 4E
        < 30 00 00 00 00 00 00 00
        > 00 41 42 43 44 45 46 47
        < 80 00 00 00 01 00 04 05
    """)


def test_u8_u9_reserved_bits_and_bytes_are_ignored() -> None:
    Bench().replay(f"{UPLOAD} > 6F 08 10 00 FF FF FF FF \n < 00 54 69 6E 79 20 4E 6F")


@pytest.mark.parametrize("frame", ["10", "10 48 49 4A 4B 4C 4D"])
def test_d17_a_short_frame_is_ignored_and_the_transfer_goes_on(frame: str) -> None:
    bench = Bench()
    bench.replay(f"{DOWNLOAD} {FIRST_SEGMENT} > {frame}")
    bench.replay("> 11 48 49 4A 4B 4C 4D 4E \n < 30 00 00 00 00 00 00 00")
    assert bench.value("2001") == b"ABCDEFGHIJKLMN"
