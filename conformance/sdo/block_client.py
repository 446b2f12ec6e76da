"""Block transfers of the reference client (CiA 301, 7.2.4.3.8 to 7.2.4.3.15).

They are generators like those of the plain client, but not every step is one request and one
response: a Burst is several requests, or none, and one response or none.
"""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field

from conformance.sdo.client import Client, Uploaded
from conformance.sdo.crc import crc16
from conformance.sdo.decoding import as_answer, as_segment
from conformance.sdo.describe import describe, in_words
from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    Request,
    Response,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.rules import BLOCK_CRC, SIZE, UPLOAD_ENDS, Violation
from conformance.sdo.rules.block_details import NUMBERED_ANEW
from conformance.sdo.rules.block_upload import ENDS
from conformance.sdo.rules.defects import WRONG_COUNT
from conformance.sdo.seen import Received, Said, Seen, said
from conformance.sdo.unsent import Unsent

Mangle = Callable[[list[BlockSegment]], Sequence[BlockSegment]]


@dataclass(frozen=True, slots=True)
class Burst:
    """Requests to send without a pause, and whether a response has to come behind them.

    In a sub-block of the server it may be the first of so many ``segments``: those that have
    arrived right behind it may be put into ``more``. The others are asked for in further steps.
    """

    requests: tuple[Request, ...] = ()
    awaited: bool = True
    segments: int = 0
    more: list[Response] = field(default_factory=list, compare=False)


Step = Request | Burst


def as_it_is(segments: list[BlockSegment]) -> Sequence[BlockSegment]:
    """Send a sub-block as it is."""
    return segments


def all_of_it(received: int) -> int:
    """Acknowledge all segments that came."""
    return received


class BlockClient(Client):
    """A client with all three protocols."""

    def block_download(
        self,
        mux: Multiplexer,
        data: bytes,
        *,
        sized: bool = True,
        announced: int | None = None,
        crc: bool = True,
        mangle: Mangle = as_it_is,
    ) -> Generator[Step, Response, int]:
        """Write an object in blocks; returns the number of segments that were sent again.

        ``announced`` is the size to indicate instead of the true one.

        ``mangle`` is handed each sub-block and returns what is sent instead: fewer, repeated or
        reordered segments.
        """
        size = (len(data) if announced is None else announced) if sized else None
        answer = yield BlockDownloadInitiate.with_size(mux, size, crc_supported=crc)
        response = self.checks.block_download_initiate(answer, mux)
        unsent = Unsent(data, response.block_size)
        while not unsent.is_over:
            sub_block = unsent.sub_block()
            answer = yield Burst(tuple(mangle(sub_block)))
            unsent.acknowledged(self.checks.block_ack(answer, mux, len(sub_block)), sub_block)
        use_crc = crc and response.crc_supported
        answer = yield BlockEnd(unsent.unused, crc16(data) if use_crc else 0)
        self.checks.block_end_response(answer, mux)
        return unsent.repeated

    def block_upload(
        self,
        mux: Multiplexer,
        *,
        block_size: int = LARGEST_BLOCK,
        threshold: int = 0,
        crc: bool = True,
        acknowledge: Callable[[int], int] = all_of_it,
        next_block_size: Callable[[int], int] | None = None,
    ) -> Generator[Step, Response, Uploaded]:
        """Read an object in blocks, or as an ordinary upload where ``threshold`` (pst) allows it.

        ``acknowledge`` is handed the number of segments that came and returns how many of them
        to acknowledge; ``next_block_size`` changes the block size for the next sub-block.
        """
        answer = yield BlockUploadInitiate(mux, block_size, threshold, crc)
        if threshold and isinstance(as_answer(answer), UploadInitiateResponse):
            ordinary = self.checks.upload_initiate(answer, mux)
            if ordinary.expedited:
                return Uploaded(ordinary.data, counted=ordinary.sized)
            return (yield from self.upload_segments(mux, ordinary.size))
        response = self.checks.block_upload_initiate(answer, mux)
        data, segments, limit = bytearray(), 0, self.longest(mux)
        request: Request = BlockUploadStart()
        complete, sub_block, goes_on = False, list[BlockSegment](), 0
        while not complete:
            sub_block = yield from self._sub_block(
                request, mux, block_size, before=len(sub_block), goes_on=goes_on
            )
            taken = acknowledge(len(sub_block))
            for segment in sub_block[:taken]:
                data += segment.payload
            segments += taken
            complete = taken == len(sub_block) and sub_block[-1].last
            block_size = next_block_size(block_size) if next_block_size else block_size
            number = sub_block[0].sequence - 1 + taken
            goes_on = number if taken < len(sub_block) else 0
            request = BlockAck(number, block_size)
            if not complete:
                self._check_unfinished(len(data), response.size, limit, sub_block[-1])
        answer = yield request
        end = self.checks.block_end(answer, mux, bytes(data[-SEGMENT_LENGTH:]))
        whole = bytes(data)
        del data[len(data) - end.unused :]
        self._check_uploaded(bytes(data), response.size, end)
        due = crc16(bytes(data)) if crc and response.crc_supported else 0
        if end.crc != due:
            raise _wrong_end(whole, end, due, has_crc=crc and response.crc_supported)
        yield Burst((BlockEndResponse(),), awaited=False)
        return Uploaded(bytes(data), True, response.size, segments)

    def _sub_block(
        self, request: Request, mux: Multiplexer, block_size: int, *, before: int, goes_on: int
    ) -> Generator[Step, Response, list[BlockSegment]]:
        """Take a sub-block: a server may count on behind the number where the last one ``goes_on``.

        Then its numbers end at 127, and so does the sub-block.
        """
        step, segments = Burst((request,), segments=block_size), list[BlockSegment]()
        number = 1
        while True:
            answer = yield step
            for each in (answer, *step.more):
                if goes_on and not segments and _is_numbered(each, mux, goes_on + 1):
                    number += goes_on
                    actual = Received(as_segment(each, mux))
                    self.checks.note(
                        Violation(NUMBERED_ANEW, expected="block segment 1", actual=actual)
                    )
                segments.append(self.checks.block_segment(each, mux, number, before=before))
                number += 1
                before = 0
            full = len(segments) >= block_size or number > LARGEST_BLOCK
            if segments[-1].last or full:
                return segments
            step = Burst(segments=block_size - len(segments))

    def _check_unfinished(
        self, size: int, announced: int | None, limit: int, latest: BlockSegment
    ) -> None:
        """Hold what has come to what may come: behind the last byte there is less than a segment.

        That is done between two sub-blocks, when nothing more is on its way.
        """
        if announced is not None and size >= announced + SEGMENT_LENGTH:
            raise Violation(
                SIZE,
                expected=f"{announced} bytes, as announced",
                actual=Said(f"{size} bytes by {describe(latest)}", "… bytes by block segment"),
            )
        if size > limit:
            raise Violation(
                UPLOAD_ENDS,
                expected=f"a last segment within {limit} bytes",
                actual=said("{} bytes and none marked as last", size),
            )

    def _check_uploaded(self, data: bytes, announced: int | None, end: BlockEnd) -> None:
        if announced is not None and len(data) != announced:
            raise Violation(
                SIZE,
                expected=f"{announced} bytes, as announced",
                actual=Said(f"{len(data)} bytes by {in_words(end)}", "… bytes by block end"),
            )


def _is_numbered(answer: Response, mux: Multiplexer, number: int) -> bool:
    segment = as_segment(answer, mux)
    return isinstance(segment, BlockSegment) and segment.sequence == number


def wrong_count(expected: str, actual: Seen) -> Violation:
    """Describe an end whose n does not leave the bytes that the object has."""
    return Violation(ENDS, expected=expected, actual=actual, told_as=WRONG_COUNT)


def _wrong_end(segments: bytes, end: BlockEnd, due: int, *, has_crc: bool) -> Violation:
    """Describe a CRC that is not that of the data: it may be n that is wrong, and not the CRC."""
    for unused in range(SEGMENT_LENGTH + 1):
        counted = segments[: len(segments) - unused]
        if has_crc and unused != end.unused and crc16(counted) == end.crc:
            due_count = f"n = {unused}: the CRC is that of {len(counted)} bytes"
            return wrong_count(due_count, Received(end))
    return Violation(BLOCK_CRC, expected=f"CRC {due:04X}h", actual=Received(end))
