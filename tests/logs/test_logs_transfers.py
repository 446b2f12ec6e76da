"""Transfers in a log: each in a line of words when it ends."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conformance.logs.decoded_lines import Words
from conformance.logs.reading import Seen
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.crc import crc16

NODE_ID = 5
TEXT = b"conformance of SDO servers"


def told(*frames: str, only: int | None = None) -> list[str]:
    """Return what is said of transfers; a frame comes each millisecond."""
    words = Words(only)
    lines: list[str] = []
    for number, frame in enumerate(frames):
        lines += words.lines(Seen(number, number / 1000, "can0", CanFrame.parse(frame)))
    return [line.split(" = ")[1].strip() for line in lines if " = " in line]


def client(text: str) -> str:
    return f"605#{text.replace(' ', '').ljust(16, '0')}"


def server(text: str) -> str:
    return f"585#{text.replace(' ', '').ljust(16, '0')}"


def test_a_segmented_upload() -> None:
    assert told(
        client("40 0810 00"),
        server("41 0810 00 0A"),
        client("60"),
        server("00 41424344454647"),
        client("70"),
        server("19 48494A"),
    ) == ["node 5: upload of 10 bytes from 1008h:00 in 2 segments, 5.0 ms"]


def test_a_segmented_download_of_another_size_than_announced() -> None:
    (line,) = told(client("21 0120 00 0E"), server("60 0120 00"), client("0F 41"), server("20"))
    assert line == (
        "node 5: download of 0 bytes to 2001h:00 in 1 segment, 14 were announced, 3.0 ms"
    )


def test_what_one_exchange_does_has_no_line_of_its_own() -> None:
    expedited = [client("40 1810 01"), server("43 1810 01 04"), client("2F 0120 00 11")]
    refused = [server("80 0120 00 02000106"), client("40 0120 00"), server("80 0120 00 02000106")]
    assert told(*expedited, *refused) == []


@pytest.mark.parametrize(
    ("end", "words"),
    [
        (
            server("80 0120 00 00000305"),
            "aborted by the server behind 1 segment, 4.0 ms: 0503",
        ),
        (
            client("80 0120 00 00000405"),
            "aborted by the client behind 1 segment, 4.0 ms: 0504",
        ),
        (client("40 0010 00"), "left by the client behind 1 segment, 4.0 ms"),
    ],
)
def test_a_transfer_that_does_not_end(end: str, words: str) -> None:
    begin = [client("21 0120 00 0E"), server("60 0120 00"), client("00 41"), server("20")]
    (line,) = told(*begin, end)
    assert line.startswith(f"node 5: download of 14 bytes to 2001h:00 {words}")


def block_download(data: bytes, block_size: int, *, crc: int, lost: int = 0) -> list[str]:
    """Return the frames of a block download; the segment ``lost`` of the first sub-block is."""
    payloads = [data[at : at + 7].ljust(7, b"\0") for at in range(0, len(data), 7)]
    frames = [client(f"C6 0120 00 {len(data):02X}"), server(f"A4 0120 00 {block_size:02X}")]
    while payloads:
        sent = payloads[:block_size]
        for number, payload in enumerate(sent, start=1):
            mark = 0x80 if number == len(payloads) else 0
            frames.append(client(f"{mark | number:02X} {payload.hex()}"))
        acknowledged, lost = (lost - 1 if lost else len(sent)), 0
        frames.append(server(f"A2 {acknowledged:02X} {block_size:02X}"))
        payloads = payloads[acknowledged:]
    unused = -len(data) % 7
    end = client(f"{0xC1 | unused << 2:02X} {crc.to_bytes(2, 'little').hex()}")
    return [*frames, end, server("A1")]


def test_a_block_download() -> None:
    (line,) = told(*block_download(TEXT, 2, crc=crc16(TEXT)))
    assert line == (
        "node 5: block download of 26 bytes to 2001h:00 in 2 sub-blocks, CRC right, 9.0 ms"
    )


def test_a_block_download_with_a_segment_that_was_lost() -> None:
    (line,) = told(*block_download(TEXT, 3, crc=crc16(TEXT), lost=2))
    assert "in 2 sub-blocks, 2 segments sent again, CRC right, " in line


def test_a_wrong_crc() -> None:
    (line,) = told(*block_download(TEXT, 4, crc=0x1234))
    assert f"CRC wrong (1234h instead of {crc16(TEXT):04X}h)" in line


@given(st.binary(min_size=1, max_size=200), st.integers(1, 127), st.data())
def test_any_block_download(data: bytes, block_size: int, draw: st.DataObject) -> None:
    first = min(block_size, -(-len(data) // 7))
    lost = draw.draw(st.integers(0, first))
    (line,) = told(*block_download(data, block_size, crc=crc16(data), lost=lost))
    size = "1 byte" if len(data) == 1 else f"{len(data)} bytes"
    assert line.startswith(f"node 5: block download of {size} to 2001h:00 in ")
    assert "CRC right" in line


def test_a_block_upload_without_crc() -> None:
    assert told(
        client("A0 0810 00 7F"),
        server("C2 0810 00 0A"),
        client("A3"),
        server("01 41424344454647"),
        server("82 48494A"),
        client("A2 02 7F"),
        server("D1"),
        client("A1"),
    ) == ["node 5: block upload of 10 bytes from 1008h:00 in 1 sub-block, without CRC, 7.0 ms"]


def test_a_block_upload_that_is_served_in_segments() -> None:
    assert told(
        client("A4 0810 00 7F 20"), server("41 0810 00 03"), client("60"), server("09 414243")
    ) == ["node 5: upload of 3 bytes from 1008h:00 in 1 segment, 3.0 ms"]


def test_a_log_that_begins_in_a_transfer() -> None:
    assert (
        told(client("70"), server("19 48494A"), client("00 41"), server("20"), server("A1")) == []
    )


def test_channels_are_followed_each_by_itself() -> None:
    other = ["609#4008100000000000", "589#410810000A000000"]
    mine = [client("40 0810 00"), server("41 0810 00 03"), client("60"), server("09 414243")]
    mixed = [frame for pair in zip(mine[:2], other, strict=True) for frame in pair]
    assert told(*mixed, *mine[2:]) == [
        "node 5: upload of 3 bytes from 1008h:00 in 1 segment, 5.0 ms"
    ]
    assert told(*mixed, *mine[2:], only=9) == []


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        ("080#", "SYNC"),
        ("080#07", "SYNC, counter 7"),
        ("085#1081110000000000", "emergency of node 5: error code 8110h, error register 11h"),
        ("100#000000000000", "TIME"),
        ("185#0102", "TPDO 1 of node 5"),
        ("205#0102", "RPDO 1 of node 5"),
        ("505#", "RPDO 4 of node 5"),
        ("185#R", "request for TPDO 1 of node 5"),
        ("705#R", "node guarding request to node 5"),
        ("705#05", "heartbeat of node 5: operational"),
        ("7E5#0401", "LSS request"),
        ("7E4#44", "LSS response"),
        ("000#0105", "NMT: start, node 5"),
        ("180#01", ""),
        ("00000185#01", ""),
        ("6E5#01", ""),
    ],
)
def test_other_frames_of_canopen(frame: str, words: str) -> None:
    lines = list(Words().lines(Seen(1, 0.0, "can0", CanFrame.parse(frame))))
    assert [line.split(maxsplit=4)[4] for line in lines] == ([words] if words else [])
    other = Words(9).lines(Seen(1, 0.0, "can0", CanFrame.parse(frame)))
    assert not list(other), "neither of this node nor to it"


def test_a_last_segment_that_comes_again_is_counted_once() -> None:
    crc = crc16(b"ABCDEFG").to_bytes(2, "little").hex().upper()
    assert told(
        client("C6 1020 00 07"), server("A4 1020 00 7F"),
        client("81 41424344454647"), server("A2 01 7F"),
        client("81 41424344454647"), server("A2 01 7F"),
        client(f"C1 {crc}"), server("A1"),
    ) == [
        "node 5: block download of 7 bytes to 2010h:00 in 1 sub-block, 1 segment sent again, "
        "CRC right, 7.0 ms"
    ]  # fmt: skip
