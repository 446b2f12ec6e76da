"""Block downloads where CiA 301 leaves a choice: any choice passes, a wrong result does not."""

from dataclasses import replace

from conformance.device.known_objects import KnownObject
from conformance.device.lacking import NotTestable
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
from conformance.dialogue.room import Room
from conformance.dialogue.values import segments_of
from conformance.run.case import may, must
from conformance.run.initiates import INITIATE_SIZE, INITIATES, Initiate
from conformance.run.risks import LOST_SEGMENT
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.decoding import decode_request, decode_response
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
    number = gap.position + len(gap.segments)
    if gap.block_size < number:
        sdo.info("the next sub-block has no such numbers")
        return
    blocks.send_segments(gap.segments, first=gap.position + 1, last=True)
    answer = sdo.wait(sdo.channel.response_timeout)
    if answer is None:
        sdo.info("old numbers are ignored")
        return
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, variable.mux)
        sdo.expect_refusals()
        return
    ack = sdo.checks.block_ack(answer, variable.mux, number)
    if ack.sequence == 0:
        send_again(sdo, variable, replace(gap, block_size=ack.block_size))
    else:
        blocks.end_download(variable, unused=gap.unused, crc=gap.crc)
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
    chunks = segments_of(data)
    response = blocks.initiate_download(text, len(data))
    if response.block_size == 127:
        sdo.info("the server takes 127 segments at once: no number lies beyond")
        return
    count = min(response.block_size, len(chunks))
    beyond = response.block_size + 1
    sdo.send(BlockSegment(beyond, sdo.payload(7 * beyond)[-7:]))
    blocks.send_segments(chunks[:count], last=count == len(chunks))
    answer = sdo.receive()
    refused = isinstance(answer, Abort)
    if refused:
        sdo.checks.abort(answer, text.mux)
    ack = None if refused else sdo.checks.block_ack(answer, text.mux, count)
    if ack is None or ack.sequence < count:
        # The segments behind it are discarded, start a new sub-block, or meet an idle server.
        sdo.end_transfer()
        for answer in sdo.fence():
            if not isinstance(answer, Abort | BlockAck):
                raise sdo.breach("an acknowledgement or an abort", in_words(answer))
        return
    crc = crc16(data) if response.crc_supported else 0
    send_again(sdo, text, Gap(data, chunks[count:], count, ack.block_size, crc))
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
        raise sdo.breach("no look at the CRC", in_words(answer))
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
    left, number, block_size = segments_of(data), 0, response.block_size
    chunk = left[-1]
    while left:
        number = min(block_size, len(left))
        blocks.send_segments(left[:number], last=number == len(left))
        block_size, left = blocks.acknowledged(text, number).block_size, left[number:]
    again = BlockSegment.with_data(number, chunk, last=True)
    target = written_by(decode_request(again.encode()))
    if target is not None and not sdo.device.policy.permits(target):
        sdo.end_transfer()
        raise NotTestable(f"taken for a request, the last segment would write to {target}")
    sdo.send(again)
    waiting = sdo.channel.waiting()
    ended = bool(waiting) and isinstance(decode_response(waiting[0].data), Abort)
    # It may have ended the transfer before the end is sent, which is dead then all the same.
    answer = sdo.receive() if ended else None
    sdo.send(BlockEnd(unused_in(data), crc16(data) if response.crc_supported else 0))
    answer = answer or sdo.receive()
    if isinstance(answer, BlockAck) and answer.sequence == number:
        sdo.info("a repeated last segment is acknowledged again")
        answer = sdo.receive()
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, None)
        sdo.info("a repeated last segment ends the transfer")
        # The end frame behind it may be refused for itself.
        for further in sdo.fence():
            sdo.checks.abort(further, None)
        sdo.expect_kept(text, before)
        return
    sdo.checks.block_end_response(answer, text.mux)
    sdo.expect_value(text, data)


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
