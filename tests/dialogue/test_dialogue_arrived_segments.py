"""A block upload takes the segments that have arrived; what ends it early is taken by itself."""

import pytest
from support.run_bench import Scripted, undiscovered

from conformance.dialogue.blocks import Blocks
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    Abort,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiateResponse,
    Response,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import BLOCK_SEQUENCE, FRAME_SHAPE, NOT_REFUSED, Violation

TEXT = Multiplexer(0x2010)
DATA = bytes(range(35))
SUB_BLOCK = [
    BlockSegment(number, DATA[7 * number - 7 : 7 * number], last=number == 5)
    for number in range(1, 6)
]
ABORT = Abort(TEXT, AbortCode.GENERAL_ERROR)


def uploading(*sub_block: Response | CanFrame) -> Scripted:
    """Send all of a sub-block at once, whatever is in it, and the end behind it."""

    def answers(data: bytes) -> list[bytes | CanFrame]:
        due: dict[int, tuple[Response | CanFrame, ...]] = {
            0xA0: (BlockUploadInitiateResponse(TEXT, crc_supported=False),),
            0xA4: (BlockUploadInitiateResponse(TEXT, crc_supported=False),),
            0xA3: sub_block,
            0xA2: (BlockEnd(0),),
        }
        return [
            each if isinstance(each, CanFrame) else each.encode() for each in due.get(data[0], ())
        ]

    return Scripted(answers)


def test_all_segments_are_taken() -> None:
    with undiscovered(uploading(*SUB_BLOCK)) as bench:
        sdo = bench.dialogue()
        uploaded = Blocks(sdo).upload(TEXT)
        assert (uploaded.data, uploaded.segments) == (DATA, 5)
        assert sdo.line.open is None
        assert sdo.drain() == []


@pytest.mark.parametrize(
    ("sub_block", "rule"),
    [
        ((*SUB_BLOCK[:3], ABORT, *SUB_BLOCK[3:]), NOT_REFUSED),
        ((ABORT, *SUB_BLOCK), NOT_REFUSED),
        ((*SUB_BLOCK[:2], *SUB_BLOCK[3:]), BLOCK_SEQUENCE),
        ((*SUB_BLOCK[1:2], *SUB_BLOCK), BLOCK_SEQUENCE),
    ],
    ids=["aborted", "aborted-at-once", "one-missing", "another-first"],
)
def test_what_follows_the_end_of_a_sub_block_is_still_there(
    sub_block: tuple[Response, ...], rule: object
) -> None:
    """It is not taken for a part of it, and the case meets it as what it is."""
    ended = next(
        place
        for place, each in enumerate(sub_block, 1)
        if not isinstance(each, BlockSegment) or each.sequence != place
    )
    with undiscovered(uploading(*sub_block)) as bench:
        sdo = bench.dialogue()
        with pytest.raises(Violation) as raised:
            Blocks(sdo).upload(TEXT)
        assert raised.value.rule is rule
        left = [frame.data for frame in sdo.drain()]
    assert left == [each.encode() for each in sub_block[ended:]]


def test_a_segment_of_another_length_is_noted_as_such() -> None:
    short = CanFrame(0x585, SUB_BLOCK[2].encode()[:7])
    with undiscovered(uploading(*SUB_BLOCK[:2], short, *SUB_BLOCK[3:])) as bench:
        sdo = bench.dialogue()
        assert Blocks(sdo).upload(TEXT).segments == 5
    assert [found.rule for found in sdo.record.minor] == [FRAME_SHAPE]
