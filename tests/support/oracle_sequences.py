"""Generated scripts that lead through every state of a server, and disturb it there.

A script is what a client does: transfers, which may be disturbed, single frames, and silences that
are longer than the server's time-out.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from enum import Enum

from conformance.model_cases.conversations.conversation import Disturbance, Event, Service, Transfer
from conformance.model_cases.conversations.disturbed_client import FRAMES
from conformance.model_cases.matrix.stimuli import STIMULI
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadSegment,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import Message, Multiplexer
from support.oracle_objects import (
    CONSTANTS,
    DOMAIN,
    MISSING,
    NODE_ID,
    NUMBERS,
    TARGETS,
    TEXT,
    VENDOR_ID,
    WRITE_ONLY,
)


class Silence(Enum):
    """A pause of the client until the server gives up."""

    TIME_OUT = "time-out"


Step = Transfer | CanFrame | Silence
Script = Sequence[Step]

NUMBER = Multiplexer(0x2004)
EDGES = (255, 256, 257, 888, 889, 890, 4097)
SIZES = (0, *range(1, 9), 13, 14, 15, 20, 21, 22, *EDGES, 448, 490, 672, 1777)
DOWNLOADS = (Service.DOWNLOAD, Service.BLOCK_DOWNLOAD)
UPLOADS = (Service.UPLOAD, Service.BLOCK_UPLOAD)
SERVICES = (*DOWNLOADS, *UPLOADS)
VENDOR = Transfer(Service.UPLOAD, VENDOR_ID)
# Single bits of a request, in byte 0 all of them: the byte, and the mask.
BITS = (*((0, 1 << bit) for bit in range(8)), *((byte, 1) for byte in range(1, 8)))
LATE_REQUESTS = ("00h", "10h", "60h", "70h", "segment-2", "A2h-ackseq-2", "A3h", "C1h-crc-0")


def scripts() -> Iterator[Script]:
    """Yield all of them, short ones first."""
    yield from _single_objects()
    yield from _sizes()
    yield from _memories()
    yield from _frames_when_idle()
    yield from _frames_in_transfers()
    yield from _changed_bits()
    yield from _lost_segments()
    yield from _pairs()
    yield from _unfinished_numbers()
    yield from _texts_read_at_once()
    yield from _thresholds()
    yield from _unfinished_uploads()
    yield from _superseded()
    yield from _lost_later()


def frame(message: Message | bytes) -> CanFrame:
    """Return a request to the node."""
    data = message if isinstance(message, bytes) else message.encode()
    return CanFrame(0x600 + NODE_ID, data)


def abort(mux: Multiplexer, code: AbortCode = AbortCode.GENERAL_ERROR) -> CanFrame:
    return frame(Abort(mux, code))


def stored(size: int, content: int = 0, mux: Multiplexer = TEXT) -> Transfer:
    """Return a download that ought to succeed."""
    return Transfer(Service.DOWNLOAD, mux, size, content)


def disturbed(transfer: Transfer, *disturbances: Disturbance) -> Transfer:
    return replace(transfer, disturbances=disturbances)


def left(transfer: Transfer, at: int) -> Transfer:
    """Return a transfer with which the client does not go on, from one of its requests on."""
    return disturbed(transfer, Disturbance(at, Event.LEAVE))


def announcing(transfer: Transfer, size: int) -> Transfer:
    """Return a download whose initiate announces a size that is not its own."""
    wrong = (transfer.size ^ size).to_bytes(4, "little")
    return disturbed(
        transfer,
        *(Disturbance(0, Event.ALTER, byte, mask) for byte, mask in enumerate(wrong, 4) if mask),
    )


def short_transfer(service: Service, content: int = 0) -> Transfer:
    """Return a transfer of 20 bytes, in sub-blocks of two segments where they are uploaded."""
    size = 20 if service in DOWNLOADS else 0
    return Transfer(service, TEXT, size, content, block_sizes=(2,))


def _read(mux: Multiplexer) -> Transfer:
    return Transfer(Service.UPLOAD, mux)


def _read_back(mux: Multiplexer) -> Script:
    return (_read(mux), VENDOR)


def _single_objects() -> Iterator[Script]:
    for mux in (*CONSTANTS, *NUMBERS, TEXT, DOMAIN, WRITE_ONLY, *MISSING):
        for service in UPLOADS:
            yield (Transfer(service, mux), *_read_back(mux))
        for service in (*DOWNLOADS, Service.EXPEDITED):
            for size in range(1, 5 if service is Service.EXPEDITED else 10):
                for sized in (True, False):
                    yield (Transfer(service, mux, size, sized=sized), *_read_back(mux))
    for service in DOWNLOADS:
        for announced in (0, 1, 7, 13, 15, 2**32 - 1):
            yield (announcing(Transfer(service, TEXT, 14), announced), *_read_back(TEXT))
    for threshold in (*range(1, 30), 255):
        for size in (1, 4, 5, 13, 14, 28):
            yield (stored(size), Transfer(Service.BLOCK_UPLOAD, TEXT, threshold=threshold))
    for block_size in (0, 1, 127, 128, 255):
        upload = Transfer(Service.BLOCK_UPLOAD, TEXT, block_sizes=(block_size,))
        yield (upload, *_read_back(TEXT))


def _sizes() -> Iterator[Script]:
    for size in SIZES:
        for sized in (True, False):
            for crc in (True, False):
                yield (
                    replace(stored(size), sized=sized),
                    _read(TEXT),
                    Transfer(Service.BLOCK_UPLOAD, TEXT, crc=crc),
                    Transfer(Service.BLOCK_DOWNLOAD, TEXT, size, 1, sized=sized, crc=crc),
                    _read(TEXT),
                    Transfer(Service.BLOCK_UPLOAD, TEXT, crc=crc, block_sizes=(3,)),
                )


def _memories() -> Iterator[Script]:
    """Yield what servers remember of, or forget after, what was before."""
    numbers = [_read(mux) for mux in NUMBERS]
    values = [Transfer(Service.EXPEDITED, NUMBER, 4, content) for content in (0, 1, 0, 2)]
    yield (*values[:3], *numbers, *values[2:], *numbers)
    for mux, length in NUMBERS.items():
        for wrong in (length + 1, length - 1):
            for service in (*DOWNLOADS, Service.EXPEDITED):
                if wrong:
                    yield (Transfer(service, mux, wrong), stored(length, 0, mux), *numbers)
            yield (*_empty(mux), stored(length, 0, mux), *numbers)
        for size_indicated in (True, False):
            unused = DownloadInitiate(mux, True, size_indicated, 3, b"\x5a\x5b\x5c\x5d")
            yield (frame(unused), _read(mux))
    for size in (20, 30, 100):
        yield (stored(size), *_read_back(TEXT), *numbers)
        yield (*_ending_empty(size), VENDOR)
    idle = abort(VENDOR_ID)
    yield (values[0], idle, *numbers, idle, idle, idle, VENDOR)
    for label in ("E0h", "E1h", "F0h", "FFh", "80h"):
        yield (FRAMES[label](TARGETS), VENDOR)
    yield [_read(MISSING[0])] * 40
    for service in SERVICES:
        for sized in (True, False):
            whole = replace(short_transfer(service), sized=sized)
            aborted = (left(whole, 2), abort(TEXT))
            yield (*aborted * 40, whole, *_read_back(TEXT))
            yield (*aborted, Transfer(service, TEXT, 14, sized=sized), *_read_back(TEXT))
            yield (*aborted, *[VENDOR] * 30)
    yield (announcing(stored(14), 7), stored(30), *_read_back(TEXT))
    for first in (2, 3, 7):
        for later in (1, 2, 5, 9):
            for withheld in ((), (first - 1, later - 1, later - 1)):
                upload = Transfer(Service.BLOCK_UPLOAD, TEXT, withheld=withheld)
                yield (stored(100), replace(upload, block_sizes=(first, later)), VENDOR)


def _empty(mux: Multiplexer) -> Script:
    """Return a segmented download of no bytes, to an object that need not take it."""
    return (
        frame(DownloadInitiate.with_size(mux, 0)),
        frame(DownloadSegment.with_data(b"", toggle=0, last=True)),
    )


def _ending_empty(size: int) -> Script:
    """Return a segmented download whose last segment has no data."""
    segments = -(-size // 7)
    not_last = Disturbance(segments, Event.ALTER, mask=1)
    empty = DownloadSegment.with_data(b"", toggle=segments % 2, last=True)
    return (disturbed(stored(size), not_last), frame(empty))


SHORT_FRAMES = (
    UploadInitiate(VENDOR_ID),
    DownloadInitiate.with_data(NUMBER, b"\1\2\3\4"),
    DownloadInitiate.with_data(Multiplexer(0x2002), b"\1\2"),
    DownloadInitiate.with_data(Multiplexer(0x2001), b"\1"),
    DownloadInitiate.with_size(TEXT, 14),
    BlockUploadInitiate(VENDOR_ID, 127),
    BlockDownloadInitiate.with_size(TEXT, 14),
    Abort(VENDOR_ID, AbortCode.GENERAL_ERROR),
    UploadSegment(0),
    DownloadSegment.with_data(b"ABCDEFG", toggle=0),
)
READ = UploadInitiate(VENDOR_ID).encode()
# What is no request to the node: other identifiers, another format, remote frames.
FOREIGN = (
    CanFrame(0x605, READ, extended=True),
    CanFrame(0x605, remote=True),
    CanFrame(0x605, remote=True, length=8),
    *(CanFrame(can_id, READ) for can_id in (0x585, 0x600, 0x601, 0x604, 0x606, 0x615, 0x645)),
    CanFrame(0x000, b"\0\0"),
)


def _frames_when_idle() -> Iterator[Script]:
    for stimulus in STIMULI.values():
        for before in ((), (stored(14),)):
            yield (*before, stimulus(TARGETS), stimulus(TARGETS), *_read_back(TEXT))
    for length in range(8):
        for short in SHORT_FRAMES:
            yield (frame(short.encode()[:length]), *_read_back(TEXT), _read(NUMBER))
    for foreign in FOREIGN:
        yield (VENDOR, foreign, VENDOR)


def _frames_in_transfers() -> Iterator[Script]:
    before = stored(20, 2)
    for service in SERVICES:
        whole = short_transfer(service)
        for position in range(1, 5):
            for label in FRAMES:
                inserted = Disturbance(position, Event.INSERT, label=label)
                yield (before, disturbed(whole, inserted), *_read_back(TEXT))
            again = (short_transfer(service, 1), *_read_back(TEXT))
            yield (before, left(whole, position + 1), abort(TEXT), *again)
            for event in (Event.REPEAT, Event.CUT):
                yield (before, disturbed(whole, Disturbance(position, event, 7)), *again)
            for byte, mask in BITS:
                altered = Disturbance(position, Event.ALTER, byte, mask)
                yield (before, disturbed(whole, altered), *_read_back(TEXT))
            for label in LATE_REQUESTS:
                late = FRAMES[label](TARGETS)
                yield (before, left(whole, position), Silence.TIME_OUT, late, *again)


def _changed_bits() -> Iterator[Script]:
    for service in SERVICES:
        for position in range(6):
            for byte, mask in BITS:
                altered = Disturbance(position, Event.ALTER, byte, mask)
                for plain in (True, False):
                    whole = replace(short_transfer(service), sized=plain, crc=plain)
                    yield (disturbed(whole, altered), *_read_back(TEXT))


def _lost_segments() -> Iterator[Script]:
    for size in (13, 20, 35, 100):
        for position in range(1, 8):
            for crc in (True, False):
                lost = Disturbance(position, Event.LOSE)
                again = Disturbance(position + size // 7, Event.LOSE)
                for losses in ((lost,), (lost, again)):
                    download = Transfer(Service.BLOCK_DOWNLOAD, TEXT, size, crc=crc)
                    yield (disturbed(download, *losses), *_read_back(TEXT))
        for taken in range(4):
            for block_size in (2, 3, 4, 127):
                withheld = (max(block_size - taken, 0),) * 3
                upload = Transfer(Service.BLOCK_UPLOAD, TEXT, block_sizes=(block_size,))
                yield (
                    stored(size),
                    replace(upload, withheld=withheld),
                    Transfer(Service.BLOCK_UPLOAD, TEXT),
                )


def _pairs() -> Iterator[Script]:
    for first in SERVICES:
        for second in SERVICES:
            for before, after in ((30, 3), (3, 30), (14, 14), (30, 8)):
                for sized in (True, False):
                    begun = Transfer(first, TEXT, before if first in DOWNLOADS else 0, 1)
                    size = after if second in DOWNLOADS else 0
                    for whole in ((begun,), (left(begun, 3), abort(TEXT))):
                        yield (
                            stored(before),
                            *whole,
                            Transfer(second, TEXT, size, 2, sized=sized),
                            *(Transfer(service, TEXT) for service in UPLOADS),
                            Transfer(second, DOMAIN, size, 3, sized=sized),
                            *(Transfer(service, DOMAIN) for service in UPLOADS),
                            _read(Multiplexer(0x1009)),
                        )


def _unfinished_numbers() -> Iterator[Script]:
    """Yield downloads to numbers that do not get to their end: a string may keep a part of one."""
    for mux in (NUMBER, Multiplexer(0x2008)):
        length = NUMBERS[mux]
        end = -(-length // 7) + 1
        for service in DOWNLOADS:
            for position in range(1, end + 2):
                for ended in (abort(mux), frame(READ), frame(DownloadInitiate.with_size(TEXT, 14))):
                    begun = left(Transfer(service, mux, length), position)
                    yield (begun, ended, _read(mux))
        for byte in (1, 2):
            wrong = Disturbance(end, Event.ALTER, byte, 1)
            yield (disturbed(Transfer(Service.BLOCK_DOWNLOAD, mux, length), wrong), _read(mux))
        yield (Transfer(Service.EXPEDITED, mux, 4), abort(mux), _read(mux))


def _texts_read_at_once() -> Iterator[Script]:
    """Yield downloads that are disturbed, or without data, and what is there right behind them."""
    for service in DOWNLOADS:
        whole = short_transfer(service)
        for position in range(1, 4):
            repeated = Disturbance(position, Event.REPEAT)
            yield (disturbed(whole, repeated), *_read_back(TEXT))
            yield (left(whole, position), Silence.TIME_OUT, *_read_back(TEXT))
        # Zeros at the end of a text are none of it.
        yield (Transfer(service, DOMAIN), *(Transfer(upload, DOMAIN) for upload in UPLOADS))
    yield (announcing(stored(14), 20), stored(30, 1), *_read_back(TEXT))


def _thresholds() -> Iterator[Script]:
    """Yield block uploads of what is longer than pst allows to send otherwise."""
    for block_size in (0, 2, 127):
        for threshold in (1, 20, 255):
            for size in (30, 100):
                upload = Transfer(Service.BLOCK_UPLOAD, TEXT, block_sizes=(block_size,))
                yield (stored(size), replace(upload, threshold=threshold), *_read_back(TEXT))


def _unfinished_uploads() -> Iterator[Script]:
    """Yield uploads that the client aborts or leaves, and begins again."""
    aborted = (left(_read(TEXT), 2), abort(TEXT))
    yield (stored(20), *aborted * 40, _read(TEXT))
    device_type = _read(Multiplexer(0x1000))
    for again in (VENDOR, device_type):
        yield (stored(20), left(_read(TEXT), 1), abort(TEXT), *[again] * 3)
    yield (abort(VENDOR_ID), *[device_type] * 3)
    for size, withheld in ((20, ()), (100, (2, 2, 2)), (100, ())):
        upload = Transfer(Service.BLOCK_UPLOAD, TEXT, block_sizes=(3,), withheld=withheld)
        for position in range(2, 7):
            vanished = left(upload, position)
            yield (stored(size), vanished, Transfer(Service.BLOCK_UPLOAD, TEXT))
            for code in (AbortCode.CRC_ERROR, AbortCode.GENERAL_ERROR):
                again = Transfer(Service.BLOCK_UPLOAD, TEXT)
                yield (stored(size), vanished, abort(TEXT, code), again)


def _superseded() -> Iterator[Script]:
    """Yield transfers that another ends, which goes on to its own end."""
    for first in (Service.DOWNLOAD, *UPLOADS):
        for position in range(1, 4):
            for second in SERVICES:
                begun = left(short_transfer(first), position)
                yield (stored(20), begun, short_transfer(second, 1), _read(TEXT))


def _lost_later() -> Iterator[Script]:
    """Yield block downloads in which a segment of the second sub-block gets lost."""
    for position in (128, 129):
        lost = Disturbance(position, Event.LOSE)
        yield (disturbed(Transfer(Service.BLOCK_DOWNLOAD, TEXT, 920), lost), *_read_back(TEXT))
