"""The objects of the reference server that generated conversations are about."""

from collections.abc import Mapping, Sequence

from conformance.model_cases.conversations.conversation import Transfer
from conformance.model_cases.matrix.stimuli import Targets
from conformance.sdo.layout import Multiplexer

NODE_ID = 5
TEXT, DOMAIN = Multiplexer(0x2010), Multiplexer(0x2011)
NUMBERS = {Multiplexer(0x2000 + length): length for length in (1, 2, 3, 4, 8)}
VENDOR_ID = Multiplexer(0x1018, 1)
CONSTANTS = (
    Multiplexer(0x1000),
    Multiplexer(0x1008),
    Multiplexer(0x1009),
    Multiplexer(0x1018, 0),
    VENDOR_ID,
    Multiplexer(0x1018, 2),
    Multiplexer(0x1200, 1),
)
WRITE_ONLY = Multiplexer(0x2020)
MISSING = (
    Multiplexer(0x1FFF),
    Multiplexer(0x1018, 9),
    Multiplexer(0x1018, 0x81),
    Multiplexer(0x1000, 1),
    Multiplexer(0x2001, 1),
    Multiplexer(0x2010, 0xFE),
)
TARGETS = Targets(NODE_ID, TEXT, MISSING[0], MISSING[1], bytes.fromhex("91010F00"))


def payload(size: int, seed: int = 0) -> bytes:
    """Return bytes of which no two next to each other are the same, and none is 0."""
    return bytes(
        0x21 + (7 * position + position // 89 + 31 * seed) % 89 for position in range(size)
    )


class ReferenceObjects:
    """What conversations may be about, where no frame can do any harm."""

    targets = TARGETS
    rooms: Mapping[Multiplexer, int] = dict.fromkeys((TEXT, DOMAIN), 130)
    numbers: Sequence[Multiplexer] = tuple(NUMBERS)
    readable: Sequence[Multiplexer] = (*CONSTANTS, *NUMBERS, WRITE_ONLY, *MISSING)

    def data(self, transfer: Transfer) -> bytes:
        """Return as many bytes as are asked for; of a number its own, where none are."""
        size = transfer.size or NUMBERS.get(transfer.target, 0)
        return payload(size, transfer.content)

    def harmless(self, data: bytes) -> bytes:
        """Return the request as it is."""
        return data

    def longest(self, mux: Multiplexer) -> int:
        """Return more than any of the objects holds."""
        del mux
        return 8192


REFERENCE = ReferenceObjects()
