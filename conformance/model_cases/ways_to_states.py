"""The shortest ways from an idle server to each of its states: transfers with one stop."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from conformance.device.device import THREE_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.dialogue.block_downloads import (
    Gap,
    Upcoming,
    lose_one,
    send_again,
    send_step_by_step,
)
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.values import segments_of
from conformance.sdo.client import MOST_EMPTY_SEGMENTS
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
from conformance.sdo.rules import UPLOAD_ENDS, Violation
from conformance.sdo.seen import said
from conformance.sdo.unsent import Unsent

# That of uploads of three segments or more.
BLOCK_SIZE = 2
# What any sub-block can take.
LONGEST = LARGEST_BLOCK * SEGMENT_LENGTH
Due_co = TypeVar("Due_co", bound=Request | None, covariant=True)
Due = TypeVar("Due", bound=Request)
Way = Callable[[Dialogue, KnownObject, int], Iterator[Due_co]]
"""A transfer of an object, of a size in bytes, from an idle server on, with one stop.

That is where the state is reached: it yields the request with which the client would go on, None
where no transfer runs. Resumed, it goes on to its end.
"""


def idle(sdo: Dialogue, known: KnownObject, size: int) -> Iterator[None]:
    """Stay where every case begins."""
    yield None


def _stopping(requests: Iterator[Due], stop: int) -> Iterator[Due]:
    """Send the requests of a transfer, each as the next is asked for, with one stop."""
    for number, due in enumerate(requests):
        if number == stop:
            yield due


def segmented_download(stop: int) -> Way[DownloadSegment]:
    """Return the way to one of the segments, counted from the last where it is negative."""

    def way(sdo: Dialogue, known: KnownObject, size: int) -> Iterator[DownloadSegment]:
        chunks = segments_of(sdo.payload(size))
        return _stopping(_download_segments(sdo, known, size, chunks), stop % len(chunks))

    return way


def _download_segments(
    sdo: Dialogue, known: KnownObject, size: int, chunks: Sequence[bytes]
) -> Iterator[DownloadSegment]:
    sdo.initiate_download(known, size)
    for number, chunk in enumerate(chunks):
        toggle, last = number % 2, number == len(chunks) - 1
        yield DownloadSegment.with_data(chunk, toggle=toggle, last=last)
        sdo.download_segment(chunk, toggle=toggle, last=last)


def segmented_upload(stop: int) -> Way[UploadSegment]:
    """Return the way to one of the requests, counted from the last where it is negative."""

    def way(sdo: Dialogue, known: KnownObject, size: int) -> Iterator[UploadSegment]:
        at = stop % len(segments_of(bytes(size)))
        return _stopping(_upload_requests(sdo, known, size, at), at)

    return way


def _upload_requests(
    sdo: Dialogue, known: KnownObject, size: int, least: int
) -> Iterator[UploadSegment]:
    sdo.start_segmented_upload(known)
    for number in range(size + MOST_EMPTY_SEGMENTS):
        yield UploadSegment(number % 2)
        if sdo.upload_segment(toggle=number % 2).last:
            if number < least:
                raise NotTestable(f"{known} is uploaded in {number + 1} segments: too few")
            return
    raise Violation(
        UPLOAD_ENDS,
        expected=f"a last segment within {size} bytes",
        actual=said("{} segments and none marked as last", size + MOST_EMPTY_SEGMENTS),
    )


def _first(
    requests: Iterator[Upcoming], is_there: Callable[[Upcoming], bool]
) -> Iterator[BlockSegment | BlockEnd]:
    """Send the requests of a block download, with one stop: where it is there for the first time.

    What a server loses of a sub-block comes again, so that it may be there more often.
    """
    stopped = False
    for due in requests:
        if not stopped and is_there(due):
            stopped = True
            yield due.request


def block_download(stop: int) -> Way[BlockSegment | BlockEnd]:
    """Return the way to one of the segments, or to the end, which is the last request: -1."""

    def way(sdo: Dialogue, known: KnownObject, size: int) -> Iterator[BlockSegment | BlockEnd]:
        data = sdo.payload(size)
        response = Blocks(sdo).initiate_download(known, size)
        position = stop % (len(segments_of(data)) + 1)
        requests = send_step_by_step(sdo, known, data, response)
        yield from _first(requests, lambda due: due.position == position)

    return way


def block_download_between(
    sdo: Dialogue, known: KnownObject, size: int
) -> Iterator[BlockSegment | BlockEnd]:
    """Have a sub-block acknowledged: a whole one, or where a transfer is shorter, up to a gap."""
    if size >= LONGEST:
        yield from _whole_sub_block(sdo, known)
        return
    data = sdo.payload(size)
    response = Blocks(sdo).initiate_download(known, size)
    unsent = Unsent(data, response.block_size)
    if response.block_size < unsent.total:
        requests = send_step_by_step(sdo, known, data, response)
        yield from _first(requests, lambda due: due.sub_block == 1)
        return
    # A gap ends a sub-block as well, however long the server wants them.
    if not lose_one(sdo, known, unsent, min(1, unsent.total - 2)):
        raise NotTestable("the server does not acknowledge the gap that leads to this state")
    yield unsent.sub_block()[0]
    send_again(sdo, known, Gap(unsent, crc16(data) if response.crc_supported else 0))


def _whole_sub_block(sdo: Dialogue, known: KnownObject) -> Iterator[BlockSegment | BlockEnd]:
    """Have a whole sub-block acknowledged, of as many bytes as the server's block size asks for.

    There is one segment more to come.
    """
    room, blocks = Room(sdo), Blocks(sdo)
    response = blocks.initiate_download(known, None)
    block_size = response.block_size
    if not room.has(known, 7 * block_size):
        # What follows its abort would be requests to the server, which might do anything.
        sdo.end_transfer()
        room.need(known, 7 * block_size)
        response = blocks.initiate_download(known, None)
        if response.block_size > block_size:
            raise NotTestable(
                f"the server asked for sub-blocks of {block_size} segments, then of "
                f"{response.block_size}: {known} is too short for these"
            )
        block_size = response.block_size
    data = sdo.payload(7 * block_size)
    requests = send_step_by_step(sdo, known, data + data[:7], response)
    yield from _first(requests, lambda due: due.sub_block == 1)


def block_upload(stop: int) -> Way[Request]:
    """Return the way to one of the requests: the start, acknowledgements, and that of the end.

    It is counted from the last where it is negative: the way there is shortest with all segments
    in one sub-block.
    """

    def way(sdo: Dialogue, known: KnownObject, size: int) -> Iterator[Request]:
        count = len(segments_of(bytes(size)))
        block_size = BLOCK_SIZE if size >= THREE_SEGMENTS else 1
        if stop < 0:
            block_size = LARGEST_BLOCK
        sub_blocks = -(-count // block_size)
        at = stop % (1 + sub_blocks + 1)
        requests = _block_upload_requests(sdo, known, block_size, sub_blocks, at)
        return _stopping(requests, at)

    return way


def _block_upload_requests(
    sdo: Dialogue, known: KnownObject, block_size: int, sub_blocks: int, least: int
) -> Iterator[Request]:
    """Send the requests of a block upload, of so many sub-blocks if it does not end early."""
    blocks = Blocks(sdo)
    blocks.initiate_upload(known, block_size=block_size)
    request: Request = BlockUploadStart()
    acknowledgement = BlockAck(0, block_size)
    for number in range(sub_blocks):
        yield request
        segments = blocks.sub_block(known, request, block_size)
        request = acknowledgement = BlockAck(len(segments), block_size)
        if segments[-1].last and number + 1 < sub_blocks:
            if number < least:
                raise NotTestable(f"{known} is uploaded in {number + 1} sub-blocks: too few")
            break
    yield acknowledgement
    blocks.end_of_upload(known, acknowledgement)
    yield BlockEndResponse()
    sdo.send(BlockEndResponse())
