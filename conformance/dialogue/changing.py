"""Objects that a device changes by itself, though nobody has said so: found out by reading."""

from dataclasses import replace

from conformance.device.device import Device
from conformance.device.effort import READS_OF_CHANGING
from conformance.device.known_objects import KnownObject
from conformance.dialogue.transfers import Transfers
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access

# What is longer, in bytes, is no number that a device measures or counts.
LONGEST = 8


def is_steady(device: Device, entry: KnownObject) -> bool:
    """Say whether a value stays until the suite writes it, as far as that was seen by now."""
    return device.known.get(entry.mux, entry).is_steady


def may_change(device: Device, known: KnownObject) -> bool:
    """Say whether a value may change by itself: what the user has named is known to stay."""
    named = any(known.mux == one.mux for one in device.permits.named)
    short = len(device.values.get(known.mux, b"")) <= LONGEST
    return known.access is Access.RW and not named and short


def take_as_changing(device: Device, known: KnownObject) -> None:
    """Remember that the device changes an object: no case compares its values from then on."""
    device.known[known.mux] = replace(known, floats=True)


def changes_by_itself(sdo: Transfers, mux: Multiplexer) -> bool:
    """Say whether a value that was compared is one that changes without being written."""
    known = sdo.device.known.get(mux)
    if known is None or known.floats or not may_change(sdo.device, known):
        return known is not None and known.floats
    first = sdo.upload(known)
    if all(sdo.upload(known) == first for _ in range(READS_OF_CHANGING)):
        return False
    take_as_changing(sdo.device, known)
    return True
