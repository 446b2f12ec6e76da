"""The order in which PDOs and SYNC get their values back.

A PDO is taken out of use before its mapping changes, and its mapping maps nothing while one of its
entries changes; how many there are goes back behind the entries, and the COB-ID behind that. It is
out of use as well while its inhibit time or the start of its SYNC counter change. The SYNC counter
(1019h) changes while there is no period (1006h), which goes back behind it.
"""

from collections.abc import Collection, Mapping

from conformance.sdo.layout import Multiplexer
from conformance.sdo.pdos import (
    COB_ID,
    MAPPING_OF,
    is_communication,
    is_kept_while_valid,
    is_mapping,
)

SYNC_PERIOD, SYNC_COUNTER = Multiplexer(0x1006), Multiplexer(0x1019)


def is_count(mux: Multiplexer) -> bool:
    """Say whether an entry holds how many objects a PDO maps."""
    return is_mapping(mux.index) and not mux.sub_index


def is_0_meanwhile(mux: Multiplexer) -> bool:
    """Say whether an entry has to be 0 while what depends on it changes."""
    return is_count(mux) or mux == SYNC_PERIOD


def needed_for(written: Collection[Multiplexer]) -> set[Multiplexer]:
    """Return what has to change for a while before these get their values."""
    indices = {mux.index for mux in written if is_mapping(mux.index)}
    needed = {Multiplexer(index) for index in indices}
    pdos = {index - MAPPING_OF for index in indices}
    pdos |= {mux.index for mux in written if is_kept_while_valid(mux)}
    needed |= {Multiplexer(index, COB_ID) for index in pdos}
    return needed | {SYNC_PERIOD} if SYNC_COUNTER in written else needed


def in_order(due: Mapping[Multiplexer, bytes]) -> list[tuple[Multiplexer, bytes]]:
    """Return values in the order in which they are written."""
    return sorted(due.items(), key=lambda item: (_rank(item[0]), item[0]))


def _rank(mux: Multiplexer) -> int:
    if is_communication(mux.index):
        return 3 if mux.sub_index == COB_ID else 0
    if mux == SYNC_PERIOD:
        return 1
    return (2 if is_count(mux) else 1) if is_mapping(mux.index) else 0
