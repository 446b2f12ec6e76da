"""Block downloads that a server has to take (CiA 301, 7.2.4.3.9 to 7.2.4.3.11)."""

from conformance.device.device import TWO_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.block_downloads import (
    Gap,
    lose_one,
    lose_segment,
    send_again,
    send_blocks,
    unused_in,
)
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.values import same_value, segments_of
from conformance.model_cases.variations import BEYOND_16_BITS, BLOCK_SIZES, EDGE_SIZES
from conformance.run.case import may, must, should
from conformance.run.risks import LOST_SEGMENT
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.describe import shown
from conformance.sdo.frames import (
    Abort,
    BlockEnd,
    BlockSegment,
)
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.rules import RESERVED
from conformance.sdo.seen import Data, Received, said
from conformance.sdo.unsent import Unsent

INITIATE = "7.2.4.3.9"
CRC = "7.2.4.3.16"
SERVICE = "7.2.4.2.10"
# A whole sub-block of any size, and a segment more.
LONG_BURST = 7 * 128
# Three segments.
LENGTH_OF_GAP = 20


@must(
    "block-download.size",
    "block-download.full-sub-block",
    "block-download.last-segment",
    "block-download.segments-only",
    "block-download.stored",
    "block.full-last-segment",
    size=BLOCK_SIZES,
)
def test_size(sdo: Dialogue, room: Room, blocks: Blocks, roles: Roles, size: int) -> None:
    """A block download is stored whole; segments that look like other requests are segments."""
    variable, data = roles.variable(size), sdo.payload(size)
    with room.for_length(variable, size):
        blocks.download(variable, data)
    blocks.expect_value(variable, data)


@must(
    "block-download.beyond-16-bits",
    "block-download.last-segment",
    "block-download.stored",
    size=[BEYOND_16_BITS],
)
def test_beyond_16_bits(sdo: Dialogue, room: Room, blocks: Blocks, roles: Roles, size: int) -> None:
    """More bytes than 16 bits count are stored whole and read whole, where there is room."""
    blocks.require_download()
    variable, data = roles.variable(size), sdo.payload(size)
    room.check_length(variable, size)
    abort = blocks.try_download(variable, data)
    if abort is not None:
        raise room.refused(variable, size, abort)
    found = blocks.upload(variable).data
    if not same_value(variable, found, data):
        raise sdo.breach(f"{variable} reads {shown(data)}", Data(found, variable))


@should("block-download.whole-sub-block")
def test_whole_sub_block(sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject) -> None:
    """A sub-block as long as the server has asked for is taken whole, sent without a pause."""
    blocks.require_download()
    data = sdo.payload(room.fit(variable, LONG_BURST))
    repeated = sdo.run(sdo.client.block_download(variable.mux, data))
    if repeated:
        raise sdo.breach("no segment to be sent again", said("{} had to be sent again", repeated))


@must("block-download.size-not-indicated", size=[*EDGE_SIZES, 890])
def test_size_not_indicated(
    sdo: Dialogue, room: Room, blocks: Blocks, roles: Roles, size: int
) -> None:
    """A block download that does not say its size (C4h) is stored whole."""
    variable, data = roles.variable(size), sdo.payload(size)
    with room.for_length(variable, size):
        blocks.download(variable, data, sized=False)
    blocks.expect_value(variable, data)


@must("block-download.without-crc", "crc.offered-unasked", size=[1, 7, 20, 256])
def test_without_crc(sdo: Dialogue, room: Room, blocks: Blocks, roles: Roles, size: int) -> None:
    """A client that has no CRC is served; the CRC field is 0 then."""
    variable, data = roles.variable(size), sdo.payload(size)
    with room.for_length(variable, size):
        blocks.download(variable, data, crc=False)
    blocks.expect_value(variable, data)


@must(
    "block-download.number",
    "block-download.last-segment",
    "block-download.stored",
    "data.type-length",
    length=[1, 2, 4, 5, 6, 7, 8],
)
def test_number(sdo: Dialogue, blocks: Blocks, roles: Roles, length: int) -> None:
    """A number may come in a block, however short it is."""
    known = roles.number(length)
    before = sdo.upload(known)
    wanted = sdo.write_number(known)
    sdo.download(known, before)
    blocks.download(known, wanted)
    sdo.expect_value(known, wanted)


@must("block-download.write-only", "response.not-refused", clause=INITIATE)
def test_write_only(blocks: Blocks, write_only: KnownObject) -> None:
    """A write-only object takes a value in a block."""
    blocks.download(write_only, bytes(write_only.length or 4))


@must("block-download.again", "server.idle-afterwards", "block-download.stored", clause=SERVICE)
def test_again(sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject) -> None:
    """One block download after another: the object holds the last and nothing else."""
    for wanted in (50, 7, 30, 3):
        data = sdo.payload(len(room.prepare(variable, wanted)))
        blocks.download(variable, data)
        sdo.expect_value(variable, data)


@must("block-download.reserved", "response.reserved", clause=INITIATE)
def test_reserved(sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject) -> None:
    """Reserved bits and bytes of A4h, A2h and A1h are 0."""
    size = len(room.prepare(variable, 20))
    blocks.download(variable, sdo.payload(size))
    sdo.expect_clean(RESERVED)


@must(
    "block-download.lost",
    "block.progress",
    "block-download.gap",
    "block-download.first-lost",
    "crc.covers",
    "block.acknowledgement",
    "block-download.break-moment",
    risk=LOST_SEGMENT,
    lost={"first": (2, 0), "middle": (3, 1), "before-last": (5, 3)},
)
def test_lost(sdo: Dialogue, variable: KnownObject, lost: tuple[int, int]) -> None:
    """A gap before the last segment is acknowledged as such, and what is sent again is taken.

    The data and the CRC are right in the end, each byte counted once.
    """
    number, position = lost
    gap = lose_segment(sdo, variable, 7 * number - 2, position)
    if gap is None:
        return
    send_again(sdo, variable, gap)
    sdo.expect_value(variable, gap.data)


@must(
    "block-download.lost-twice",
    "block.progress",
    "block-download.gap",
    "block-download.first-lost",
    "block.acknowledgement",
    risk=LOST_SEGMENT,
)
def test_lost_twice(sdo: Dialogue, variable: KnownObject) -> None:
    """What is sent again may get lost again."""
    gap = lose_segment(sdo, variable, 28, 2)
    if gap is None:
        return
    if gap.unsent.block_size >= 2 and not lose_one(sdo, variable, gap.unsent, 0):
        return
    send_again(sdo, variable, gap)
    sdo.expect_value(variable, gap.data)


@must(
    "block-download.lost-later",
    "block.progress",
    "block-download.gap",
    "block-download.first-lost",
    "block.acknowledgement",
    risk=LOST_SEGMENT,
    sub_block={"second": 2, "third": 3},
)
def test_lost_later(
    sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject, sub_block: int
) -> None:
    """A gap in a later sub-block is acknowledged as such, and what is sent again is taken."""
    before = SEGMENT_LENGTH * LARGEST_BLOCK * (sub_block - 1)
    data = sdo.payload(room.fit(variable, before + LENGTH_OF_GAP, least=TWO_SEGMENTS))
    response = blocks.initiate_download(variable, len(data))
    unsent = Unsent(data, response.block_size)
    for _ in range(sub_block - 1):
        whole = unsent.sub_block()
        if len(whole) < response.block_size:
            break
        blocks.send_sub_block(whole)
        unsent.acknowledged(blocks.acknowledged(variable, len(whole)), whole)
    if len(unsent.sub_block()) < 2:
        sdo.end_transfer()
        raise NotTestable(f"{variable} has room for too few sub-blocks: name another object")
    if not lose_one(sdo, variable, unsent, 0):
        return
    send_again(sdo, variable, Gap(unsent, crc16(data) if response.crc_supported else 0))
    blocks.expect_value(variable, data)


@may("block-download.repeated-segment", risk=LOST_SEGMENT)
def test_repeated_segment(sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject) -> None:
    """A segment that comes twice is ignored or taken for a gap; it is not stored twice."""
    data = sdo.payload(len(room.prepare(variable, 21, least=TWO_SEGMENTS)))
    chunks = segments_of(data)
    response = blocks.initiate_download(variable, len(data))
    if response.block_size < len(chunks):
        sdo.info(f"the server takes {response.block_size} segments at once: none can come twice")
        return
    twice = len(chunks) - 1
    blocks.send_segments(chunks[:twice])
    blocks.send_segments(chunks[twice - 1 : twice], first=twice)
    blocks.send_segments(chunks[twice:], first=twice + 1, last=True)
    answer = sdo.receive()
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, variable.mux)
        # The segments behind the repeated one meet an idle server, which may refuse each.
        for answer in sdo.fence():
            sdo.checks.abort(answer, None)
        sdo.info("a repeated segment is refused")
        return
    ack = sdo.checks.block_ack(answer, variable.mux, len(chunks))
    if ack.sequence < len(chunks):
        sdo.info(f"a repeated segment counts as a gap behind segment {ack.sequence}")
        return
    crc = crc16(data) if response.crc_supported else 0
    blocks.end_download(variable, unused=unused_in(data), crc=crc)
    sdo.expect_value(variable, data)


@may("block-download.sequence-zero", risk=LOST_SEGMENT)
def test_sequence_zero(sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject) -> None:
    """Sequence number 0 is none: the segment is refused or dropped, never stored."""
    data = sdo.payload(len(room.prepare(text, 14)))
    chunks = segments_of(data)
    response = blocks.initiate_download(text, len(data))
    sdo.send(BlockSegment(0, b"#######"))
    if response.block_size < len(chunks):
        sdo.expect_silence_or_abort()
        return
    blocks.send_segments(chunks, last=True)
    answer = sdo.receive()
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, text.mux)
        sdo.expect_refusals()
        return
    if sdo.checks.block_ack(answer, text.mux, len(chunks)).sequence == len(chunks):
        crc = crc16(data) if response.crc_supported else 0
        blocks.end_download(text, unused=unused_in(data), crc=crc)
        sdo.expect_value(text, data)


@may("block-download.crc-unused")
def test_crc_unused(sdo: Dialogue, room: Room, variable: KnownObject) -> None:
    """Without a CRC its field is not looked at: nothing is refused for it."""
    data = sdo.payload(len(room.prepare(variable, 14)))
    send_blocks(sdo, variable, data, None, crc=False)
    sdo.send(BlockEnd(unused_in(data), 0x1234))
    answer = sdo.receive()
    if isinstance(answer, Abort) and answer.code == AbortCode.CRC_ERROR:
        raise sdo.breach("no look at the CRC", Received(answer))
    if not isinstance(answer, Abort):
        sdo.checks.block_end_response(answer, variable.mux)
        sdo.expect_value(variable, data)


@may("block-download.empty", "data.empty", "crc.empty")
def test_empty(sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject) -> None:
    """A block download of no bytes stores an empty value or is refused; it never hangs."""
    blocks.initiate_download(text, len(room.prepare(text, 9)))
    sdo.end_transfer()
    abort = blocks.try_download(text, b"")
    if abort is None:
        sdo.info(f"{text} becomes empty")
        room.restore_own(text)  # what is empty may be refused to the next case
