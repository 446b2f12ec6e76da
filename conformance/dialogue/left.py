"""Strings and domains that hold what a case has left, where another needs what they held before."""

from conformance.dialogue.transfers import Transfers
from conformance.sdo.layout import Multiplexer


def write_as_before(sdo: Transfers, mux: Multiplexer) -> None:
    """Write what a string or domain held before the run, where a case has left another value.

    Whether it reads so is found out when the case is over.
    """
    if mux in sdo.device.keeping.left:
        sdo.download(mux, sdo.device.values[mux])
        sdo.device.keeping.left.discard(mux)


def write_all_as_before(sdo: Transfers) -> None:
    """Write what they all held before the run."""
    for mux in sorted(sdo.device.keeping.left):
        write_as_before(sdo, mux)
