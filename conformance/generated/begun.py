"""Transfers that are begun and not ended: every state in which a server can wait for its client."""

from collections.abc import Callable
from dataclasses import dataclass

from conformance.device.lacking import NotTestable
from conformance.device.objects import KnownObject
from conformance.device.roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.room import Room
from conformance.dialogue.values import segments_of
from conformance.run.risks import LOST_SEGMENT, Risk
from conformance.sdo.block_client import LARGEST_BLOCK
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadStart,
    DownloadSegment,
    Request,
    UploadSegment,
)

BLOCK_SIZE = 2
SIZE = 20
TWO_SEGMENTS = 8


@dataclass(frozen=True, slots=True)
class Begun:
    """A transfer that waits for its client, and the frame with which the client would go on.

    ``value`` is what the object held before a download, None for an upload. ``in_sub_block`` says
    that segments of a block download are due: whatever comes then is one, and only an abort leads
    out.
    """

    known: KnownObject
    due: Request
    value: bytes | None = None
    in_sub_block: bool = False


def begin_block_download(
    sdo: Dialogue, known: KnownObject, segments: int | None, size: int
) -> bytes:
    """Start a block download of ``size`` bytes and send so many segments; return its data.

    With all of them, None, the end is due.
    """
    data = sdo.payload(size)
    send_blocks(sdo, known, data, segments)
    return data


def send_blocks(
    sdo: Dialogue, known: KnownObject, data: bytes, segments: int | None
) -> BlockDownloadInitiateResponse:
    """Start a block download and send so many segments, None for all; return the first answer."""
    blocks = Blocks(sdo)
    response = blocks.initiate_download(known, len(data))
    block_size = response.block_size
    chunks = segments_of(data)
    pending = 0
    for number, chunk in enumerate(chunks[:segments]):
        last = number == len(chunks) - 1
        blocks.send_segments([chunk], first=pending + 1, last=last)
        pending += 1
        if last or pending == block_size:
            block_size, pending = blocks.acknowledged(known, pending).block_size, 0
    return response


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


def begin_block_upload(sdo: Dialogue, sub_blocks: int) -> KnownObject:
    """Start an upload in sub-blocks of two segments, and take none, the first, or all of them.

    After the first the server waits for its acknowledgement, after all it has sent the end. Of a
    server that sends more segments than it is asked for, all are taken at once.
    """
    blocks = Blocks(sdo)
    known, _ = Room(sdo).long_object(segments=3)
    to_the_end = sub_blocks > 1
    at_once = to_the_end and sdo.record.causes.sub_blocks_are_exceeded
    block_size = LARGEST_BLOCK if at_once else BLOCK_SIZE
    blocks.initiate_upload(known, block_size=block_size)
    if sub_blocks == 0:
        return known
    segments = blocks.start_upload(known, block_size)
    if not to_the_end:
        return known
    while not segments[-1].last:
        segments = blocks.sub_block(known, BlockAck(len(segments), block_size), block_size)
    sdo.send(BlockAck(len(segments), block_size))
    sdo.checks.block_end(sdo.receive(), known.mux)
    return known


def _stored_text(sdo: Dialogue, least: int = TWO_SEGMENTS) -> tuple[KnownObject, bytes, bytes]:
    """Return a string, the value that it has, and the one that is to be written."""
    text = Roles(sdo.device).text()
    value = Room(sdo).prepare(text, SIZE, least)
    return text, value, sdo.payload(len(value))


def _segmented_download(sdo: Dialogue) -> Begun:
    text, value, data = _stored_text(sdo)
    sdo.initiate_download(text, len(data))
    return Begun(text, DownloadSegment.with_data(data[:7], toggle=0), value)


def _segmented_download_in_the_middle(sdo: Dialogue) -> Begun:
    text, value, data = _stored_text(sdo)
    sdo.initiate_download(text, len(data))
    sdo.download_segment(data[:7], toggle=0)
    due = DownloadSegment.with_data(data[7:14], toggle=1, last=len(data) <= 14)
    return Begun(text, due, value)


def _segmented_upload(sdo: Dialogue) -> Begun:
    known, _ = Room(sdo).long_object()
    sdo.start_segmented_upload(known)
    return Begun(known, UploadSegment(0))


def _segmented_upload_in_the_middle(sdo: Dialogue) -> Begun:
    known, _ = Room(sdo).long_object()
    sdo.start_segmented_upload(known)
    sdo.upload_segment(toggle=0)
    return Begun(known, UploadSegment(1))


def _block_download(sdo: Dialogue) -> Begun:
    text, value, _ = _stored_text(sdo)
    data = begin_block_download(sdo, text, 0, len(value))
    due = BlockSegment.with_data(1, data[:7])
    return Begun(text, due, value, in_sub_block=True)


def _block_download_in_a_sub_block(sdo: Dialogue) -> Begun:
    text, value, data = _stored_text(sdo)
    response = Blocks(sdo).initiate_download(text, len(data))
    if response.block_size == 1:
        raise NotTestable("the server takes 1 segment at once: a sub-block has no middle")
    sdo.send(BlockSegment(1, data[:7]))
    due = BlockSegment.with_data(2, data[7:14], last=len(data) <= 14)
    return Begun(text, due, value, in_sub_block=True)


def _block_download_between_sub_blocks(sdo: Dialogue) -> Begun:
    blocks = Blocks(sdo)
    text, value, data = _stored_text(sdo)
    chunks = segments_of(data)
    response = blocks.initiate_download(text, len(data))
    if response.block_size < len(chunks):
        taken = response.block_size
        blocks.send_segments(chunks[:taken])
    else:
        # A gap ends a sub-block as well, however long the server wants them.
        taken = min(1, len(chunks) - 2)
        blocks.send_segments(chunks[:taken])
        blocks.send_segments(chunks[taken + 1 :], first=taken + 2, last=True)
    blocks.acknowledged(text, taken)
    last = taken + 1 == len(chunks)
    due = BlockSegment.with_data(1, chunks[taken], last=last)
    return Begun(text, due, value, in_sub_block=True)


def _block_download_before_the_end(sdo: Dialogue) -> Begun:
    text, value, _ = _stored_text(sdo)
    data = begin_block_download(sdo, text, None, len(value))
    return Begun(text, BlockEnd(unused_in(data), crc16(data)), value)


def _block_upload(sdo: Dialogue) -> Begun:
    return Begun(begin_block_upload(sdo, 0), BlockUploadStart())


def _block_upload_sub_block_sent(sdo: Dialogue) -> Begun:
    return Begun(begin_block_upload(sdo, 1), BlockAck(BLOCK_SIZE, BLOCK_SIZE))


def _block_upload_end_sent(sdo: Dialogue) -> Begun:
    return Begun(begin_block_upload(sdo, 2), BlockEndResponse())


def risk_of_state(state: Callable[[Dialogue], Begun]) -> Risk | None:
    """Return what is risky about the way into a state."""
    return LOST_SEGMENT if state is _block_download_between_sub_blocks else None


STATES: dict[str, Callable[[Dialogue], Begun]] = {
    "segmented-download": _segmented_download,
    "segmented-download-in-the-middle": _segmented_download_in_the_middle,
    "segmented-upload": _segmented_upload,
    "segmented-upload-in-the-middle": _segmented_upload_in_the_middle,
    "block-download": _block_download,
    "block-download-in-a-sub-block": _block_download_in_a_sub_block,
    "block-download-between-sub-blocks": _block_download_between_sub_blocks,
    "block-download-before-the-end": _block_download_before_the_end,
    "block-upload": _block_upload,
    "block-upload-sub-block-sent": _block_upload_sub_block_sent,
    "block-upload-end-sent": _block_upload_end_sent,
}
