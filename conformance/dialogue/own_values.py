"""Strings and domains that hold what a case has left, where another needs what they held before."""

from conformance.device.contents import Holds
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
    contents = sdo.device.contents
    if mux not in contents.left():
        return
    value = sdo.device.values[mux]
    presumed = contents.holds(mux) is Holds.PRESUMED
    may_hold_it = presumed or sdo.device.learned.lengths[mux].most == 0
    if contents.value(mux) != value and not (may_hold_it and sdo.upload(mux) == value):
        way = sdo.device.learned.way_to_store
        if way is None or sdo.abort_of(way(sdo.client, mux, value)) is not None:
            sdo.download(mux, value)
    contents.presume(mux)


def write_all_as_before(sdo: Dialogue) -> None:
    """Write what they all held before the run, but for those that ought to hold it."""
    contents = sdo.device.contents
    for mux in sorted(contents.left(Holds.LEFT)):
        if _written_in_blocks(sdo, mux):
            contents.presume(mux)
        else:
            write_as_before(sdo, mux)


def _written_in_blocks(sdo: Dialogue, mux: Multiplexer) -> bool:
    """Write a long value in blocks and read it back, where both are known to serve."""
    value, blocks = sdo.device.values[mux], Blocks(sdo)
    if len(value) <= SHORT_VALUE or not blocks.read_alike() or not write_in_blocks(sdo, mux, value):
        return False
    sdo.device.learned.stores_in_blocks = blocks.reads(mux, value)
    return sdo.device.learned.stores_in_blocks
