"""Suggestions where a case lacks an object: one of this device, as far as it is known."""

from collections.abc import Callable

from conformance.device.device import Device
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.device.permits import FIRST_OF_DEVICE, LAST_OF_DEVICE

Fits = Callable[[KnownObject], bool]


def lacking(device: Device, what: str, example: str, *fits: Fits) -> NotTestable:
    """Build the exception for a case without an object that ``fits``; ``example`` names one.

    With an EDS it names an object of the device, by the first of ``fits`` if possible, and never
    an object that may do harm when it is written.
    """
    if not device.listing.is_complete:
        return NotTestable(
            f"needs {what}: name one of the device with its type, as in --sdo-object={example} "
            f"({example[:4]}h is an example; 'conformance init' looks for objects)",
            Missing(Lack.OBJECT, example),
        )
    found = [known for each in fits for known in _fitting(device, each)]
    known = next((one for one in found if not (one.access.writable and one.may_do_harm)), None)
    if known is None and found:
        return NotTestable(
            f"needs {what}: by its name or its profile, each that the EDS lists may do harm when "
            "it is written ('conformance init' lists them)"
        )
    if known is None:
        return NotTestable(f"needs {what}: the EDS lists none that could be added")
    tried = "may be written" if known.access.writable else "has to refuse downloads"
    return NotTestable(
        f"needs {what}: add --sdo-object={known.named} if {known.title} {tried}",
        Missing(Lack.OBJECT, known.named),
    )


def _fitting(device: Device, fits: Fits) -> list[KnownObject]:
    """Return objects that would fit if the user named them, the most harmless first."""
    found = [
        known
        for known in device.listing.entries
        if FIRST_OF_DEVICE <= known.mux.index <= LAST_OF_DEVICE
        and fits(known)
        and not known.refuses_download
        and known.mux not in device.permits.never
        and known.mux not in device.learned.unreadable
        and not device.policy.permits(known.mux)
    ]
    return sorted(found, key=_harm)


def _harm(known: KnownObject) -> tuple[bool, bool, bool, tuple[int, int]]:
    return (
        known.may_do_harm,
        known.is_limited,
        not known.is_steady,
        (known.mux.index, known.mux.sub_index),
    )
