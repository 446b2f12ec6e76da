"""Transfers that are begun and not ended: every state in which a server can wait for its client."""

from collections.abc import Callable
from dataclasses import dataclass

from conformance.device.device import NotTestable
from conformance.device.objects import KnownObject
from conformance.run.block_steps import segments_of
from conformance.run.dialogue import Dialogue
from conformance.run.risks import LOST_SEGMENT, Risk
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    BlockAck,
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


def begin_block_download(sdo: Dialogue, text: KnownObject, segments: int, size: int = 14) -> bytes:
    """Start a block download of two segments and send so many of them; return its data."""
    data = sdo.payload(size)
    response = sdo.initiate_block_download(text, size)
    chunks = segments_of(data)
    if segments == 0:
        return data
    if response.block_size == 1:
        for number in range(segments):
            sdo.send_segments(chunks[number : number + 1], last=number == len(chunks) - 1)
            sdo.acknowledged(text, 1)
        return data
    sdo.send_segments(chunks[:segments], last=segments == len(chunks))
    if segments == len(chunks) or segments == response.block_size:
        sdo.acknowledged(text, segments)
    return data


@dataclass(frozen=True, slots=True)
class Gap:
    """A block download of which a segment was lost and the gap acknowledged: what is still to come.

    The ``segments`` from the lost one on are due again, in sub-blocks of ``block_size``; ``crc`` is
    what the end frame has to say.
    """

    data: bytes
    segments: list[bytes]
    block_size: int
    crc: int


def lose_segment(sdo: Dialogue, known: KnownObject, size: int, position: int) -> Gap | None:
    """Send a block download in one sub-block, all but the segment at a position, counted from 0.

    It is not the last. None where the server takes too few segments at once for a gap, or keeps
    silent about it.
    """
    data = sdo.payload(size)
    sdo.store(known, sdo.payload(size))
    chunks = segments_of(data)
    response = sdo.initiate_block_download(known, size)
    if response.block_size < len(chunks):
        sdo.info(f"the server takes {response.block_size} segments at once: no gap fits in")
        return None
    sdo.send_segments(chunks[:position])
    sdo.send_segments(chunks[position + 1 :], first=position + 2, last=True)
    ack = sdo.gap_acknowledged(known, position)
    if ack is None:
        return None
    crc = crc16(data) if response.crc_supported else 0
    return Gap(data, chunks[position:], ack.block_size, crc)


def begin_block_upload(sdo: Dialogue, sub_blocks: int) -> KnownObject:
    """Start an upload in sub-blocks of two segments, and take none, the first, or all of them.

    After the first the server waits for its acknowledgement, after all it has sent the end.
    """
    known, _ = sdo.long_object(segments=3)
    sdo.initiate_block_upload(known, block_size=BLOCK_SIZE)
    if sub_blocks == 0:
        return known
    segments = sdo.start_block_upload(known, BLOCK_SIZE)
    if sub_blocks == 1:
        return known
    while not segments[-1].last:
        segments = sdo.sub_block(known, BlockAck(BLOCK_SIZE, BLOCK_SIZE), BLOCK_SIZE)
    sdo.send(BlockAck(len(segments), BLOCK_SIZE))
    sdo.checks.block_end(sdo.receive(), known.mux)
    return known


def _stored_text(sdo: Dialogue) -> tuple[KnownObject, bytes]:
    text, value = sdo.device.text(), sdo.payload(SIZE)
    sdo.store(text, value)
    return text, value


def _segmented_download(sdo: Dialogue) -> Begun:
    text, value = _stored_text(sdo)
    sdo.initiate_download(text, SIZE)
    return Begun(text, DownloadSegment.with_data(b"ABCDEFG", toggle=0), value)


def _segmented_download_in_the_middle(sdo: Dialogue) -> Begun:
    text, value = _stored_text(sdo)
    sdo.initiate_download(text, SIZE)
    sdo.download_segment(b"ABCDEFG", toggle=0)
    return Begun(text, DownloadSegment.with_data(b"HIJKLMN", toggle=1), value)


def _segmented_upload(sdo: Dialogue) -> Begun:
    known, _ = sdo.long_object()
    sdo.start_segmented_upload(known)
    return Begun(known, UploadSegment(0))


def _segmented_upload_in_the_middle(sdo: Dialogue) -> Begun:
    known, _ = sdo.long_object()
    sdo.start_segmented_upload(known)
    sdo.upload_segment(toggle=0)
    return Begun(known, UploadSegment(1))


def _block_download(sdo: Dialogue) -> Begun:
    text, value = _stored_text(sdo)
    begin_block_download(sdo, text, 0, SIZE)
    return Begun(text, BlockSegment(1, b"ABCDEFG"), value, in_sub_block=True)


def _block_download_in_a_sub_block(sdo: Dialogue) -> Begun:
    text, value = _stored_text(sdo)
    response = sdo.initiate_block_download(text, SIZE)
    if response.block_size == 1:
        raise NotTestable("the server takes 1 segment at once: a sub-block has no middle")
    sdo.send(BlockSegment(1, b"ABCDEFG"))
    return Begun(text, BlockSegment(2, b"HIJKLMN"), value, in_sub_block=True)


def _block_download_between_sub_blocks(sdo: Dialogue) -> Begun:
    text, value = _stored_text(sdo)
    chunks = segments_of(sdo.payload(SIZE))
    response = sdo.initiate_block_download(text, SIZE)
    if response.block_size < len(chunks):
        sdo.send_segments(chunks[: response.block_size])
        sdo.acknowledged(text, response.block_size)
    else:
        # A gap ends a sub-block as well, however long the server wants them.
        sdo.send_segments(chunks[:1])
        sdo.send_segments(chunks[2:], first=3, last=True)
        sdo.acknowledged(text, 1)
    return Begun(text, BlockSegment(1, b"HIJKLMN"), value, in_sub_block=True)


def _block_download_before_the_end(sdo: Dialogue) -> Begun:
    text, value = _stored_text(sdo)
    data = begin_block_download(sdo, text, 2)
    return Begun(text, BlockEnd(0, crc16(data)), value)


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
