"""The codec: nothing of a message or of a frame gets lost, whatever the direction."""

from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.sdo_strategies import FRAMES, OTHER_LENGTHS, REQUESTS, RESPONSES, SEGMENTS, UNHURRIED

from conformance.sdo.decoding import (
    as_answer,
    as_segment,
    decode_request,
    decode_response,
    decode_segment,
)
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiateResponse,
    BlockSegment,
    DownloadInitiate,
    DownloadSegment,
    Request,
    Response,
    Unknown,
    UploadInitiate,
)
from conformance.sdo.layout import Message, Multiplexer

MUX = Multiplexer(0x2000)


@pytest.mark.parametrize("kind", REQUESTS, ids=lambda kind: kind.__name__)
@UNHURRIED
@given(data=st.data())
def test_request_survives_its_encoding(kind: type[Message], data: st.DataObject) -> None:
    message = data.draw(REQUESTS[kind])
    assert decode_request(message.encode()) == message


@pytest.mark.parametrize("kind", RESPONSES, ids=lambda kind: kind.__name__)
@UNHURRIED
@given(data=st.data())
def test_response_survives_its_encoding(kind: type[Message], data: st.DataObject) -> None:
    message = data.draw(RESPONSES[kind])
    assert decode_response(message.encode()) == message


@pytest.mark.parametrize("kind", SEGMENTS, ids=lambda kind: kind.__name__)
@UNHURRIED
@given(data=st.data())
def test_block_segment_survives_its_encoding(kind: type[Message], data: st.DataObject) -> None:
    message = data.draw(SEGMENTS[kind])
    assert decode_segment(message.encode()) == message


def test_no_message_was_forgotten() -> None:
    assert {*REQUESTS, BlockSegment, Unknown} == set(get_args(Request))
    assert {*RESPONSES, BlockSegment, Unknown} == set(get_args(Response))


@UNHURRIED
@given(FRAMES)
def test_any_request_frame_encodes_to_the_same_bytes(frame: bytes) -> None:
    assert decode_request(frame).encode() == frame


@UNHURRIED
@given(FRAMES)
def test_any_response_frame_encodes_to_the_same_bytes(frame: bytes) -> None:
    assert decode_response(frame).encode() == frame


@UNHURRIED
@given(FRAMES)
def test_any_segment_frame_encodes_to_the_same_bytes(frame: bytes) -> None:
    assert decode_segment(frame).encode() == frame


@UNHURRIED
@given(FRAMES | OTHER_LENGTHS)
def test_a_response_is_read_as_what_is_due_whatever_it_was_read_as(frame: bytes) -> None:
    for read in (decode_response(frame), decode_segment(frame)):
        assert as_answer(read) == decode_response(frame)
        assert as_segment(read, Multiplexer(0xFFFF)) == decode_segment(frame)


@pytest.mark.parametrize("byte", ["80", "81", "9F"])
def test_an_abort_of_the_object_that_is_uploaded_is_no_segment(byte: str) -> None:
    frame = bytes.fromhex(f"{byte} 10 20 00 01 00 04 05")
    for read in (decode_response(frame), decode_segment(frame)):
        assert as_segment(read, Multiplexer(0x2010)) == decode_response(frame)
    if byte != "80":
        assert isinstance(as_segment(decode_response(frame), Multiplexer(0x2011)), BlockSegment)


@UNHURRIED
@given(OTHER_LENGTHS)
def test_other_lengths_are_kept_as_unknown(frame: bytes) -> None:
    for decode in (decode_request, decode_response, decode_segment):
        message = decode(frame)
        assert isinstance(message, Unknown)
        assert message.encode() == frame


@pytest.mark.parametrize("command", range(0xE0, 0x100))
def test_command_specifier_7_is_unknown_in_both_directions(command: int) -> None:
    frame = bytes([command, 0, 0x10, 0, 0, 0, 0, 0])
    assert decode_request(frame) == Unknown(frame)
    assert decode_response(frame) == Unknown(frame)


def test_among_segments_only_80h_is_an_abort() -> None:
    kinds = {command: type(decode_segment(bytes([command, *range(7)]))) for command in range(256)}
    assert kinds.pop(0x80) is Abort
    assert set(kinds.values()) == {BlockSegment}


@pytest.mark.parametrize(
    "message",
    [
        DownloadInitiate(MUX, unused=4),
        DownloadInitiate(MUX, payload=bytes(5)),
        DownloadInitiate(Multiplexer(0x10000)),
        DownloadInitiate(Multiplexer(0x2000, 256)),
        DownloadInitiate(Multiplexer(-1)),
        DownloadSegment(bytes(6)),
        DownloadSegment(bytes(7), toggle=2),
        DownloadSegment(bytes(7), unused=8),
        UploadInitiate(MUX, reserved_bits=32),
        BlockSegment(128, bytes(7)),
        BlockAck(256, 1),
        BlockDownloadInitiateResponse(MUX, block_size=256),
        Abort(MUX, 1 << 32),
    ],
    ids=lambda message: type(message).__name__,
)
def test_a_field_that_does_not_fit_is_an_error(message: Message) -> None:
    with pytest.raises(ValueError, match=r"fit|takes"):
        message.encode()


@pytest.mark.parametrize("data", [b"", b"12345"])
def test_expedited_data_have_1_to_4_bytes(data: bytes) -> None:
    with pytest.raises(ValueError, match="unused"):
        DownloadInitiate.with_data(MUX, data).encode()


def test_a_segment_has_at_most_7_bytes() -> None:
    with pytest.raises(ValueError, match="unused"):
        DownloadSegment.with_data(b"12345678", toggle=0).encode()
