"""The bytes that cases write: harmless also where a server takes them for requests.

A server may abort a block download at any time, and what is on its way then reaches it when it is
idle. Segments numbered from 32 on begin like the initiate of a download (20h to 3Fh), the last one
of 64 to 95 like that of a block download (C0h to DFh). No segment before the 32nd of a transfer
ever has such a number, in whatever sub-blocks they are sent, and however often. From there on
each names, where an initiate has its multiplexer, an object that the device has not.
"""

import random
from collections.abc import Sequence

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
