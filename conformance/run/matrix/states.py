"""The states of a server, and the shortest way into each (CiA 301, 7.2.4.3).

Transfers are of 20 bytes, that is three segments, the last one with 6 bytes of data. In the
middle of a block download at a border of sub-blocks it takes as much as the server's block size
asks for. What a download finds there is the device's own value, and it has room for 20 bytes.
"""

from collections.abc import Callable

from conformance.device.device import NotTestable
from conformance.device.objects import KnownObject
from conformance.run.block_steps import segments_of
from conformance.run.dialogue import Dialogue
from conformance.sdo.frames import BlockAck

SIZE = 20
Reach = Callable[[Dialogue, KnownObject], None]


def idle(sdo: Dialogue, known: KnownObject) -> None:
    """Store a value: the state is idle, and what was before is known."""
    sdo.download(known, sdo.payload(SIZE), segmented=True)


def segmented_download(segments: int) -> Reach:
    """Return the way into a segmented download of which so many segments are there."""

    def reach(sdo: Dialogue, known: KnownObject) -> None:
        chunks = segments_of(sdo.payload(SIZE))
        sdo.initiate_download(known, SIZE)
        for number, chunk in enumerate(chunks[:segments]):
            sdo.download_segment(chunk, toggle=number % 2)

    return reach


def segmented_upload(segments: int) -> Reach:
    """Return the way into a segmented upload of which so many segments came."""

    def reach(sdo: Dialogue, known: KnownObject) -> None:
        idle(sdo, known)
        sdo.start_segmented_upload(known)
        for number in range(segments):
            if sdo.upload_segment(toggle=number % 2).last:
                raise NotTestable(f"{known} is uploaded in {number + 1} segments: too few")

    return reach


def block_download(segments: int) -> Reach:
    """Return the way into a block download of which so many segments were sent.

    With all three, the server has acknowledged them.
    """

    def reach(sdo: Dialogue, known: KnownObject) -> None:
        block_size = sdo.initiate_block_download(known, SIZE).block_size
        chunks = segments_of(sdo.payload(SIZE))
        pending = 0
        for number, chunk in enumerate(chunks[:segments]):
            last = number == len(chunks) - 1
            sdo.send_segments([chunk], first=pending + 1, last=last)
            pending += 1
            if pending == block_size or last:
                block_size, pending = sdo.acknowledged(known, pending).block_size, 0

    return reach


def block_download_between(sdo: Dialogue, known: KnownObject) -> None:
    """Go to where the first sub-block of a block download is acknowledged, and one is to come."""
    block_size = sdo.initiate_block_download(known, None).block_size
    if not sdo.has_room(known, 7 * block_size):
        # What follows its abort would be requests to the server, which might do anything.
        sdo.end_transfer()
        sdo.need_room(known, 7 * block_size)
        following = sdo.initiate_block_download(known, None).block_size
        if following > block_size:
            raise NotTestable(f"the block size grows from {block_size} to {following}, {known} not")
        block_size = following
    sdo.send_segments(segments_of(sdo.payload(7 * block_size)))
    sdo.acknowledged(known, block_size)


def block_upload_initiated(sdo: Dialogue, known: KnownObject) -> None:
    """Go to where a block upload waits for its start."""
    idle(sdo, known)
    sdo.initiate_block_upload(known, block_size=2)


def block_upload_between(sdo: Dialogue, known: KnownObject) -> None:
    """Go to where the first of two sub-blocks waits for its acknowledgement."""
    block_upload_initiated(sdo, known)
    sdo.start_block_upload(known, 2)


def block_upload_sent(sdo: Dialogue, known: KnownObject) -> None:
    """Go to where the last sub-block waits for its acknowledgement."""
    block_upload_between(sdo, known)
    sdo.sub_block(known, BlockAck(2, 2), 2)


def block_upload_end(sdo: Dialogue, known: KnownObject) -> None:
    """Go to where the end of a block upload waits for its confirmation."""
    block_upload_sent(sdo, known)
    sdo.end_of_block_upload(known, BlockAck(1, 2))


STATES: dict[str, Reach] = {
    "idle": idle,
    "segmented-download-first": segmented_download(0),
    "segmented-download-middle": segmented_download(1),
    "segmented-download-last": segmented_download(2),
    "segmented-upload-first": segmented_upload(0),
    "segmented-upload-middle": segmented_upload(1),
    "segmented-upload-last": segmented_upload(2),
    "block-download-first": block_download(0),
    "block-download-inside": block_download(1),
    "block-download-between": block_download_between,
    "block-download-end": block_download(3),
    "block-upload-initiated": block_upload_initiated,
    "block-upload-between": block_upload_between,
    "block-upload-sent": block_upload_sent,
    "block-upload-end": block_upload_end,
}
