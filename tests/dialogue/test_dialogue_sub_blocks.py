"""Segments beyond a sub-block are told apart from answers, and from a server that counts on."""

from conformance.dialogue.sub_blocks import SubBlocks
from conformance.sdo.frames import BlockAck, BlockEnd, BlockUploadInitiate, BlockUploadStart
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import LARGEST_BLOCK

TEXT = Multiplexer(0x2010)


def segments(*numbers: int) -> list[bytes]:
    """Build segments with these first bytes."""
    return [bytes([number]) + bytes(7) for number in numbers]


def begun(size: int) -> SubBlocks:
    """Start a block upload in sub-blocks of ``size`` segments."""
    watched = SubBlocks()
    watched.request(BlockUploadInitiate(TEXT, size).encode())
    watched.surplus(bytes.fromhex("C6 10 20 00 14 00 00 00"), expected=False)
    watched.request(BlockUploadStart().encode())
    return watched


def found(watched: SubBlocks, frames: list[bytes], *, expected: bool = False) -> list[bool]:
    """Say of each frame whether it is a segment too many."""
    return [watched.surplus(frame, expected=expected) is not None for frame in frames]


def test_a_whole_sub_block_is_none_too_many() -> None:
    assert found(begun(3), segments(1, 2, 3)) == [False] * 3


def test_only_the_segment_that_is_due_is_taken_for_certain() -> None:
    watched = begun(3)
    assert [watched.takes(frame) for frame in segments(1, 3, 2, 0xA2, 3)] == [
        *(True, False, True),
        *(False, True),
    ]
    assert watched.takes(segments(9)[0]) is False  # behind the sub-block
    assert SubBlocks().takes(segments(9)[0])


def test_segments_behind_a_sub_block_are_too_many() -> None:
    assert found(begun(2), segments(1, 2, 3, 0x84)) == [False, False, True, True]


def test_nothing_follows_the_last_segment() -> None:
    assert found(begun(3), segments(0x81, 2, 0x83)) == [False, True, True]


def test_the_end_follows_the_acknowledgement_of_the_last_segment_and_is_none() -> None:
    watched = begun(LARGEST_BLOCK)
    sub_block = segments(*range(1, 64), 0xC0)
    assert not any(found(watched, sub_block))
    watched.request(BlockAck(64, LARGEST_BLOCK).encode())
    assert found(watched, [BlockEnd(0, 0).encode()]) == [False]  # C1h: segment 65, marked


def test_what_answers_another_request_is_no_segment_unless_those_are_known_to_come() -> None:
    for expected in (False, True):
        watched = begun(3)
        found(watched, segments(0x81))
        watched.request(bytes.fromhex("40 00 10 00 00 00 00 00"))
        answers = [*segments(2), bytes.fromhex("80 00 10 00 00 00 04 05")]
        assert found(watched, answers, expected=expected) == [False, False]
        assert found(watched, segments(0x82), expected=expected) == [expected]


def test_a_server_that_counts_on_sends_none_too_many() -> None:
    watched = begun(2)
    found(watched, segments(1, 2))
    watched.request(BlockAck(2, 2).encode())
    assert found(watched, segments(3)) == [False]


def test_where_they_are_known_to_come_they_may_cross_with_the_acknowledgement() -> None:
    watched = begun(2)
    found(watched, segments(1, 2))
    watched.request(BlockAck(2, 2).encode())
    assert found(watched, segments(3, 1, 2), expected=True) == [True, False, False]


def test_another_answer_ends_the_sub_block() -> None:
    watched = begun(2)
    found(watched, segments(1, 2))
    watched.request(bytes.fromhex("40 00 10 00 00 00 00 00"))
    answers = [bytes.fromhex("41 10 20 00 14 00 00 00"), *segments(3)]
    assert found(watched, answers) == [False, False]


def test_a_download_has_no_sub_blocks_of_the_server() -> None:
    watched = SubBlocks()
    watched.request(bytes.fromhex("A2 01 01 00 00 00 00 00"))
    assert found(watched, segments(1, 2, 3)) == [False] * 3
