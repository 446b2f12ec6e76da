"""Conversations of a client, near to valid ones: whole transfers on a noisy line, and loose frames.

A script is a value, so that hypothesis can shrink it; ``play`` performs it against a server.
"""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from enum import StrEnum

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.crc import crc16
from conformance.sdo.decoding import decode_response, decode_segment
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer

SEGMENT = 7
# A server that never comes to an end must not keep a script from it.
MOST_REQUESTS = 1000

Answers = list[bytes]
Requests = Generator[bytes, Answers, None]
Exchange = Callable[[bytes | CanFrame], Answers]


class Noise(StrEnum):
    """What may happen to a request on its way."""

    LOST = "lost"
    TWICE = "twice"
    CHANGED = "changed"
    CUT = "cut"
    REPLACED = "replaced"
    PRECEDED = "preceded"
    ABORTED = "aborted"
    SILENCE = "silence"


@dataclass(frozen=True)
class Disturbance:
    """Something happens to the request at a position: ``frame`` or ``mask`` say what."""

    position: int
    noise: Noise
    frame: bytes = bytes(8)
    length: int = 7


@dataclass(frozen=True)
class Transfer:
    """A whole transfer: ``kind`` is one of ``KINDS``; ``disturbed`` says what goes wrong.

    ``foreign`` is sent instead of a transfer: a CAN frame that is none of the channel's requests.
    """

    kind: str
    mux: Multiplexer
    data: bytes = b""
    sized: bool = True
    announced: int | None = None
    crc: bool = True
    block_size: int = 127
    next_block_size: int | None = None
    threshold: int = 0
    taken: int = 127
    disturbed: tuple[Disturbance, ...] = ()
    foreign: CanFrame | None = None


Script = Sequence[Transfer]


def play(script: Script, send: Exchange, wait: Callable[[], object]) -> None:
    """Perform a script: ``send`` returns the responses to a request."""
    for transfer in script:
        _perform(transfer, send, wait)


def _perform(transfer: Transfer, send: Exchange, wait: Callable[[], object]) -> None:
    if transfer.foreign is not None:
        send(transfer.foreign)
        return
    requests = KINDS[transfer.kind](transfer)
    request = next(requests)
    for position in range(MOST_REQUESTS):
        answers: Answers = []
        for frame in _disturbed(request, transfer, position, wait):
            answers += send(frame)
        try:
            request = requests.send(answers)
        except StopIteration:
            return


def _disturbed(
    request: bytes, transfer: Transfer, position: int, wait: Callable[[], object]
) -> list[bytes]:
    frames = [request]
    for disturbance in transfer.disturbed:
        if disturbance.position != position:
            continue
        match disturbance.noise:
            case Noise.LOST:
                frames = []
            case Noise.TWICE:
                frames = [request, request]
            case Noise.CHANGED:
                changed = bytes(a ^ b for a, b in zip(request, disturbance.frame, strict=True))
                frames = [changed]
            case Noise.CUT:
                frames = [request[: disturbance.length]]
            case Noise.REPLACED:
                frames = [disturbance.frame]
            case Noise.PRECEDED:
                frames = [disturbance.frame, request]
            case Noise.ABORTED:
                frames = [request, Abort(transfer.mux, AbortCode.GENERAL_ERROR).encode()]
            case Noise.SILENCE:
                wait()
    return frames


# Each of these yields requests and is sent the responses to them; it goes on while it can.


def expedited_download(transfer: Transfer) -> Requests:
    make = DownloadInitiate.with_data if transfer.sized else DownloadInitiate.with_uncounted_data
    yield make(transfer.mux, transfer.data[:4] or b"\0").encode()


def segmented_download(transfer: Transfer) -> Requests:
    answers = yield DownloadInitiate.with_size(transfer.mux, _size(transfer)).encode()
    if not _has(answers, DownloadInitiateResponse):
        return
    toggle = 0
    chunks = chunks_of(transfer.data)
    for number, chunk in enumerate(chunks):
        last = number == len(chunks) - 1
        answers = yield DownloadSegment.with_data(chunk, toggle=toggle, last=last).encode()
        if not _has(answers, DownloadSegmentResponse):
            return
        toggle ^= 1


def download_with_empty_last(transfer: Transfer) -> Requests:
    """Send all data in segments that are not the last, and then an empty one."""
    answers = yield DownloadInitiate.with_size(transfer.mux, _size(transfer)).encode()
    toggle = 0
    for chunk in [*chunks_of(transfer.data), b""]:
        if not answers or _has(answers, Abort):
            return
        segment = DownloadSegment.with_data(chunk, toggle=toggle, last=not chunk)
        answers = yield segment.encode()
        toggle ^= 1


def upload(transfer: Transfer) -> Requests:
    answers = yield UploadInitiate(transfer.mux).encode()
    yield from _segments(answers)


def _segments(answers: Answers) -> Requests:
    initiated = [decode_response(answer) for answer in answers]
    if not any(isinstance(one, UploadInitiateResponse) and not one.expedited for one in initiated):
        return
    toggle, going = 0, True
    while going:
        answers = yield UploadSegment(toggle).encode()
        segments = [decode_response(answer) for answer in answers]
        going = any(isinstance(one, UploadSegmentResponse) and not one.last for one in segments)
        toggle ^= 1


def block_download(transfer: Transfer) -> Requests:
    request = BlockDownloadInitiate.with_size(
        transfer.mux, _size(transfer), crc_supported=transfer.crc
    )
    answers = yield request.encode()
    initiated = [decode_response(answer) for answer in answers]
    found = [one for one in initiated if isinstance(one, BlockDownloadInitiateResponse)]
    if not found:
        return
    chunks, done, block_size = chunks_of(transfer.data), 0, found[0].block_size
    while done < len(chunks):
        sub_block = chunks[done : done + max(block_size, 1)]
        acks: list[BlockAck] = []
        for number, chunk in enumerate(sub_block):
            last = done + number + 1 == len(chunks)
            answers = yield BlockSegment.with_data(number + 1, chunk, last=last).encode()
            decoded = [decode_response(answer) for answer in answers]
            if any(isinstance(one, Abort) for one in decoded):
                return
            acks += [one for one in decoded if isinstance(one, BlockAck)]
        if not acks:
            return
        done += acks[-1].sequence
        block_size = acks[-1].block_size
    use_crc = transfer.crc and found[0].crc_supported
    crc = crc16(transfer.data) if use_crc else 0
    yield BlockEnd(len(chunks) * SEGMENT - len(transfer.data), crc).encode()


def block_upload(transfer: Transfer) -> Requests:
    initiate = BlockUploadInitiate(
        transfer.mux, transfer.block_size, transfer.threshold, transfer.crc
    )
    answers = yield initiate.encode()
    if _has(answers, UploadInitiateResponse):
        yield from _segments(answers)
        return
    if not _has(answers, BlockUploadInitiateResponse):
        return
    answers = yield BlockUploadStart().encode()
    losses = 3
    while True:
        segments = [decode_segment(answer) for answer in answers]
        numbers = [one.sequence for one in segments if isinstance(one, BlockSegment)]
        if not numbers or _has(answers, BlockEnd):
            break
        taken = min(numbers[-1], transfer.taken) if losses else numbers[-1]
        losses -= losses and taken < numbers[-1]
        block_size = transfer.next_block_size or transfer.block_size
        answers = yield BlockAck(taken, block_size).encode()
        if len(answers) == 1 and _has(answers, BlockEnd) and taken == numbers[-1]:
            break
    yield BlockEndResponse().encode()


def loose_frame(transfer: Transfer) -> Requests:
    """Send eight bytes whatever they are: the data."""
    yield transfer.data[:8].ljust(8, b"\0")


KINDS: dict[str, Callable[[Transfer], Requests]] = {
    "expedited download": expedited_download,
    "segmented download": segmented_download,
    "download with an empty last segment": download_with_empty_last,
    "upload": upload,
    "block download": block_download,
    "block upload": block_upload,
    "loose frame": loose_frame,
}


def chunks_of(data: bytes) -> list[bytes]:
    """Split data into those of the segments; at least one."""
    return [data[start : start + SEGMENT] for start in range(0, max(len(data), 1), SEGMENT)]


def _size(transfer: Transfer) -> int | None:
    if not transfer.sized:
        return None
    return len(transfer.data) if transfer.announced is None else transfer.announced


def _has(answers: Answers, kind: type) -> bool:
    return any(isinstance(decode_response(answer), kind) for answer in answers)
