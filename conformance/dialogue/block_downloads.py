"""Block downloads step by step: begun and not ended, and with a segment that is lost."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

from conformance.device.device import TWO_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.room import Room
from conformance.dialogue.values import segments_of
from conformance.sdo.crc import crc16
from conformance.sdo.frames import BlockDownloadInitiateResponse, BlockEnd, BlockSegment


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
    sdo: Dialogue, known: KnownObject, data: bytes, segments: int | None
) -> BlockDownloadInitiateResponse:
    """Start a block download, send its first ``segments``, or all; return the first answer."""
    response = Blocks(sdo).initiate_download(known, len(data))
    count = len(segments_of(data)[:segments])
    next(islice(send_step_by_step(sdo, known, data, response), count, None))
    return response


def send_step_by_step(
    sdo: Dialogue, known: KnownObject, data: bytes, response: BlockDownloadInitiateResponse
) -> Iterator[BlockSegment | BlockEnd]:
    """Send a block download that was initiated, each request as the next is asked for.

    Yields what is due: the segments, then the end.
    """
    blocks = Blocks(sdo)
    block_size = response.block_size
    chunks = segments_of(data)
    pending = 0
    for number, chunk in enumerate(chunks):
        last = number == len(chunks) - 1
        yield BlockSegment.with_data(pending + 1, chunk, last=last)
        blocks.send_segments([chunk], first=pending + 1, last=last)
        pending += 1
        if last or pending == block_size:
            block_size, pending = blocks.acknowledged(known, pending).block_size, 0
    unused, crc = unused_in(data), crc16(data) if response.crc_supported else 0
    yield BlockEnd(unused, crc)
    blocks.end_download(known, unused=unused, crc=crc)


def unused_in(data: bytes) -> int:
    """Return n of the end frame: how many bytes of the last segment hold no data."""
    return 7 * len(segments_of(data)) - len(data)


@dataclass(frozen=True, slots=True)
class Gap:
    """A block download of which a segment was lost and the gap acknowledged: what is still to come.

    The ``segments`` from the lost one on are due again; ``position`` is that of the first of them.
    ``block_size`` is how many the server takes at once, as it said last; ``crc`` is what the end
    frame has to say.
    """

    data: bytes
    segments: list[bytes]
    position: int
    block_size: int
    crc: int

    @property
    def unused(self) -> int:
        """How many bytes of the last segment hold no data."""
        return unused_in(self.data)


def lose_segment(sdo: Dialogue, known: KnownObject, size: int, position: int) -> Gap | None:
    """Send a block download in one sub-block, all but the segment at a position, counted from 0.

    It is not the last: where the object takes fewer bytes than ``size``, an earlier one is lost.
    None where the server takes too few segments at once for a gap, or keeps silent about it.
    """
    blocks = Blocks(sdo)
    data = sdo.payload(len(Room(sdo).prepare(known, size, least=TWO_SEGMENTS)))
    chunks = segments_of(data)
    position = min(position, len(chunks) - 2)
    response = blocks.initiate_download(known, len(data))
    if response.block_size < len(chunks):
        sdo.info(f"the server takes {response.block_size} segments at once: no gap fits in")
        return None
    blocks.send_segments(chunks[:position])
    blocks.send_segments(chunks[position + 1 :], first=position + 2, last=True)
    ack = blocks.gap_acknowledged(known, position)
    if ack is None:
        return None
    crc = crc16(data) if response.crc_supported else 0
    return Gap(data, chunks[position:], position, ack.block_size, crc)


def send_again(sdo: Dialogue, known: KnownObject, gap: Gap) -> None:
    """Send what is due behind a gap, and take the end: in sub-blocks as long as the server says."""
    blocks = Blocks(sdo)
    left, block_size = gap.segments, gap.block_size
    while left:
        count = min(block_size, len(left))
        blocks.send_segments(left[:count], last=count == len(left))
        block_size, left = blocks.acknowledged(known, count).block_size, left[count:]
    blocks.end_download(known, unused=gap.unused, crc=gap.crc)
