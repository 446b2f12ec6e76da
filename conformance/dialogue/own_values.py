"""Strings and domains that hold what a case has left, where another needs what they held before."""

from conformance.device.effort import SHORT_VALUE
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.storing import write_in_blocks
from conformance.dialogue.transfers import Transfers
from conformance.sdo.layout import Multiplexer


def write_as_before(sdo: Transfers, mux: Multiplexer) -> None:
    """Write what a string or domain held before the run, where a case has left another value.

    It is written as values are on a device that refuses the ordinary way; not at all where it is
    known to read so. To find that out might cost more than to write it: of what the object holds
    not even the length is known. Whether it does is found out later. Only what may well hold what
    it did is read: that was written already, or it takes no value at all.
    """
    keeping = sdo.device.keeping
    if mux not in keeping.left:
        return
    value = sdo.device.values[mux]
    may_hold_it = mux in keeping.doubtful or sdo.device.learned.lengths[mux].most == 0
    if sdo.device.holds(mux) != value and not (may_hold_it and sdo.upload(mux) == value):
        way = sdo.device.learned.way_to_store
        if way is None or sdo.abort_of(way(sdo.client, mux, value)) is not None:
            sdo.download(mux, value)
    _ought_to_be_back(sdo, mux)


def write_all_as_before(sdo: Dialogue) -> None:
    """Write what they all held before the run, but for those that ought to hold it."""
    for mux in sorted(sdo.device.keeping.left - sdo.device.keeping.doubtful):
        if _written_in_blocks(sdo, mux):
            _ought_to_be_back(sdo, mux)
        else:
            write_as_before(sdo, mux)


def _written_in_blocks(sdo: Dialogue, mux: Multiplexer) -> bool:
    """Write a long value in blocks and read it back, where both are known to serve."""
    value, blocks = sdo.device.values[mux], Blocks(sdo)
    if len(value) <= SHORT_VALUE or not blocks.read_alike() or not write_in_blocks(sdo, mux, value):
        return False
    sdo.device.learned.stores_in_blocks = blocks.reads(mux, value)
    return sdo.device.learned.stores_in_blocks


def _ought_to_be_back(sdo: Transfers, mux: Multiplexer) -> None:
    sdo.device.keeping.left.discard(mux)
    sdo.device.keeping.doubtful.add(mux)
