"""The states of a server, and the shortest way into each (CiA 301, 7.2.4.3).

Transfers are of 20 bytes, that is three segments, the last one with 6 bytes of data, or of as many
as the object takes. In the middle of a block download at a border of sub-blocks it takes as much as
the server's block size asks for. What a download finds there is the device's own value.
"""

from collections.abc import Callable

from conformance.device.device import THREE_SEGMENTS
from conformance.device.lacking import NotTestable
from conformance.device.objects import KnownObject
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.room import Room
from conformance.dialogue.values import segments_of
from conformance.sdo.block_client import LARGEST_BLOCK
from conformance.sdo.frames import BlockAck

SIZE = 20
TWO_SEGMENTS = 8
BETWEEN = "block-download-between"
# Brings the server into a state by a transfer of an object, of so many bytes.
Reach = Callable[[Dialogue, KnownObject, int], None]


def idle(sdo: Dialogue, known: KnownObject, size: int) -> None:
    """Store a value: the state is idle, and what was before is known."""
    Room(sdo).store(known, sdo.payload(size), segmented=True)


def segmented_download(segments: int) -> Reach:
    """Return the way into a segmented download of which so many segments are there.

    A negative number says how many are to come.
    """

    def reach(sdo: Dialogue, known: KnownObject, size: int) -> None:
        chunks = segments_of(sdo.payload(size))
        sdo.initiate_download(known, size)
        for number, chunk in enumerate(chunks[:segments]):
            sdo.download_segment(chunk, toggle=number % 2)

    return reach


def segmented_upload(segments: int) -> Reach:
    """Return the way into a segmented upload of which so many segments came, or are to come."""

    def reach(sdo: Dialogue, known: KnownObject, size: int) -> None:
        idle(sdo, known, size)
        sdo.start_segmented_upload(known)
        for number in range(len(segments_of(bytes(size))[:segments])):
            if sdo.upload_segment(toggle=number % 2).last:
                raise NotTestable(f"{known} is uploaded in {number + 1} segments: too few")

    return reach


def block_download(segments: int | None) -> Reach:
    """Return the way into a block download of which so many segments were sent.

    With all of them, None, the server has acknowledged them.
    """

    def reach(sdo: Dialogue, known: KnownObject, size: int) -> None:
        blocks = Blocks(sdo)
        block_size = blocks.initiate_download(known, size).block_size
        chunks = segments_of(sdo.payload(size))
        pending = 0
        for number, chunk in enumerate(chunks[:segments]):
            last = number == len(chunks) - 1
            blocks.send_segments([chunk], first=pending + 1, last=last)
            pending += 1
            if pending == block_size or last:
                block_size, pending = blocks.acknowledged(known, pending).block_size, 0

    return reach


def block_download_between(sdo: Dialogue, known: KnownObject, size: int) -> None:
    """Go to where the first sub-block of a block download is acknowledged, and one is to come."""
    room = Room(sdo)
    blocks = Blocks(sdo)
    del size
    block_size = blocks.initiate_download(known, None).block_size
    if not room.has(known, 7 * block_size):
        # What follows its abort would be requests to the server, which might do anything.
        sdo.end_transfer()
        room.need(known, 7 * block_size)
        following = blocks.initiate_download(known, None).block_size
        if following > block_size:
            raise NotTestable(f"the block size grows from {block_size} to {following}, {known} not")
        block_size = following
    blocks.send_segments(segments_of(sdo.payload(7 * block_size)))
    blocks.acknowledged(known, block_size)


def blocks_of(size: int) -> int:
    """Return the block size with which an upload of so many bytes takes two sub-blocks."""
    return 2 if size >= THREE_SEGMENTS else 1


def block_upload_initiated(sdo: Dialogue, known: KnownObject, size: int) -> None:
    """Go to where a block upload waits for its start."""
    idle(sdo, known, size)
    Blocks(sdo).initiate_upload(known, block_size=blocks_of(size))


def block_upload_between(sdo: Dialogue, known: KnownObject, size: int) -> None:
    """Go to where the first of two sub-blocks or more waits for its acknowledgement."""
    block_upload_initiated(sdo, known, size)
    Blocks(sdo).start_upload(known, blocks_of(size))


def block_upload_sent(sdo: Dialogue, known: KnownObject, size: int) -> None:
    """Go to where the last sub-block waits for its acknowledgement."""
    _last_sub_block(sdo, known, size)


def block_upload_end(sdo: Dialogue, known: KnownObject, size: int) -> None:
    """Go to where the end of a block upload waits for its confirmation."""
    Blocks(sdo).end_of_upload(known, _last_sub_block(sdo, known, size))


def _last_sub_block(sdo: Dialogue, known: KnownObject, size: int) -> BlockAck:
    """Take a block upload to its last sub-block, and return what acknowledges that.

    Of a server that sends more segments than it is asked for, all are taken at once.
    """
    blocks = Blocks(sdo)
    count, block_size = len(segments_of(bytes(size))), blocks_of(size)
    if sdo.record.causes.sub_blocks_are_exceeded and count <= LARGEST_BLOCK:
        block_size = LARGEST_BLOCK
    idle(sdo, known, size)
    blocks.initiate_upload(known, block_size=block_size)
    blocks.start_upload(known, block_size)
    for _ in range(block_size, count, block_size):
        blocks.sub_block(known, BlockAck(block_size, block_size), block_size)
    return BlockAck((count - 1) % block_size + 1, block_size)


STATES: dict[str, Reach] = {
    "idle": idle,
    "segmented-download-first": segmented_download(0),
    "segmented-download-middle": segmented_download(1),
    "segmented-download-last": segmented_download(-1),
    "segmented-upload-first": segmented_upload(0),
    "segmented-upload-middle": segmented_upload(1),
    "segmented-upload-last": segmented_upload(-1),
    "block-download-first": block_download(0),
    "block-download-inside": block_download(1),
    BETWEEN: block_download_between,
    "block-download-end": block_download(None),
    "block-upload-initiated": block_upload_initiated,
    "block-upload-between": block_upload_between,
    "block-upload-sent": block_upload_sent,
    "block-upload-end": block_upload_end,
}
# The fewest bytes with which there is such a state, where that is not one segment.
LEAST = {
    "segmented-download-middle": THREE_SEGMENTS,
    "segmented-download-last": TWO_SEGMENTS,
    "segmented-upload-first": TWO_SEGMENTS,
    "segmented-upload-middle": THREE_SEGMENTS,
    "segmented-upload-last": TWO_SEGMENTS,
    "block-download-inside": TWO_SEGMENTS,
    "block-upload-between": TWO_SEGMENTS,
    "block-upload-sent": TWO_SEGMENTS,
    "block-upload-end": TWO_SEGMENTS,
}
