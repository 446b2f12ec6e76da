"""Block downloads where CiA 301 leaves a choice: any choice passes, a wrong result does not."""

from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.safety import written_by
from conformance.dialogue.block_downloads import (
    Gap,
    begin_block_download,
    lose_segment,
    send_again,
    unused_in,
)
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.run.case import may, must
from conformance.run.new_transfers import INITIATE_SIZE, INITIATES, Initiate
from conformance.run.risks import LOST_SEGMENT
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.decoding import decode_request
from conformance.sdo.describe import in_words
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockSegment,
)
from conformance.sdo.rules.block_download import END_RESERVED_BIT, TOO_FEW
from conformance.sdo.rules.download_initiates import HUGE_SIZE
from conformance.sdo.seen import Received
from conformance.sdo.unsent import Unsent

INITIATE = "7.2.4.3.9"
SUB_BLOCK = "7.2.4.3.10"
CRC = "7.2.4.3.16"
SERVICE = "7.2.4.2.10"


def expect_end_or_abort(sdo: Dialogue, known: KnownObject, due: bytes, *codes: AbortCode) -> None:
    """Expect the end of a block download confirmed and ``due`` stored, or an abort."""
    answer = sdo.receive()
    if isinstance(answer, Abort):
        sdo.take_abort(answer, codes, known)
        return
    sdo.checks.block_end_response(answer, known.mux)
    sdo.expect_value(known, due)


@may("block-download.largest-size", "download.huge-size", clause=INITIATE)
def test_largest_size(sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject) -> None:
    """A size of FFFFFFFFh is refused, or taken for what is announced; the server stays usable."""
    blocks.require_download()
    sdo.send(BlockDownloadInitiate.with_size(variable.mux, 0xFFFF_FFFF))
    answer = sdo.receive()
    if isinstance(answer, Abort):
        sdo.take_abort(answer, HUGE_SIZE.codes, variable)
    else:
        sdo.checks.block_download_initiate(answer, variable.mux)
        sdo.end_transfer()
        sdo.info("a block download of FFFFFFFFh bytes is not refused at its initiate")
    data = sdo.payload(room.fit(variable, 9))
    blocks.download(variable, data)
    sdo.expect_value(variable, data)


@may(
    "block-download.old-numbers", "block-download.old-numbering", clause=SERVICE, risk=LOST_SEGMENT
)
def test_old_numbers(sdo: Dialogue, blocks: Blocks, variable: KnownObject) -> None:
    """What comes again under its old numbers is discarded or refused, or stored as what it is."""
    gap = lose_segment(sdo, variable, 28, 2)
    if gap is None:
        return
    number = gap.unsent.total
    if gap.unsent.block_size < number or not gap.unsent.position:
        sdo.info("the next sub-block has no such numbers")
        return
    blocks.send_segments(gap.left, first=gap.unsent.position + 1, last=True)
    answer = sdo.wait(sdo.channel.response_timeout)
    if answer is None:
        sdo.info("old numbers are ignored")
        return
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, variable.mux)
        sdo.expect_refusals()
        return
    ack = sdo.checks.block_ack(answer, variable.mux, number)
    if 0 < ack.sequence < number:
        sdo.info(f"old numbers are acknowledged up to {ack.sequence}")
        return
    if ack.sequence == 0:
        gap.unsent.block_size = ack.block_size
        send_again(sdo, variable, gap)
    else:
        blocks.end_download(variable, unused=gap.unsent.unused, crc=gap.crc)
    sdo.expect_value(variable, gap.data)


@may("block-download.beyond-block-size", risk=LOST_SEGMENT)
def test_beyond_block_size(sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject) -> None:
    """A number beyond the block size is none: the segment is refused or dropped, never stored."""
    size = len(room.prepare(text, 14))
    response = blocks.initiate_download(text, size)
    sdo.end_transfer()
    if response.block_size == 127:
        sdo.info("the server takes 127 segments at once: no number lies beyond")
        return
    data = sdo.payload(room.fit(text, 7 * min(response.block_size, 2)))
    response = blocks.initiate_download(text, len(data))
    if response.block_size == 127:
        sdo.info("the server takes 127 segments at once: no number lies beyond")
        return
    unsent = Unsent(data, response.block_size)
    sub_block = unsent.sub_block()
    beyond = response.block_size + 1
    sdo.send(BlockSegment(beyond, sdo.payload(7 * beyond)[-7:]))
    blocks.send_sub_block(sub_block)
    answer = sdo.receive()
    refused = isinstance(answer, Abort)
    if refused:
        sdo.checks.abort(answer, text.mux)
    ack = None if refused else sdo.checks.block_ack(answer, text.mux, len(sub_block))
    if ack is None or ack.sequence < len(sub_block):
        # The segments behind it are discarded, start a new sub-block, or meet an idle server.
        sdo.end_transfer()
        for answer in sdo.fence():
            if not isinstance(answer, Abort | BlockAck):
                raise sdo.breach("an acknowledgement or an abort", Received(answer))
        return
    unsent.acknowledged(ack, sub_block)
    send_again(sdo, text, Gap(unsent, crc16(data) if response.crc_supported else 0))
    sdo.expect_value(text, data)


@may("block-download.crc-not-offered", "block-download.crc-unused", field=[0x0001, 0xFFFF])
def test_crc_not_offered(
    sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject, field: int
) -> None:
    """A server that has no CRC does not look at its field: nothing is refused for it."""
    size = len(room.prepare(text, 14))
    if blocks.offers_crc(text, size):
        sdo.info("the server computes a CRC")
        return
    data = begin_block_download(sdo, text, None, size)
    sdo.send(BlockEnd(unused_in(data), field))
    answer = sdo.receive()
    if isinstance(answer, Abort) and answer.code == AbortCode.CRC_ERROR:
        raise sdo.breach("no look at the CRC", Received(answer))
    if not isinstance(answer, Abort):
        sdo.checks.block_end_response(answer, text.mux)
        sdo.expect_value(text, data)


@must("block-download.crc-and-size-wrong", "block-download.two-errors")
def test_crc_and_size_wrong(sdo: Dialogue, room: Room, text: KnownObject) -> None:
    """An end frame with a wrong CRC and a wrong n is refused for either, and nothing is stored."""
    size = len(room.prepare(text, 14))
    with sdo.unchanged(text):
        data = begin_block_download(sdo, text, None, size)
        right = unused_in(data)
        wrong = min(right + 3, 7)
        sdo.send(BlockEnd(wrong, crc16(data[: size + right - wrong]) ^ 0x0101))
        sdo.expect_abort(*TOO_FEW.codes, of=text, tolerated=TOO_FEW.tolerated)


@may(
    "block-download.last-segment-repeated",
    "block-download.last-again",
    clause=SUB_BLOCK,
    risk=LOST_SEGMENT,
)
def test_last_segment_repeated(
    sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject
) -> None:
    """A last segment that comes again, as after a lost acknowledgement, is not stored twice.

    The server acknowledges it again, ignores it, or ends the transfer.
    """
    size = len(room.prepare(text, 14))
    before = sdo.upload(text)
    data = sdo.payload(size)
    response = blocks.initiate_download(text, size)
    unsent = Unsent(data, response.block_size)
    sub_block = unsent.sub_block()
    while not unsent.is_over:
        sub_block = unsent.sub_block()
        blocks.send_sub_block(sub_block)
        unsent.acknowledged(blocks.acknowledged(text, len(sub_block)), sub_block)
    again = sub_block[-1]
    target = written_by(decode_request(again.encode()))
    if target is not None and not sdo.device.policy.permits(target):
        sdo.end_transfer()
        raise NotTestable(f"taken for a request, the last segment would write to {target}")
    sdo.send(again)
    # It may be answered, and need not: the end is sent when that is over.
    answer = sdo.wait(sdo.channel.pace.soon(sdo.channel.response_timeout))
    if isinstance(answer, BlockAck) and answer.sequence == again.sequence:
        sdo.info("a repeated last segment is acknowledged again")
        answer = None
    end = BlockEnd(unused_in(data), crc16(data) if response.crc_supported else 0)
    ended = isinstance(answer, Abort)
    if answer is None:
        sdo.send(end)
        answer = sdo.receive()
    if not isinstance(answer, Abort):
        sdo.checks.block_end_response(answer, text.mux)
        sdo.expect_value(text, data)
        return
    sdo.checks.abort(answer, None)
    sdo.info("a repeated last segment ends the transfer")
    if ended:
        sdo.expect_dead(end)
    sdo.expect_kept(text, before)


@may("block-download.end-reserved-bit", "request.reserved-bits")
def test_end_reserved_bit(sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject) -> None:
    """The reserved bit of the end frame (C3h) is ignored, or the frame is refused."""
    size = len(room.prepare(text, 14))
    has_crc = blocks.offers_crc(text, size)
    data = begin_block_download(sdo, text, None, size)
    sdo.send(BlockEnd(unused_in(data), crc16(data) if has_crc else 0, reserved_bits=1))
    expect_end_or_abort(sdo, text, data, *END_RESERVED_BIT.codes)


@must(
    "block-download.new-initiate-at-end",
    "block-download.foreign-at-end",
    "server.new-initiate-served",
    initiate=INITIATES,
)
def test_new_initiate_at_end(
    sdo: Dialogue, room: Room, text: KnownObject, initiate: Initiate
) -> None:
    """An initiate where the end is due is served, or ends the download; nothing of it is stored."""
    room.fit(text, INITIATE_SIZE)
    size = len(room.prepare(text, 14))
    before = sdo.upload(text)
    data = begin_block_download(sdo, text, None, size)
    refused = initiate(sdo, text)
    if refused is not None:
        sdo.info(f"refused: {in_words(refused)}")
        sdo.expect_kept(text, before)
    with sdo.one_transfer():
        sdo.expect_dead(BlockEnd(unused_in(data), crc16(data)))
