"""The bytes that cases write: harmless also where a server takes them for requests.

A server may abort a block download at any time, and what is on its way then reaches it when it is
idle. Segments numbered from 32 on begin like the initiate of a download (20h to 3Fh), the last one
of 64 to 95 like that of a block download (C0h to DFh). No segment before the 32nd of a transfer
ever has such a number, in whatever sub-blocks they are sent, and however often. From there on
each names, where an initiate has its multiplexer, an object that the device has not. A value of the
device's own that names one of its objects there does not go in blocks.
"""

import random
from collections.abc import Sequence

from conformance.device.device import Device
from conformance.device.not_testable import NotTestable
from conformance.sdo.frames import DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import SEGMENT_LENGTH

PRINTABLE = bytes(range(0x21, 0x7F))
# Up to there any text may stand in a segment.
MOST_PLAIN = 31 * SEGMENT_LENGTH
# What hardly any device has, and what is text as it stands in a request.
PRINTABLE_OBJECTS = (
    Multiplexer(0x7E7E, 0x2B),
    Multiplexer(0x5F7C, 0x62),
    Multiplexer(0x7D68, 0x55),
    Multiplexer(0x5B60, 0x3A),
)


def mux_bytes(mux: Multiplexer) -> bytes:
    """Return a multiplexer as it stands in a request."""
    return DownloadInitiate(mux).encode()[1:4]


def text(chosen: random.Random, size: int, heads: Sequence[Multiplexer]) -> bytes:
    """Return ``size`` printable bytes; ``heads`` are what segments behind the 31st may name.

    More than ``MOST_PLAIN`` bytes need one at least.
    """
    plain = bytes(chosen.choices(PRINTABLE, k=min(size, MOST_PLAIN)))
    if size <= MOST_PLAIN:
        return plain
    named = [mux_bytes(mux) for mux in heads]
    segments = -(-(size - MOST_PLAIN) // SEGMENT_LENGTH)
    rest = b"".join(
        chosen.choice(named) + bytes(chosen.choices(PRINTABLE, k=4)) for _ in range(segments)
    )
    return plain + rest[: size - MOST_PLAIN]


def named_by(payload: bytes) -> Multiplexer:
    """Return the object that a segment names to a server that takes it for an initiate."""
    whole = payload[:3].ljust(3, b"\0")
    return Multiplexer(int.from_bytes(whole[:2], "little"), whole[2])


def endangered(device: Device, data: bytes) -> Multiplexer | None:
    """Return an object of the device that the bytes name where a block download has 32 segments."""
    muxes = (
        named_by(data[start : start + 3]) for start in range(MOST_PLAIN, len(data), SEGMENT_LENGTH)
    )
    return next((mux for mux in muxes if device.would_lose(mux)), None)


def check_for_blocks(device: Device, data: bytes) -> None:
    """Raise NotTestable for what may be written elsewhere if the server ends a block download."""
    mux = endangered(device, data)
    if mux is not None:
        raise NotTestable(
            f"one of the segments of these {len(data)} bytes would be a write to {mux}, if the "
            "server ended a block download of them"
        )
