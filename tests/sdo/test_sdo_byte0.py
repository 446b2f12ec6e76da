"""Byte 0 of every message, literally as the figures of CiA 301, 7.2.4.3 draw it."""

import pytest

from conformance.sdo import decoding, frames
from conformance.sdo.layout import Message, Multiplexer

MUX = Multiplexer(0x1234, 0x56)
D4 = bytes.fromhex("A1A2A3A4")
D7 = bytes.fromhex("B1B2B3B4B5B6B7")

# Both initiates (7.2.4.3.3, 7.2.4.3.6): byte 0 without its specifier, e, s and n.
INITIATE_BITS = [
    (0x0, False, False, 0),
    (0x1, False, True, 0),
    (0x2, True, False, 0),
    (0x3, True, True, 0),
    (0x7, True, True, 1),
    (0xB, True, True, 2),
    (0xF, True, True, 3),
]


@pytest.mark.parametrize(("low", "expedited", "sized", "unused"), INITIATE_BITS)
def test_initiate_bits(low: int, expedited: bool, sized: bool, unused: int) -> None:
    request = bytes([0x20 | low]) + bytes.fromhex("341256 A1A2A3A4")
    assert decoding.decode_request(request) == frames.DownloadInitiate(
        MUX, expedited, sized, unused, D4
    )
    response = bytes([0x40 | low]) + bytes.fromhex("341256 A1A2A3A4")
    assert decoding.decode_response(response) == frames.UploadInitiateResponse(
        MUX, expedited, sized, unused, D4
    )


# Segments in both directions (7.2.4.3.4, 7.2.4.3.7): byte 0, t, n and c.
SEGMENT_BITS = [
    (0x00, 0, 0, False),
    (0x01, 0, 0, True),
    (0x02, 0, 1, False),
    (0x03, 0, 1, True),
    (0x0E, 0, 7, False),
    (0x0F, 0, 7, True),
    (0x10, 1, 0, False),
    (0x11, 1, 0, True),
    (0x16, 1, 3, False),
    (0x1B, 1, 5, True),
    (0x1F, 1, 7, True),
]


@pytest.mark.parametrize(("command", "toggle", "unused", "last"), SEGMENT_BITS)
def test_segment_bits(command: int, toggle: int, unused: int, last: bool) -> None:
    frame = bytes([command]) + D7
    assert decoding.decode_request(frame) == frames.DownloadSegment(D7, toggle, unused, last)
    assert decoding.decode_response(frame) == frames.UploadSegmentResponse(D7, toggle, unused, last)
    assert frames.DownloadSegment(D7, toggle, unused, last).data == D7[: 7 - unused]


REQUESTS: list[tuple[str, Message]] = [
    ("40 34 12 56 00 00 00 00", frames.UploadInitiate(MUX)),
    ("60 00 00 00 00 00 00 00", frames.UploadSegment(toggle=0)),
    ("70 00 00 00 00 00 00 00", frames.UploadSegment(toggle=1)),
    ("80 34 12 56 01 00 04 05", frames.Abort(MUX, 0x05040001)),
    ("C0 34 12 56 00 00 00 00", frames.BlockDownloadInitiate(MUX, False, False)),
    ("C2 34 12 56 A1 A2 A3 A4", frames.BlockDownloadInitiate(MUX, False, True, D4)),
    ("C4 34 12 56 00 00 00 00", frames.BlockDownloadInitiate(MUX, True, False)),
    ("C6 34 12 56 A1 A2 A3 A4", frames.BlockDownloadInitiate(MUX, True, True, D4)),
    ("C1 CD AB 00 00 00 00 00", frames.BlockEnd(0, 0xABCD)),
    ("C5 CD AB 00 00 00 00 00", frames.BlockEnd(1, 0xABCD)),
    ("C9 CD AB 00 00 00 00 00", frames.BlockEnd(2, 0xABCD)),
    ("CD CD AB 00 00 00 00 00", frames.BlockEnd(3, 0xABCD)),
    ("D1 CD AB 00 00 00 00 00", frames.BlockEnd(4, 0xABCD)),
    ("D5 CD AB 00 00 00 00 00", frames.BlockEnd(5, 0xABCD)),
    ("D9 CD AB 00 00 00 00 00", frames.BlockEnd(6, 0xABCD)),
    ("DD CD AB 00 00 00 00 00", frames.BlockEnd(7, 0xABCD)),
    ("A0 34 12 56 7F 15 00 00", frames.BlockUploadInitiate(MUX, 127, 21, False)),
    ("A4 34 12 56 01 00 00 00", frames.BlockUploadInitiate(MUX, 1, 0, True)),
    ("A3 00 00 00 00 00 00 00", frames.BlockUploadStart()),
    ("A2 03 7F 00 00 00 00 00", frames.BlockAck(3, 127)),
    ("A1 00 00 00 00 00 00 00", frames.BlockEndResponse()),
]
RESPONSES: list[tuple[str, Message]] = [
    ("60 34 12 56 00 00 00 00", frames.DownloadInitiateResponse(MUX)),
    ("20 00 00 00 00 00 00 00", frames.DownloadSegmentResponse(toggle=0)),
    ("30 00 00 00 00 00 00 00", frames.DownloadSegmentResponse(toggle=1)),
    ("80 34 12 56 00 00 03 05", frames.Abort(MUX, 0x05030000)),
    ("A0 34 12 56 7F 00 00 00", frames.BlockDownloadInitiateResponse(MUX, 127, False)),
    ("A4 34 12 56 01 00 00 00", frames.BlockDownloadInitiateResponse(MUX, 1, True)),
    ("A2 00 7F 00 00 00 00 00", frames.BlockAck(0, 127)),
    ("A1 00 00 00 00 00 00 00", frames.BlockEndResponse()),
    ("C0 34 12 56 00 00 00 00", frames.BlockUploadInitiateResponse(MUX, False, False)),
    ("C2 34 12 56 A1 A2 A3 A4", frames.BlockUploadInitiateResponse(MUX, False, True, D4)),
    ("C4 34 12 56 00 00 00 00", frames.BlockUploadInitiateResponse(MUX, True, False)),
    ("C6 34 12 56 A1 A2 A3 A4", frames.BlockUploadInitiateResponse(MUX, True, True, D4)),
    ("C1 CD AB 00 00 00 00 00", frames.BlockEnd(0, 0xABCD)),
    ("DD 00 00 00 00 00 00 00", frames.BlockEnd(7, 0)),
]
SEGMENTS: list[tuple[str, Message]] = [
    ("01 B1 B2 B3 B4 B5 B6 B7", frames.BlockSegment(1, D7)),
    ("7F B1 B2 B3 B4 B5 B6 B7", frames.BlockSegment(127, D7)),
    ("81 B1 B2 B3 B4 B5 B6 B7", frames.BlockSegment(1, D7, last=True)),
    ("FF B1 B2 B3 B4 B5 B6 B7", frames.BlockSegment(127, D7, last=True)),
    ("00 B1 B2 B3 B4 B5 B6 B7", frames.BlockSegment(0, D7)),
    ("40 B1 B2 B3 B4 B5 B6 B7", frames.BlockSegment(64, D7)),
    ("C6 B1 B2 B3 B4 B5 B6 B7", frames.BlockSegment(70, D7, last=True)),
    ("E0 B1 B2 B3 B4 B5 B6 B7", frames.BlockSegment(96, D7, last=True)),
    ("80 34 12 56 04 00 04 05", frames.Abort(MUX, 0x05040004)),
]


@pytest.mark.parametrize(("frame", "message"), REQUESTS)
def test_request(frame: str, message: Message) -> None:
    assert decoding.decode_request(bytes.fromhex(frame)) == message
    assert message.encode() == bytes.fromhex(frame)


@pytest.mark.parametrize(("frame", "message"), RESPONSES)
def test_response(frame: str, message: Message) -> None:
    assert decoding.decode_response(bytes.fromhex(frame)) == message
    assert message.encode() == bytes.fromhex(frame)


@pytest.mark.parametrize(("frame", "message"), SEGMENTS)
def test_block_segment(frame: str, message: Message) -> None:
    assert decoding.decode_segment(bytes.fromhex(frame)) == message
    assert message.encode() == bytes.fromhex(frame)


# A row for each value of bits 7..5; within it, by bits 1..0 where there are sub-commands.
REQUEST_KINDS: list[list[type[Message]]] = [
    [frames.DownloadSegment] * 4,
    [frames.DownloadInitiate] * 4,
    [frames.UploadInitiate] * 4,
    [frames.UploadSegment] * 4,
    [frames.Abort] * 4,
    [frames.BlockUploadInitiate, frames.BlockEndResponse, frames.BlockAck, frames.BlockUploadStart],
    [frames.BlockDownloadInitiate, frames.BlockEnd] * 2,
]
RESPONSE_KINDS: list[list[type[Message]]] = [
    [frames.UploadSegmentResponse] * 4,
    [frames.DownloadSegmentResponse] * 4,
    [frames.UploadInitiateResponse] * 4,
    [frames.DownloadInitiateResponse] * 4,
    [frames.Abort] * 4,
    # Sub-command 3 has no meaning from a server.
    [frames.BlockDownloadInitiateResponse, frames.BlockEndResponse, frames.BlockAck],
    [frames.BlockUploadInitiateResponse, frames.BlockEnd] * 2,
]


@pytest.mark.parametrize("command", range(0xE0))
def test_every_command_belongs_to_one_request(command: int) -> None:
    kind = REQUEST_KINDS[command >> 5][command & 3]
    assert type(decoding.decode_request(bytes([command, *bytes(7)]))) is kind


@pytest.mark.parametrize(
    "command", [command for command in range(0xE0) if command >> 5 != 5 or command & 3 != 3]
)
def test_every_command_belongs_to_one_response(command: int) -> None:
    kind = RESPONSE_KINDS[command >> 5][command & 3]
    assert type(decoding.decode_response(bytes([command, *bytes(7)]))) is kind


@pytest.mark.parametrize(
    ("message", "data", "size"),
    [
        (frames.DownloadInitiate.with_data(MUX, b"\x01"), b"\x01", None),
        (frames.DownloadInitiate.with_data(MUX, b"\x01\x02\x03\x04"), b"\x01\x02\x03\x04", None),
        (frames.DownloadInitiate.with_uncounted_data(MUX, b"\x01"), b"\x01\x00\x00\x00", None),
        (frames.DownloadInitiate.with_size(MUX, 14), b"\x0e\x00\x00\x00", 14),
        (frames.DownloadInitiate.with_size(MUX, 0xFFFFFFFF), b"\xff\xff\xff\xff", 0xFFFFFFFF),
        (frames.DownloadInitiate.with_size(MUX, None), bytes(4), None),
    ],
)
def test_initiate_carries_data_or_size(
    message: frames.DownloadInitiate, data: bytes, size: int | None
) -> None:
    assert (message.data, message.size) == (data, size)


def test_block_initiate_carries_the_size() -> None:
    assert frames.BlockDownloadInitiate.with_size(MUX, 30).encode().hex() == "c63412561e000000"
    assert frames.BlockDownloadInitiate.with_size(MUX, 30).size == 30
    without = frames.BlockUploadInitiateResponse.with_size(MUX, None, crc_supported=False)
    assert without.encode().hex() == "c034125600000000"
    assert without.size is None
