"""The states of a server: what each is called, how it is reached, and what goes on there.

A state says what the server waits for (CiA 301, 7.2.4.3). A transfer in segments waits for the
``first`` one, for one in the ``middle``, or for the ``last``. A block download waits for the
``first`` segment of all, for one ``inside`` a sub-block, for one ``between`` two sub-blocks, or for
the ``end``. A block upload that is ``initiated`` waits for its start, ``between`` two sub-blocks
and with all of them ``sent`` for an acknowledgement, at the ``end`` for its confirmation.

All cases that are about a state take it from here: those that send each frame in each state, those
of a client that falls silent, and those of one service. Their ids have its name.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from conformance.device.device import THREE_SEGMENTS, TWO_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.device.lacking import NotTestable
from conformance.dialogue.block_downloads import begin_block_download, send_blocks, unused_in
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.room import Room
from conformance.dialogue.values import segments_of
from conformance.generated.matrix.stimuli import (
    NEXT_SUB_BLOCK_STIMULI,
    STIMULI,
    SUB_BLOCK_STIMULI,
    Stimulus,
)
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
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH

# Three segments, the last one with 6 bytes of data.
SIZE = 20
# That of uploads of three segments or more.
BLOCK_SIZE = 2
# What any sub-block can take.
LONGEST = LARGEST_BLOCK * SEGMENT_LENGTH
Due_co = TypeVar("Due_co", bound=Request | None, covariant=True)
Reach = Callable[[Dialogue, KnownObject, int], Due_co]
"""Leads an idle server into a state by a transfer of an object, of a size in bytes.

Returns the request with which the client would go on; None where no transfer runs.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class State(Generic[Due_co]):
    """What a server waits for, and the shortest way there.

    ``sentence`` is about the server. ``least`` are the fewest bytes with which there is such a
    state. Where ``segment`` is a number, a segment of a sub-block with that number is due: whatever
    comes then is one, and only an abort leads out. Into a ``short`` one a transfer of two segments
    leads as well as a longer one. ``risk`` is what a server may not survive on the way with a
    transfer of ``SIZE``.
    """

    name: str
    sentence: str
    reach: Reach[Due_co]
    downloads: bool = False
    least: int = 1
    segment: int | None = None
    short: bool = False
    stimuli: Mapping[str, Stimulus] = field(default_factory=lambda: STIMULI)
    risk: Risk | None = None


def _idle(sdo: Dialogue, known: KnownObject, size: int) -> None:
    """Stay where every case begins."""


def _segmented_download(segments: int) -> Reach[DownloadSegment]:
    """Return the way into a download: ``segments`` were sent or, if negative, are to come."""

    def reach(sdo: Dialogue, known: KnownObject, size: int) -> DownloadSegment:
        chunks = segments_of(sdo.payload(size))
        sdo.initiate_download(known, size)
        sent = len(chunks[:segments])
        for number, chunk in enumerate(chunks[:sent]):
            sdo.download_segment(chunk, toggle=number % 2)
        last = sent == len(chunks) - 1
        return DownloadSegment.with_data(chunks[sent], toggle=sent % 2, last=last)

    return reach


def _segmented_upload(segments: int) -> Reach[UploadSegment]:
    """Return the way into an upload: ``segments`` came or, if negative, are to come."""

    def reach(sdo: Dialogue, known: KnownObject, size: int) -> UploadSegment:
        sdo.start_segmented_upload(known)
        taken = len(segments_of(bytes(size))[:segments])
        for number in range(taken):
            if sdo.upload_segment(toggle=number % 2).last:
                raise NotTestable(f"{known} is uploaded in {number + 1} segments: too few")
        return UploadSegment(taken % 2)

    return reach


def _block_download(segments: int) -> Reach[BlockSegment]:
    """Return the way into a block download of which ``segments`` were sent."""

    def reach(sdo: Dialogue, known: KnownObject, size: int) -> BlockSegment:
        data = sdo.payload(size)
        block_size = send_blocks(sdo, known, data, segments).block_size
        chunks = segments_of(data)
        last = segments == len(chunks) - 1
        return BlockSegment.with_data(segments % block_size + 1, chunks[segments], last=last)

    return reach


def _block_download_between(sdo: Dialogue, known: KnownObject, size: int) -> BlockSegment:
    """Have a sub-block acknowledged: a whole one, or where a transfer is shorter, up to a gap."""
    if size >= LONGEST:
        return _whole_sub_block(sdo, known)
    blocks = Blocks(sdo)
    chunks = segments_of(sdo.payload(size))
    taken = blocks.initiate_download(known, size).block_size
    if taken < len(chunks):
        blocks.send_segments(chunks[:taken])
    else:
        # A gap ends a sub-block as well, however long the server wants them.
        taken = min(1, len(chunks) - 2)
        blocks.send_segments(chunks[:taken])
        blocks.send_segments(chunks[taken + 1 :], first=taken + 2, last=True)
        if blocks.gap_acknowledged(known, taken) is None:
            raise NotTestable("the server does not acknowledge the gap that leads to this state")
        return BlockSegment.with_data(1, chunks[taken], last=taken == len(chunks) - 1)
    blocks.acknowledged(known, taken)
    return BlockSegment.with_data(1, chunks[taken], last=taken == len(chunks) - 1)


def _whole_sub_block(sdo: Dialogue, known: KnownObject) -> BlockSegment:
    """Have a whole sub-block acknowledged, of as many bytes as the server's block size asks for."""
    room, blocks = Room(sdo), Blocks(sdo)
    block_size = blocks.initiate_download(known, None).block_size
    if not room.has(known, 7 * block_size):
        # What follows its abort would be requests to the server, which might do anything.
        sdo.end_transfer()
        room.need(known, 7 * block_size)
        following = blocks.initiate_download(known, None).block_size
        if following > block_size:
            raise NotTestable(
                f"the server asked for sub-blocks of {block_size} segments, then of {following}: "
                f"{known} is too short for these"
            )
        block_size = following
    data = sdo.payload(7 * block_size)
    blocks.send_segments(segments_of(data))
    blocks.acknowledged(known, block_size)
    return BlockSegment.with_data(1, data[:7])


def _block_download_end(sdo: Dialogue, known: KnownObject, size: int) -> BlockEnd:
    data = begin_block_download(sdo, known, None, size)
    return BlockEnd(unused_in(data), crc16(data))


def _two_sub_blocks(size: int) -> int:
    """Return the block size with which an upload of ``size`` bytes takes two sub-blocks."""
    return BLOCK_SIZE if size >= THREE_SEGMENTS else 1


def _block_upload_initiated(sdo: Dialogue, known: KnownObject, size: int) -> BlockUploadStart:
    Blocks(sdo).initiate_upload(known, block_size=_two_sub_blocks(size))
    return BlockUploadStart()


def _block_upload_between(sdo: Dialogue, known: KnownObject, size: int) -> BlockAck:
    block_size = _two_sub_blocks(size)
    Blocks(sdo).initiate_upload(known, block_size=block_size)
    Blocks(sdo).start_upload(known, block_size)
    return BlockAck(block_size, block_size)


def _block_upload_sent(sdo: Dialogue, known: KnownObject, size: int) -> BlockAck:
    """Take all sub-blocks, and acknowledge all but the last.

    Of a server that sends more segments than it is asked for, all are taken at once.
    """
    blocks = Blocks(sdo)
    count, block_size = len(segments_of(bytes(size))), _two_sub_blocks(size)
    if sdo.record.causes.sub_blocks_are_exceeded and count <= LARGEST_BLOCK:
        block_size = LARGEST_BLOCK
    blocks.initiate_upload(known, block_size=block_size)
    blocks.start_upload(known, block_size)
    for _ in range(block_size, count, block_size):
        blocks.sub_block(known, BlockAck(block_size, block_size), block_size)
    return BlockAck((count - 1) % block_size + 1, block_size)


def _block_upload_end(sdo: Dialogue, known: KnownObject, size: int) -> BlockEndResponse:
    Blocks(sdo).end_of_upload(known, _block_upload_sent(sdo, known, size))
    return BlockEndResponse()


IDLE: State[None] = State(name="idle", sentence="No transfer runs.", reach=_idle)

SEGMENTED_DOWNLOAD_FIRST = State(
    name="segmented-download-first",
    sentence="A download was initiated: its first segment is due.",
    reach=_segmented_download(0),
    downloads=True,
)
SEGMENTED_DOWNLOAD_MIDDLE = State(
    name="segmented-download-middle",
    sentence="A segment of a download was confirmed: another one is due.",
    reach=_segmented_download(1),
    downloads=True,
    least=TWO_SEGMENTS,
)
SEGMENTED_DOWNLOAD_LAST = State(
    name="segmented-download-last",
    sentence="All segments of a download but one were confirmed: the last is due.",
    reach=_segmented_download(-1),
    downloads=True,
    short=True,
    least=TWO_SEGMENTS,
)

SEGMENTED_UPLOAD_FIRST = State(
    name="segmented-upload-first",
    sentence="An upload was initiated: its first segment is to be asked for.",
    reach=_segmented_upload(0),
    least=TWO_SEGMENTS,
)
SEGMENTED_UPLOAD_MIDDLE = State(
    name="segmented-upload-middle",
    sentence="A segment of an upload was sent: another one is to be asked for.",
    reach=_segmented_upload(1),
    least=TWO_SEGMENTS,
)
SEGMENTED_UPLOAD_LAST = State(
    name="segmented-upload-last",
    sentence="All segments of an upload but one were sent: the last is to be asked for.",
    reach=_segmented_upload(-1),
    least=TWO_SEGMENTS,
)

BLOCK_DOWNLOAD_FIRST = State(
    name="block-download-first",
    sentence="A block download was initiated: the first segment of its first sub-block is due.",
    reach=_block_download(0),
    downloads=True,
    segment=1,
    stimuli=SUB_BLOCK_STIMULI,
)
BLOCK_DOWNLOAD_INSIDE = State(
    name="block-download-inside",
    sentence="Segments of a sub-block of a download were sent: the next one is due.",
    reach=_block_download(1),
    downloads=True,
    least=TWO_SEGMENTS,
    segment=2,
    stimuli=SUB_BLOCK_STIMULI,
)
BLOCK_DOWNLOAD_BETWEEN = State(
    name="block-download-between",
    sentence="A sub-block of a download was acknowledged: the first segment of the next is due.",
    reach=_block_download_between,
    downloads=True,
    least=TWO_SEGMENTS,
    segment=1,
    stimuli=NEXT_SUB_BLOCK_STIMULI,
    risk=LOST_SEGMENT,
)
BLOCK_DOWNLOAD_END = State(
    name="block-download-end",
    sentence="All sub-blocks of a download were acknowledged: its end is due.",
    reach=_block_download_end,
    downloads=True,
    short=True,
)

BLOCK_UPLOAD_INITIATED = State(
    name="block-upload-initiated",
    sentence="A block upload was initiated: its start is due.",
    reach=_block_upload_initiated,
)
BLOCK_UPLOAD_BETWEEN = State(
    name="block-upload-between",
    sentence="A sub-block of an upload was sent, not the last: its acknowledgement is due.",
    reach=_block_upload_between,
    least=TWO_SEGMENTS,
)
BLOCK_UPLOAD_SENT = State(
    name="block-upload-sent",
    sentence="The last sub-block of an upload was sent: its acknowledgement is due.",
    reach=_block_upload_sent,
    least=TWO_SEGMENTS,
)
BLOCK_UPLOAD_END = State(
    name="block-upload-end",
    sentence="The end of a block upload was sent: its confirmation is due.",
    reach=_block_upload_end,
    least=TWO_SEGMENTS,
)


def by_name(*states: State[Due_co]) -> dict[str, State[Due_co]]:
    """Return states for the cases that are about each of them: the ids have their names."""
    return {state.name: state for state in states}


SEGMENTED_DOWNLOADS = by_name(
    SEGMENTED_DOWNLOAD_FIRST, SEGMENTED_DOWNLOAD_MIDDLE, SEGMENTED_DOWNLOAD_LAST
)
SEGMENTED_UPLOADS = by_name(SEGMENTED_UPLOAD_FIRST, SEGMENTED_UPLOAD_MIDDLE, SEGMENTED_UPLOAD_LAST)
BLOCK_DOWNLOADS: dict[str, State[Request]] = by_name(
    BLOCK_DOWNLOAD_FIRST, BLOCK_DOWNLOAD_INSIDE, BLOCK_DOWNLOAD_BETWEEN, BLOCK_DOWNLOAD_END
)
BLOCK_UPLOADS: dict[str, State[Request]] = by_name(
    BLOCK_UPLOAD_INITIATED, BLOCK_UPLOAD_BETWEEN, BLOCK_UPLOAD_SENT, BLOCK_UPLOAD_END
)
STATES: dict[str, State[Request | None]] = {
    IDLE.name: IDLE,
    **SEGMENTED_DOWNLOADS,
    **SEGMENTED_UPLOADS,
    **BLOCK_DOWNLOADS,
    **BLOCK_UPLOADS,
}
"""All that there are."""
SILENT: dict[str, State[Request]] = by_name(
    SEGMENTED_DOWNLOAD_FIRST,
    SEGMENTED_DOWNLOAD_MIDDLE,
    SEGMENTED_UPLOAD_FIRST,
    SEGMENTED_UPLOAD_MIDDLE,
    *BLOCK_DOWNLOADS.values(),
    BLOCK_UPLOAD_INITIATED,
    BLOCK_UPLOAD_BETWEEN,
    BLOCK_UPLOAD_END,
)
"""Where cases let the client fall silent: before the last segment it is as in the middle."""
