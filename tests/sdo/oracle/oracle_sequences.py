"""Generated conversations that lead through every state of a server, and disturb it there."""

from collections.abc import Iterator
from dataclasses import replace

from oracle_scripts import Disturbance, Noise, Transfer

from conformance.generated.variations import BLOCK_FRAMES, LONG_SIZES, UNKNOWN_SPECIFIERS
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadSegment,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer

TEXT, DOMAIN = Multiplexer(0x2010), Multiplexer(0x2011)
NUMBERS = {Multiplexer(0x2000 + length): length for length in (1, 2, 3, 4, 8)}
CONSTANTS = {
    Multiplexer(0x1000): 4,
    Multiplexer(0x1008): 28,
    Multiplexer(0x1009): 3,
    Multiplexer(0x1018, 0): 1,
    Multiplexer(0x1018, 1): 4,
    Multiplexer(0x1018, 2): 4,
    Multiplexer(0x1200, 1): 4,
}
WRITE_ONLY = Multiplexer(0x2020)
VENDOR_ID = Multiplexer(0x1018, 1)
MISSING = (
    Multiplexer(0x1FFF),
    Multiplexer(0x1018, 9),
    Multiplexer(0x1018, 0x81),
    Multiplexer(0x1000, 1),
    Multiplexer(0x2001, 1),
    Multiplexer(0x2010, 0xFE),
)
SIZES = (0, *range(1, 9), 13, 14, 15, 20, 21, 22, *LONG_SIZES, 448, 490, 672, 1777)
DOWNLOADS = ("segmented download", "block download")
UPLOADS = ("upload", "block upload")
KINDS = (*DOWNLOADS, *UPLOADS)


def payload(size: int, seed: int = 0) -> bytes:
    """Return bytes of which no two next to each other are the same, and none is 0."""
    return bytes(
        0x21 + (7 * position + position // 89 + 31 * seed) % 89 for position in range(size)
    )


def conversations() -> Iterator[list[Transfer]]:
    """Yield all of them, short ones first."""
    yield from _single_objects()
    yield from _sizes()
    yield from _histories()
    yield from _stimuli_when_idle()
    yield from _stimuli_in_transfers()
    yield from _changed_bits()
    yield from _lost_segments()
    yield from _pairs()
    yield from _numbers_kept()
    yield from _texts_read_at_once()
    yield from _thresholds()
    yield from _uploads_left()


def _read_back(mux: Multiplexer) -> list[Transfer]:
    return [Transfer("upload", mux), Transfer("upload", VENDOR_ID)]


def _single_objects() -> Iterator[list[Transfer]]:
    for mux in (*CONSTANTS, *NUMBERS, TEXT, DOMAIN, WRITE_ONLY, *MISSING):
        for kind in UPLOADS:
            yield [Transfer(kind, mux), *_read_back(mux)]
        for kind in (*DOWNLOADS, "expedited download"):
            for size in range(1, 10):
                data = payload(size)
                yield [Transfer(kind, mux, data), *_read_back(mux)]
                yield [Transfer(kind, mux, data, sized=False), *_read_back(mux)]
    for kind in DOWNLOADS:
        for announced in (0, 1, 7, 13, 15, 2**32 - 1):
            yield [Transfer(kind, TEXT, payload(14), announced=announced), *_read_back(TEXT)]
    for threshold in (*range(1, 30), 255):
        for size in (1, 4, 5, 13, 14, 28):
            yield [
                Transfer("segmented download", TEXT, payload(size)),
                Transfer("block upload", TEXT, threshold=threshold),
            ]
    for block_size in (0, 1, 127, 128, 255):
        yield [Transfer("block upload", TEXT, block_size=block_size), *_read_back(TEXT)]


def _sizes() -> Iterator[list[Transfer]]:
    for size in SIZES:
        for sized in (True, False):
            for crc in (True, False):
                yield [
                    Transfer("segmented download", TEXT, payload(size), sized=sized),
                    Transfer("upload", TEXT),
                    Transfer("block upload", TEXT, crc=crc),
                    Transfer("block download", TEXT, payload(size, 1), sized=sized, crc=crc),
                    Transfer("upload", TEXT),
                    Transfer("block upload", TEXT, crc=crc, block_size=3),
                ]


def _loose(frame: bytes) -> Transfer:
    return Transfer("loose frame", TEXT, frame)


def _histories() -> Iterator[list[Transfer]]:
    """Yield what servers remember of, or forget after, what was before."""
    numbers = [Transfer("upload", mux) for mux in NUMBERS]
    number, vendor = Multiplexer(0x2004), Transfer("upload", VENDOR_ID)
    values = [Transfer("expedited download", number, payload(4, seed)) for seed in (0, 1, 0, 2)]
    yield [*values[:3], *numbers, *values[2:], *numbers]
    for mux, length in NUMBERS.items():
        own = Transfer("upload", mux)
        right = Transfer("segmented download", mux, payload(length))
        for wrong in (payload(length + 1), payload(length - 1)):
            for kind in (*DOWNLOADS, "expedited download"):
                yield [Transfer(kind, mux, wrong), right, own, *numbers]
        unused = DownloadInitiate(mux, True, True, 3, b"\x5a\x5b\x5c\x5d").encode()
        uncounted = DownloadInitiate(mux, True, False, 3, b"\x5a\x5b\x5c\x5d").encode()
        yield [_loose(unused), own, _loose(uncounted), own]
    for size in (20, 30, 100):
        yield [Transfer("segmented download", TEXT, payload(size)), *_read_back(TEXT), *numbers]
        yield [Transfer("download with an empty last segment", TEXT, payload(size)), vendor]
    abort = _loose(Abort(VENDOR_ID, AbortCode.GENERAL_ERROR).encode())
    yield [values[0], abort, *numbers, abort, abort, abort, vendor]
    for request in (*UNKNOWN_SPECIFIERS.values(), Abort(TEXT, AbortCode.TIMED_OUT).encode()):
        yield [_loose(request), vendor]
    yield [Transfer("upload", MISSING[0])] * 40
    ended = (Disturbance(1, Noise.ABORTED),)
    for kind in KINDS:
        for sized in (True, False):
            aborted = Transfer(kind, TEXT, payload(20), sized=sized, disturbed=ended)
            yield [aborted] * 40 + [Transfer(kind, TEXT, payload(20)), *_read_back(TEXT)]
            yield [aborted, Transfer(kind, TEXT, payload(14), sized=sized), *_read_back(TEXT)]
            yield [aborted, *[vendor] * 30]
    refused = Transfer("segmented download", TEXT, payload(14), announced=7)
    yield [refused, Transfer("segmented download", TEXT, payload(30)), *_read_back(TEXT)]
    long = Transfer("segmented download", TEXT, payload(100))
    for first in (2, 3, 7):
        for later in (1, 2, 5, 9):
            for taken in (127, 1):
                upload = Transfer("block upload", TEXT, block_size=first, next_block_size=later)
                yield [long, replace(upload, taken=taken), vendor]


def stimuli(mux: Multiplexer) -> list[bytes]:
    """Return requests of all kinds, with variations."""
    messages = [
        *BLOCK_FRAMES.values(),
        *(UploadSegment(toggle) for toggle in (0, 1)),
        UploadSegment(0, reserved_bits=1),
        UploadSegment(0, reserved=b"\1" * 7),
        *(
            DownloadSegment.with_data(b"ABCDEFG", toggle=toggle, last=last)
            for toggle in (0, 1)
            for last in (False, True)
        ),
        *(
            Abort(named, AbortCode.GENERAL_ERROR, bits)
            for named in (mux, VENDOR_ID)
            for bits in (0, 1, 0x1F)
        ),
        *(UploadInitiate(named) for named in (mux, VENDOR_ID, MISSING[0])),
        UploadInitiate(VENDOR_ID, reserved_bits=1),
        UploadInitiate(VENDOR_ID, reserved=b"\1\2\3\4"),
        *(DownloadInitiate.with_size(named, 14) for named in (TEXT, VENDOR_ID)),
        *(DownloadInitiate.with_data(named, b"\1\2") for named in (Multiplexer(0x2002), TEXT)),
        *(BlockDownloadInitiate.with_size(named, 14) for named in (TEXT, VENDOR_ID)),
        *(BlockUploadInitiate(named, 127) for named in (mux, VENDOR_ID)),
        *(BlockAck(number, 127) for number in (0, 3, 4, 128, 255)),
        *(BlockAck(1, size) for size in (0, 128, 255)),
    ]
    changed = [bytes([command, *mux_bytes(VENDOR_ID), 0, 0, 0, 0]) for command in ODD_COMMANDS]
    return [*(message.encode() for message in messages), *UNKNOWN_SPECIFIERS.values(), *changed]


ODD_COMMANDS = (0x2E, 0x30, 0x33, 0x41, 0x5F, 0xA6, 0xBC, 0xC3, 0xC7, 0xDE)


SHORT_FRAMES = (
    UploadInitiate(VENDOR_ID),
    DownloadInitiate.with_data(Multiplexer(0x2004), b"\1\2\3\4"),
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


def mux_bytes(mux: Multiplexer) -> bytes:
    return UploadInitiate(mux).encode()[1:4]


def _stimuli_when_idle() -> Iterator[list[Transfer]]:
    for frame in stimuli(TEXT):
        for before in ([], [Transfer("segmented download", TEXT, payload(14))]):
            idle = Transfer("loose frame", TEXT, frame)
            yield [*before, idle, idle, *_read_back(TEXT)]
    for length in range(8):
        for short in SHORT_FRAMES:
            cut = (Disturbance(0, Noise.CUT, length=length),)
            loose = Transfer("loose frame", TEXT, short.encode(), disturbed=cut)
            yield [loose, *_read_back(TEXT), Transfer("upload", Multiplexer(0x2004))]
    for foreign in FOREIGN:
        yield [
            Transfer("upload", VENDOR_ID),
            Transfer("foreign frame", VENDOR_ID, foreign=foreign),
            Transfer("upload", VENDOR_ID),
        ]


def _stimuli_in_transfers() -> Iterator[list[Transfer]]:
    before = Transfer("segmented download", TEXT, payload(20, 2))
    for kind in KINDS:
        for position in range(1, 5):
            short_abort = Abort(TEXT, AbortCode.GENERAL_ERROR).encode()[:4]
            for frame in (*stimuli(TEXT), short_abort):
                disturbed = (Disturbance(position, Noise.PRECEDED, frame),)
                yield [
                    before,
                    Transfer(kind, TEXT, payload(20), block_size=2, disturbed=disturbed),
                    *_read_back(TEXT),
                ]
            for noise in (Noise.ABORTED, Noise.SILENCE, Noise.TWICE, Noise.CUT):
                disturbed = (Disturbance(position, noise),)
                yield [
                    before,
                    Transfer(kind, TEXT, payload(20), block_size=2, disturbed=disturbed),
                    Transfer(kind, TEXT, payload(20, 1)),
                    *_read_back(TEXT),
                ]
            for byte, bit in (
                *((0, bit) for bit in range(8)),
                *((byte, 0) for byte in range(1, 8)),
            ):
                mask = bytes(1 << bit if place == byte else 0 for place in range(8))
                disturbed = (Disturbance(position, Noise.CHANGED, mask),)
                yield [
                    before,
                    Transfer(kind, TEXT, payload(20), block_size=2, disturbed=disturbed),
                    *_read_back(TEXT),
                ]


def _changed_bits() -> Iterator[list[Transfer]]:
    for kind in KINDS:
        for position in range(6):
            for byte, bit in (
                *((0, bit) for bit in range(8)),
                *((byte, 0) for byte in range(1, 8)),
            ):
                mask = bytes(1 << bit if place == byte else 0 for place in range(8))
                disturbed = (Disturbance(position, Noise.CHANGED, mask),)
                for plain in (True, False):
                    changed = Transfer(
                        kind,
                        TEXT,
                        payload(20),
                        sized=plain,
                        crc=plain,
                        block_size=2,
                        disturbed=disturbed,
                    )
                    yield [changed, *_read_back(TEXT)]


def _lost_segments() -> Iterator[list[Transfer]]:
    for size in (13, 20, 35, 100):
        for position in range(1, 8):
            for crc in (True, False):
                lost = (Disturbance(position, Noise.LOST),)
                yield [
                    Transfer("block download", TEXT, payload(size), crc=crc, disturbed=lost),
                    *_read_back(TEXT),
                ]
                twice = (*lost, Disturbance(position + size // 7, Noise.LOST))
                yield [
                    Transfer("block download", TEXT, payload(size), crc=crc, disturbed=twice),
                    *_read_back(TEXT),
                ]
        for taken in range(4):
            for block_size in (2, 3, 4, 127):
                yield [
                    Transfer("segmented download", TEXT, payload(size)),
                    Transfer("block upload", TEXT, taken=taken, block_size=block_size),
                    Transfer("block upload", TEXT),
                ]


def _pairs() -> Iterator[list[Transfer]]:
    for first in KINDS:
        for second in KINDS:
            for sizes in ((30, 3), (3, 30), (14, 14), (30, 8)):
                for sized in (True, False):
                    for cut in ((), (Disturbance(2, Noise.ABORTED),)):
                        yield [
                            Transfer("segmented download", TEXT, payload(sizes[0])),
                            Transfer(first, TEXT, payload(sizes[0], 1), disturbed=cut),
                            Transfer(second, TEXT, payload(sizes[1], 2), sized=sized),
                            *(Transfer(kind, TEXT) for kind in UPLOADS),
                            Transfer(second, DOMAIN, payload(sizes[1], 3), sized=sized),
                            *(Transfer(kind, DOMAIN) for kind in UPLOADS),
                            Transfer("upload", Multiplexer(0x1009)),
                        ]


def _numbers_kept() -> Iterator[list[Transfer]]:
    """Yield downloads to numbers that do not get to their end: a string may keep a part of one."""
    for mux in (Multiplexer(0x2004), Multiplexer(0x2008)):
        own, length = Transfer("upload", mux), NUMBERS[mux]
        end = -(-length // 7) + 1
        for kind in DOWNLOADS:
            for position in range(1, end + 1):
                for broken in (
                    Disturbance(position, Noise.ABORTED),
                    Disturbance(position, Noise.REPLACED, UploadInitiate(VENDOR_ID).encode()),
                    Disturbance(
                        position, Noise.REPLACED, DownloadInitiate.with_size(TEXT, 14).encode()
                    ),
                ):
                    yield [Transfer(kind, mux, payload(length), disturbed=(broken,)), own]
        for byte in (1, 2):
            wrong = (Disturbance(end, Noise.CHANGED, bytes(byte) + b"\1" + bytes(7 - byte)),)
            yield [Transfer("block download", mux, payload(length), disturbed=wrong), own]
        written = Transfer("expedited download", mux, payload(4))
        yield [written, _loose(Abort(mux, AbortCode.GENERAL_ERROR).encode()), own]


def _texts_read_at_once() -> Iterator[list[Transfer]]:
    """Yield downloads that are disturbed, or without data, and what is there right behind them."""
    for position in range(1, 4):
        for noise in (Noise.TWICE, Noise.SILENCE):
            disturbed = (Disturbance(position, noise),)
            for kind in DOWNLOADS:
                yield [Transfer(kind, TEXT, payload(20), disturbed=disturbed), *_read_back(TEXT)]
    refused = Transfer("segmented download", TEXT, payload(14), announced=20)
    yield [refused, Transfer("segmented download", TEXT, payload(30, 1)), *_read_back(TEXT)]
    for kind in DOWNLOADS:  # zeros at the end of a text are none of it
        yield [Transfer(kind, DOMAIN), *(Transfer(upload, DOMAIN) for upload in UPLOADS)]


def _thresholds() -> Iterator[list[Transfer]]:
    """Yield block uploads of what is longer than pst allows to send otherwise."""
    for block_size in (0, 2, 127):
        for threshold in (1, 20, 255):
            for size in (30, 100):
                text = Transfer("segmented download", TEXT, payload(size))
                upload = Transfer("block upload", TEXT, block_size=block_size)
                yield [text, replace(upload, threshold=threshold), *_read_back(TEXT)]


def _uploads_left() -> Iterator[list[Transfer]]:
    """Yield uploads that the client aborts or leaves, and begins again."""
    text = Transfer("segmented download", TEXT, payload(20))
    aborted = Transfer("upload", TEXT, disturbed=(Disturbance(1, Noise.ABORTED),))
    yield [text, *[aborted] * 40, Transfer("upload", TEXT)]
    abort = Abort(TEXT, AbortCode.GENERAL_ERROR).encode()
    left = Transfer("upload", TEXT, disturbed=(Disturbance(1, Noise.REPLACED, abort),))
    for mux in (VENDOR_ID, Multiplexer(0x1000)):
        yield [text, left, *[Transfer("upload", mux)] * 3]
    idle = _loose(Abort(VENDOR_ID, AbortCode.GENERAL_ERROR).encode())
    yield [idle, *[Transfer("upload", Multiplexer(0x1000))] * 3]
    for size, taken in ((20, 127), (100, 1), (100, 127)):
        text = Transfer("segmented download", TEXT, payload(size))
        upload = Transfer("block upload", TEXT, block_size=3, taken=taken)
        for position in range(2, 7):
            vanished = tuple(Disturbance(later, Noise.LOST) for later in range(position, 40))
            yield [text, replace(upload, disturbed=vanished), Transfer("block upload", TEXT)]
            for code in (AbortCode.CRC_ERROR, AbortCode.GENERAL_ERROR):
                ended = (Disturbance(position, Noise.REPLACED, Abort(TEXT, code).encode()),)
                yield [text, replace(upload, disturbed=ended), Transfer("block upload", TEXT)]
