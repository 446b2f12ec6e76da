"""Strings and domains that hold what a case has left, where another needs what they held before."""

from conformance.dialogue.transfers import Transfers
from conformance.sdo.checks import ServerAborted
from conformance.sdo.layout import Multiplexer

# Bytes: to read more costs as much as to write it.
MOST_READ = 64


def write_as_before(sdo: Transfers, mux: Multiplexer) -> None:
    """Write what a string or domain held before the run, where a case has left another value.

    It is written as values are on a device that refuses the ordinary way; a short one not at all
    where it reads so. Whether it does is found out again when the case is over.
    """
    if mux not in sdo.device.keeping.left:
        return
    value = sdo.device.values[mux]
    if len(value) > MOST_READ or not _reads(sdo, mux, value):
        way = sdo.record.causes.way_to_store
        if way is None or sdo.abort_of(way(sdo.client, mux, value)) is not None:
            sdo.download(mux, value)
    sdo.device.keeping.left.discard(mux)


def _reads(sdo: Transfers, mux: Multiplexer, value: bytes) -> bool:
    """Say whether an object reads so; a device may refuse to read what was left empty."""
    try:
        return sdo.read(mux) == value
    except ServerAborted:
        return False


def write_all_as_before(sdo: Transfers) -> None:
    """Write what they all held before the run."""
    for mux in sorted(sdo.device.keeping.left):
        write_as_before(sdo, mux)
