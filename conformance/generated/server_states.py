"""The states of a server: what each is called, how it is reached, and what goes on there.

A state says what the server waits for (CiA 301, 7.2.4.3). A transfer in segments waits for the
``first`` one, for one in the ``middle``, or for the ``last``. A block download waits for the
``first`` segment of all, for one ``inside`` a sub-block, for one ``between`` two sub-blocks, or for
the ``end``. A block upload that is ``initiated`` waits for its start, ``between`` two sub-blocks
and with all of them ``sent`` for an acknowledgement, at the ``end`` for its confirmation.

All cases that are about a state take it from here: those that send each frame in each state, those
of a client that falls silent, and those of one service. Their ids have its name.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from conformance.device.device import THREE_SEGMENTS, TWO_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.device.lacking import NotTestable
from conformance.dialogue.block_downloads import (
    Gap,
    Upcoming,
    lose_one,
    send_again,
    send_step_by_step,
)
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
from conformance.sdo.unsent import Unsent

# Three segments, the last one with 6 bytes of data.
SIZE = 20
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
    way: Way[Due_co]
    downloads: bool = False
    least: int = 1
    segment: int | None = None
    short: bool = False
    stimuli: Mapping[str, Stimulus] = field(default_factory=lambda: STIMULI)
    risk: Risk | None = None

    def reach(self, sdo: Dialogue, known: KnownObject, size: int) -> Due_co:
        """Lead an idle server there, and stay; return what the client would send next."""
        return next(self.way(sdo, known, size))

    @property
    def uploads(self) -> bool:
        """Whether an upload leads into it, so that the object has to hold what is read."""
        return not self.downloads and self is not IDLE


def _idle(sdo: Dialogue, known: KnownObject, size: int) -> Iterator[None]:
    """Stay where every case begins."""
    yield None


def _stopping(requests: Iterator[Due], stop: int) -> Iterator[Due]:
    """Send the requests of a transfer, each as the next is asked for, with one stop."""
    for number, due in enumerate(requests):
        if number == stop:
            yield due


def _segmented_download(stop: int) -> Way[DownloadSegment]:
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


def _segmented_upload(stop: int) -> Way[UploadSegment]:
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
        actual=f"{size + MOST_EMPTY_SEGMENTS} segments and none marked as last",
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


def _block_download(stop: int) -> Way[BlockSegment | BlockEnd]:
    """Return the way to one of the segments, or to the end, which is the last request: -1."""

    def way(sdo: Dialogue, known: KnownObject, size: int) -> Iterator[BlockSegment | BlockEnd]:
        data = sdo.payload(size)
        response = Blocks(sdo).initiate_download(known, size)
        position = stop % (len(segments_of(data)) + 1)
        requests = send_step_by_step(sdo, known, data, response)
        yield from _first(requests, lambda due: due.position == position)

    return way


def _block_download_between(
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


def _block_upload(stop: int) -> Way[Request]:
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


IDLE: State[None] = State(name="idle", sentence="No transfer runs.", way=_idle)

SEGMENTED_DOWNLOAD_FIRST = State(
    name="segmented-download-first",
    sentence="A download was initiated: its first segment is due.",
    way=_segmented_download(0),
    downloads=True,
)
SEGMENTED_DOWNLOAD_MIDDLE = State(
    name="segmented-download-middle",
    sentence="A segment of a download was confirmed: another one is due.",
    way=_segmented_download(1),
    downloads=True,
    least=TWO_SEGMENTS,
)
SEGMENTED_DOWNLOAD_LAST = State(
    name="segmented-download-last",
    sentence="All segments of a download but one were confirmed: the last is due.",
    way=_segmented_download(-1),
    downloads=True,
    short=True,
    least=TWO_SEGMENTS,
)

SEGMENTED_UPLOAD_FIRST = State(
    name="segmented-upload-first",
    sentence="An upload was initiated: its first segment is to be asked for.",
    way=_segmented_upload(0),
    least=TWO_SEGMENTS,
)
SEGMENTED_UPLOAD_MIDDLE = State(
    name="segmented-upload-middle",
    sentence="A segment of an upload was sent: another one is to be asked for.",
    way=_segmented_upload(1),
    least=TWO_SEGMENTS,
)
SEGMENTED_UPLOAD_LAST = State(
    name="segmented-upload-last",
    sentence="All segments of an upload but one were sent: the last is to be asked for.",
    way=_segmented_upload(-1),
    short=True,
    least=TWO_SEGMENTS,
)

BLOCK_DOWNLOAD_FIRST = State(
    name="block-download-first",
    sentence="A block download was initiated: the first segment of its first sub-block is due.",
    way=_block_download(0),
    downloads=True,
    segment=1,
    stimuli=SUB_BLOCK_STIMULI,
)
BLOCK_DOWNLOAD_INSIDE = State(
    name="block-download-inside",
    sentence="Segments of a sub-block of a download were sent: the next one is due.",
    way=_block_download(1),
    downloads=True,
    least=TWO_SEGMENTS,
    segment=2,
    stimuli=SUB_BLOCK_STIMULI,
)
BLOCK_DOWNLOAD_BETWEEN = State(
    name="block-download-between",
    sentence="A sub-block of a download was acknowledged: the first segment of the next is due.",
    way=_block_download_between,
    downloads=True,
    least=TWO_SEGMENTS,
    segment=1,
    stimuli=NEXT_SUB_BLOCK_STIMULI,
    risk=LOST_SEGMENT,
)
BLOCK_DOWNLOAD_END = State(
    name="block-download-end",
    sentence="All sub-blocks of a download were acknowledged: its end is due.",
    way=_block_download(-1),
    downloads=True,
    short=True,
)

BLOCK_UPLOAD_INITIATED = State(
    name="block-upload-initiated",
    sentence="A block upload was initiated: its start is due.",
    way=_block_upload(0),
)
BLOCK_UPLOAD_BETWEEN = State(
    name="block-upload-between",
    sentence="A sub-block of an upload was sent, not the last: its acknowledgement is due.",
    way=_block_upload(1),
    least=TWO_SEGMENTS,
)
BLOCK_UPLOAD_SENT = State(
    name="block-upload-sent",
    sentence="The last sub-block of an upload was sent: its acknowledgement is due.",
    way=_block_upload(-2),
    least=TWO_SEGMENTS,
)
BLOCK_UPLOAD_END = State(
    name="block-upload-end",
    sentence="The end of a block upload was sent: its confirmation is due.",
    way=_block_upload(-1),
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
