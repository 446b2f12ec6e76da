"""Block downloads step by step: begun and not ended, and with a segment that is lost."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from conformance.device.device import TWO_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.transfers import mux_of
from conformance.dialogue.values import segments_of
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockSegment,
)
from conformance.sdo.rules import BLOCK_ACK, Violation
from conformance.sdo.seen import NoAnswer
from conformance.sdo.unsent import Unsent

# A server's timer may be coarse: its time-out takes up to half as long again as it is declared.
PATIENCE = 1.5


class Upcoming(NamedTuple):
    """The request of a block download that is due next.

    ``position`` counts the segments before it, those that were sent again but once; ``sub_block``
    the sub-blocks that were acknowledged.
    """

    position: int
    sub_block: int
    request: BlockSegment | BlockEnd


def begin_block_download(
    sdo: Dialogue, known: KnownObject, segments: int | None, size: int
) -> bytes:
    """Start a block download of ``size`` bytes and send its first ``segments``; return its data.

    With all of them, None, the end is due.
    """
    data = sdo.payload(size)
    send_blocks(sdo, known, data, segments)
    return data


def send_blocks(
    sdo: Dialogue, known: KnownObject, data: bytes, segments: int | None, *, crc: bool = True
) -> BlockDownloadInitiateResponse:
    """Start a block download, send its first ``segments``, or all; return the first answer."""
    response = Blocks(sdo).initiate_download(known, len(data), crc=crc)
    count = len(segments_of(data)[:segments])
    requests = send_step_by_step(sdo, known, data, response)
    next(due for due in requests if due.position == count)
    return response


def send_step_by_step(
    sdo: Dialogue, known: KnownObject, data: bytes, response: BlockDownloadInitiateResponse
) -> Iterator[Upcoming]:
    """Send a block download that was initiated, each request as the next is asked for.

    Yields what is due: the segments, those that get lost again, then the end.
    """
    blocks = Blocks(sdo)
    unsent = Unsent(data, response.block_size)
    acknowledged = 0
    while not unsent.is_over:
        sub_block = unsent.sub_block()
        for position, segment in enumerate(sub_block, unsent.position):
            yield Upcoming(position, acknowledged, segment)
            blocks.send_sub_block([segment])
        unsent.acknowledged(blocks.acknowledged(known, len(sub_block)), sub_block)
        acknowledged += 1
    crc = crc16(data) if response.crc_supported else 0
    yield Upcoming(unsent.total, acknowledged, BlockEnd(unsent.unused, crc))
    blocks.end_download(known, unused=unsent.unused, crc=crc)


def unused_in(data: bytes) -> int:
    """Return n of the end frame: how many bytes of the last segment hold no data."""
    return 7 * len(segments_of(data)) - len(data)


@dataclass(frozen=True, slots=True)
class Gap:
    """A block download of which a segment was lost and the gap acknowledged: what is still to come.

    ``unsent`` are the segments from the lost one on, which are due again; ``crc`` is what the end
    frame has to say.
    """

    unsent: Unsent
    crc: int

    @property
    def data(self) -> bytes:
        """What is written."""
        return self.unsent.data

    @property
    def left(self) -> list[bytes]:
        """The data of the segments that are due again."""
        return segments_of(self.data)[self.unsent.position :]


def lose_segment(sdo: Dialogue, known: KnownObject, size: int, position: int) -> Gap | None:
    """Send a block download in one sub-block, all but the segment at a position, counted from 0.

    It is not the last: where the object takes fewer bytes than ``size``, an earlier one is lost.
    None where the server takes too few segments at once for a gap, keeps silent about it, or ends
    the transfer for it after a time.
    """
    blocks = Blocks(sdo)
    data = sdo.payload(len(Room(sdo).prepare(known, size, least=TWO_SEGMENTS)))
    response = blocks.initiate_download(known, len(data))
    unsent = Unsent(data, response.block_size)
    if response.block_size < unsent.total:
        sdo.info(f"the server takes {response.block_size} segments at once: no gap fits in")
        return None
    if not lose_one(sdo, known, unsent, min(position, unsent.total - 2)):
        return None
    return Gap(unsent, crc16(data) if response.crc_supported else 0)


def lose_one(sdo: Dialogue, known: KnownObject, unsent: Unsent, position: int) -> bool:
    """Send a sub-block, all but the segment at a position; say whether the gap is acknowledged."""
    sub_block = unsent.sub_block()
    Blocks(sdo).send_sub_block([*sub_block[:position], *sub_block[position + 1 :]])
    ack = gap_acknowledged(sdo, known, position)
    if ack is not None:
        unsent.acknowledged(ack, sub_block)
    return ack is not None


def gap_acknowledged(sdo: Dialogue, known: KnownObject, position: int) -> BlockAck | None:
    """Expect the acknowledgement of the segments before a gap, at most those up to ``position``.

    When it comes is the server's choice: at once, at the end of the sub-block, or with a time-out
    of its own, declared or not, when it may as well give up. Where a time is declared it is waited
    for; where none is, silence is recorded. Returns None, and no transfer runs, if there is none.
    """
    declared, seconds = sdo.device.server_timeout, sdo.channel.response_timeout
    soon = sdo.channel.pace.soon(seconds)
    waited = PATIENCE * max(seconds, (declared or 0) + seconds / PATIENCE)
    at_once = sdo.wait(soon)
    response = at_once if at_once is not None else sdo.wait(max(waited - soon, 0))
    if response is None and declared is None:
        sdo.info(
            f"a gap is not acknowledged within {waited * 1000:g} ms: declare the time after "
            "which the device acknowledges it, or gives up, with --sdo-server-timeout=SECONDS"
        )
        sdo.end_transfer()
        return None
    if response is None:
        raise Violation(
            BLOCK_ACK,
            expected=f"ackseq 0 to {position}, with the declared time-out at the latest",
            actual=NoAnswer(f"nothing within {waited:.3g} s"),
        )
    gives_up = isinstance(response, Abort) and response.code == AbortCode.TIMED_OUT
    if gives_up and (declared or at_once is None):
        sdo.checks.abort(response, mux_of(known))
        sdo.info("a gap is not acknowledged: the server gives up")
        return None
    with sdo.served():
        return sdo.checks.block_ack(response, mux_of(known), position)


def send_again(sdo: Dialogue, known: KnownObject, gap: Gap) -> None:
    """Send what is due behind a gap, and take the end: in sub-blocks as long as the server says."""
    blocks, unsent = Blocks(sdo), gap.unsent
    while not unsent.is_over:
        sub_block = unsent.sub_block()
        blocks.send_sub_block(sub_block)
        unsent.acknowledged(blocks.acknowledged(known, len(sub_block)), sub_block)
    blocks.end_download(known, unused=unsent.unused, crc=gap.crc)
