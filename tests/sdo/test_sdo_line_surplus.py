"""Segments beyond a sub-block are told apart from answers, and from a server that counts on."""

from conformance.sdo.decoding import decode_segment
from conformance.sdo.frames import BlockAck, BlockEnd, BlockUploadInitiate, BlockUploadStart
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import LARGEST_BLOCK
from conformance.sdo.line import Line

TEXT = Multiplexer(0x2010)


def segments(*numbers: int) -> list[bytes]:
    """Build segments with these first bytes."""
    return [bytes([number]) + bytes(7) for number in numbers]


def begun(size: int) -> Line:
    """Start a block upload in sub-blocks of ``size`` segments."""
    line = Line()
    line.request(BlockUploadInitiate(TEXT, size).encode())
    found(line, [bytes.fromhex("C6 10 20 00 14 00 00 00")])
    line.request(BlockUploadStart().encode())
    return line


def found(line: Line, frames: list[bytes], *, expected: bool = False) -> list[bool]:
    """Say of each frame whether it is a segment too many; the others are taken as responses."""
    surplus = []
    for frame in frames:
        surplus.append(line.surplus(frame, expected=expected) is not None)
        if not surplus[-1]:
            line.response(frame)
    return surplus


def test_a_whole_sub_block_is_none_too_many() -> None:
    assert found(begun(3), segments(1, 2, 3)) == [False] * 3


def test_the_short_way_takes_the_segment_that_is_due_unless_it_is_marked() -> None:
    line = begun(3)
    assert not line.take_due(b"")
    assert not line.take_due(segments(1)[0][:7])
    assert [line.take_due(frame) for frame in segments(1, 3, 2, 0x83, 3)] == [
        *(True, False, True),
        *(False, True),
    ]
    assert not line.take_due(segments(4)[0])  # behind the sub-block
    assert found(line, segments(4)) == [True]
    assert not Line().take_due(segments(1)[0])


def test_the_short_way_leads_to_the_same_state() -> None:
    short, long = begun(3), begun(3)
    for line in (short, long):
        line.response(segments(1)[0])
    for frame in segments(2, 3):
        assert short.take_due(frame)
        assert long.surplus(frame, expected=False) is None
        long.response(frame)
    assert (short.answered, long.answered) == (
        decode_segment(segments(1)[0]),
        decode_segment(segments(3)[0]),
    )
    short.answered = long.answered
    assert vars(short) | {"_reader": None} == vars(long) | {"_reader": None}
    assert vars(short._reader) == vars(long._reader)


def test_segments_behind_a_sub_block_are_too_many() -> None:
    assert found(begun(2), segments(1, 2, 3, 0x84)) == [False, False, True, True]


def test_nothing_follows_the_last_segment() -> None:
    assert found(begun(3), segments(0x81, 2, 0x83)) == [False, True, True]


def test_the_end_follows_the_acknowledgement_of_the_last_segment_and_is_none() -> None:
    line = begun(LARGEST_BLOCK)
    sub_block = segments(*range(1, 64), 0xC0)
    assert not any(found(line, sub_block))
    line.request(BlockAck(64, LARGEST_BLOCK).encode())
    assert found(line, [BlockEnd(0, 0).encode()]) == [False]  # C1h: segment 65, marked


def test_what_answers_another_request_is_no_segment_unless_those_are_known_to_come() -> None:
    for expected in (False, True):
        line = begun(3)
        found(line, segments(0x81))
        line.request(bytes.fromhex("40 00 10 00 00 00 00 00"))
        answers = [*segments(2), bytes.fromhex("80 00 10 00 00 00 04 05")]
        assert found(line, answers, expected=expected) == [False, False]
        assert found(line, segments(0x82), expected=expected) == [expected]


def test_a_server_that_counts_on_sends_none_too_many() -> None:
    line = begun(2)
    found(line, segments(1, 2))
    line.request(BlockAck(2, 2).encode())
    assert found(line, segments(3)) == [False]


def test_where_they_are_known_to_come_they_may_cross_with_the_acknowledgement() -> None:
    line = begun(2)
    found(line, segments(1, 2))
    line.request(BlockAck(2, 2).encode())
    assert found(line, segments(3, 1, 2), expected=True) == [True, False, False]


def test_another_answer_ends_the_sub_block() -> None:
    line = begun(2)
    found(line, segments(1, 2))
    line.request(bytes.fromhex("40 00 10 00 00 00 00 00"))
    answers = [bytes.fromhex("41 10 20 00 14 00 00 00"), *segments(3)]
    assert found(line, answers) == [False, False]


def test_a_download_has_no_sub_blocks_of_the_server() -> None:
    line = Line()
    line.request(bytes.fromhex("A2 01 01 00 00 00 00 00"))
    assert found(line, segments(1, 2, 3)) == [False] * 3
