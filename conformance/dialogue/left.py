"""Strings and domains that hold what a case has left, where another needs what they held before."""

from conformance.dialogue.transfers import Transfers
from conformance.sdo.layout import Multiplexer


def write_as_before(sdo: Transfers, mux: Multiplexer) -> None:
    """Write what a string or domain held before the run, where a case has left another value.

    It is written as values are on a device that refuses the ordinary way; not at all where it is
    known to read so. To find that out might cost more than to write it: of what the object holds
    not even the length is known. Whether it does is found out when the case is over. Only what is
    known to take no value at all is read: it may well hold what it did.
    """
    if mux not in sdo.device.keeping.left:
        return
    value = sdo.device.values[mux]
    takes_none = sdo.device.lengths[mux].most == 0
    if sdo.device.holds(mux) != value and not (takes_none and sdo.upload(mux) == value):
        way = sdo.record.causes.way_to_store
        if way is None or sdo.abort_of(way(sdo.client, mux, value)) is not None:
            sdo.download(mux, value)
    sdo.device.keeping.left.discard(mux)


def write_all_as_before(sdo: Transfers) -> None:
    """Write what they all held before the run."""
    for mux in sorted(sdo.device.keeping.left):
        write_as_before(sdo, mux)
