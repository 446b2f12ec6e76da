"""PDOs as the object dictionary has them: their parameters and what they map (7.5.2.35 to .38)."""

from dataclasses import dataclass
from typing import Self

from conformance.sdo.layout import Multiplexer

RECEIVED, SENT = range(0x1400, 0x1600), range(0x1800, 0x1A00)
MAPPING_OF = 0x200
RECEIVED_MAPPINGS, SENT_MAPPINGS = range(0x1600, 0x1800), range(0x1A00, 0x1C00)
# COB-IDs, and all of PDOs: what is in use does not change, so they are written in an order.
IN_ORDER = frozenset((0x1005, 0x1012, 0x1014, *range(0x1400, 0x1C00)))
COB_ID, TRANSMISSION_TYPE, INHIBIT_TIME, SYNC_START = 1, 2, 3, 6
# Transmission types between the last cyclic one and the event-driven ones.
RESERVED_TYPES = range(0xF1, 0xFC)
MOST_MAPPED = 0x40
MOST_BITS = 64
# Sub-index 0 of the mapping of a multiplexed PDO (MPDO): by a list of sources, or by address.
MULTIPLEXED = (0xFE, 0xFF)
_MULTIPLEXED = tuple(bytes([kind]) for kind in MULTIPLEXED)
# Types that a received PDO may map in the place of data which the device has no use for (7.4.7).
DUMMIES = range(0x0001, 0x0008)


@dataclass(frozen=True, slots=True)
class Mapped:
    """An entry of a mapping: which object, and how many bits of the PDO it takes."""

    mux: Multiplexer
    bits: int

    @classmethod
    def of(cls, number: int) -> Self:
        """Read the UNSIGNED32 of a mapping.

        >>> str(Mapped.of(0x20040020))
        '32 bits of 2004h:00'
        """
        return cls(Multiplexer(number >> 16, number >> 8 & 0xFF), number & 0xFF)

    def __int__(self) -> int:
        return self.mux.index << 16 | self.mux.sub_index << 8 | self.bits

    def __bytes__(self) -> bytes:
        return int(self).to_bytes(4, "little")

    def __str__(self) -> str:
        return f"{self.bits} bits of {self.mux}"


def is_mapping(index: int) -> bool:
    """Say whether an object holds what a PDO maps."""
    return index in RECEIVED_MAPPINGS or index in SENT_MAPPINGS


def is_count_of_mapping(mux: Multiplexer) -> bool:
    """Say whether it is sub-index 0 of a mapping."""
    return is_mapping(mux.index) and not mux.sub_index


def is_multiplexed(mux: Multiplexer, value: bytes) -> bool:
    """Say whether it is sub-index 0 of a mapping, and makes the PDO a multiplexed one (MPDO)."""
    return is_count_of_mapping(mux) and value in _MULTIPLEXED


def is_kept_while_valid(mux: Multiplexer) -> bool:
    """Say whether it is an entry of a sent PDO that does not change while the PDO is valid."""
    return mux.index in SENT and mux.sub_index in (INHIBIT_TIME, SYNC_START)


def is_communication(index: int) -> bool:
    """Say whether an object holds how a PDO is sent or received."""
    return index in RECEIVED or index in SENT
