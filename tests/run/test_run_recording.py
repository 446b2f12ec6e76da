"""A case of any length: its frames are kept in bounded memory, and what is kept is read rightly."""

import tracemalloc
from collections.abc import Iterator

import pytest

from conformance.bus.link import Captured, Direction
from conformance.run.evidence import cansend_lines
from conformance.run.recording import FIRST_KEPT, LAST_KEPT, Recording
from conformance.run.trace import FIRST_LINES, LAST_LINES, trace_of
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.frames import (
    BlockAck,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
)
from conformance.sdo.layout import Message, Multiplexer

IDS = ChannelIds.default(5)
REQUEST, RESPONSE = IDS.request.can_id, IDS.response.can_id
MOST = FIRST_KEPT + LAST_KEPT
MUX = Multiplexer(0x2011)


def captured(message: Message, number: int) -> Captured:
    """Return a message as it was seen on the bus."""
    sent = isinstance(message, BlockUploadInitiate | BlockUploadStart | BlockAck)
    direction = Direction.SENT if sent else Direction.RECEIVED
    return Captured(
        number / 1000, direction, CanFrame(REQUEST if sent else RESPONSE, message.encode())
    )


def block_upload(frames: int) -> Iterator[Captured]:
    """Yield ``frames`` frames of a block upload that does not end."""
    begin: list[Message] = [
        BlockUploadInitiate(MUX, 127),
        BlockUploadInitiateResponse.with_size(MUX, None),
        BlockUploadStart(),
    ]
    for number in range(frames):
        place = (number - len(begin)) % 128
        message = BlockAck(127, 127) if place == 127 else BlockSegment(place + 1, b"segment")
        yield captured(begin[number] if number < len(begin) else message, number)


def recorded(frames: int) -> Recording:
    """Return the recording of ``frames`` frames."""
    recording = Recording(IDS)
    for frame in block_upload(frames):
        recording.add(frame)
    return recording


@pytest.mark.parametrize("frames", [0, 1, FIRST_KEPT, FIRST_KEPT + 1, MOST])
def test_what_fits_is_kept_whole(frames: int) -> None:
    recording = recorded(frames)
    assert recording.kept() == list(block_upload(frames))
    assert recording.gap() is None
    assert len(recording) == frames


def test_of_more_the_first_and_the_last_are_kept() -> None:
    recording, frames = recorded(MOST + 500), list(block_upload(MOST + 500))
    assert recording.kept() == frames[:FIRST_KEPT] + frames[-LAST_KEPT:]
    assert len(recording) == MOST + 500
    gap = recording.gap()
    assert gap is not None
    assert (gap.at, gap.frames) == (FIRST_KEPT, 500)
    left_out = frames[FIRST_KEPT:-LAST_KEPT]
    assert gap.sent == sum(frame.direction is Direction.SENT for frame in left_out)


def test_a_new_case_begins_empty() -> None:
    recording = recorded(MOST + 500)
    recording.clear()
    assert (recording.kept(), recording.gap(), len(recording)) == ([], None, 0)


def test_a_trace_with_a_gap_reads_like_one_without() -> None:
    recording, frames = recorded(MOST + 500), list(block_upload(MOST + 500))
    for own in (None, 20, FIRST_KEPT + 100, MOST + 480):
        shown = trace_of(recording.kept(), [IDS], own=own, gap=recording.gap())
        whole = trace_of(frames, [IDS], own=own)
        assert shown == whole
    assert f"{MOST + 500 - FIRST_LINES - LAST_LINES} frames left out" in "\n".join(
        line.words for line in shown.lines
    )


def test_commands_with_a_gap_are_counted_like_those_without() -> None:
    recording, frames = recorded(30_000), list(block_upload(30_000))
    shown = cansend_lines(recording.kept(), "can0", gap=recording.gap())
    whole = cansend_lines(frames, "can0")
    assert shown[-LAST_LINES:] == whole[-LAST_LINES:]
    assert [line for line in shown if line.startswith("#")] == [
        line for line in whole if line.startswith("#")
    ]


def test_memory_stays_flat() -> None:
    recording = recorded(MOST)
    tracemalloc.start()
    try:
        for frame in block_upload(2 * LAST_KEPT):
            recording.add(frame)
        before, _ = tracemalloc.get_traced_memory()
        for frame in block_upload(20_000):
            recording.add(frame)
        after, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert after - before < 100_000
    assert peak - before < 200_000
