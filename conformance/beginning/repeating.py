"""What was met before the first case: the device's, or perhaps a lost frame, and read again."""

from collections.abc import Sequence

from conformance.device.device import Device
from conformance.device.effort import ALIKE_TRIES, TRIES_OF_CASE
from conformance.device.learned import Reason
from conformance.dialogue.causes import Causes

# Causes and how they were met, and objects that could not be read.
Met = frozenset[tuple[str, str]]


def met_with(device: Device, causes: Causes) -> Met:
    """Return what was met with a device before the first case."""
    misread = {(f"a read of {mux}", "") for mux in device.learned.unread_for(Reason.BREACH)}
    return frozenset({(str(cause), str(each.violation)) for cause, each in causes} | misread)


def is_settled(tries: Sequence[Met]) -> bool:
    """Say whether what was met last is the device's: nothing, or the same as before."""
    *others, last = tries
    before = [cause for other in others for cause in {cause for cause, _ in other}]
    known = frozenset().union(*others)
    sure = all(met in known or before.count(met[0]) >= ALIKE_TRIES - 1 for met in last)
    return sure or len(tries) >= TRIES_OF_CASE


def in_doubt(tries: Sequence[Met]) -> list[str]:
    """Return what was met, but not the last time."""
    last = {cause for cause, _ in tries[-1]}
    return sorted({cause for each in tries for cause, _ in each} - last)
