"""Objects that configure a device or its communication: never written without a permission.

Writing them may store parameters, move the node to other COB-IDs, replace its program or let it
start others. Each group of them has a permission of its own, in ``[permissions]`` of device.toml or
with ``--sdo-allow``.
"""

from dataclasses import dataclass
from functools import cache

from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.nearest import did_you_mean

NMT = "nmt"
SDO_PARAMETERS = "sdo-parameters"
READ_ONLY_PROBES = "read-only-probes"
OTHER_NODES = "other-nodes"
STORE_PARAMETERS = "store-parameters"
LOAD_DEFAULTS = "load-defaults"
CLEAR_ERRORS = "clear-errors"


@dataclass(frozen=True, slots=True)
class Protected:
    """A range of indices, both included, and the permission with which they may be written."""

    first: int
    last: int
    permission: str
    what: str


PROTECTED = (
    Protected(ERROR_LIST, ERROR_LIST, CLEAR_ERRORS, "the list of errors, which a write clears"),
    Protected(0x1005, 0x1007, "sync-parameters", "the SYNC parameters"),
    Protected(0x1010, 0x1010, STORE_PARAMETERS, "the parameter storage"),
    Protected(0x1011, 0x1011, LOAD_DEFAULTS, "the restoring of defaults"),
    Protected(0x1012, 0x1013, "time-parameters", "the TIME parameters"),
    Protected(0x1014, 0x1015, "emergency-parameters", "the EMCY parameters"),
    Protected(0x1016, 0x1016, "heartbeat-parameters", "the nodes whose heartbeat is awaited"),
    Protected(0x1017, 0x1017, NMT, "the heartbeat time"),
    Protected(0x1019, 0x1019, "sync-parameters", "the SYNC parameters"),
    Protected(0x1020, 0x1020, "configuration-date", "the date of the configuration"),
    Protected(0x1023, 0x1026, "operating-system", "the prompt of the operating system"),
    Protected(0x1029, 0x1029, "error-behaviour", "what the device does on errors"),
    Protected(0x1200, 0x12FF, SDO_PARAMETERS, "the SDO channels"),
    Protected(0x1300, 0x13FF, "safety-parameters", "the safety-relevant communication"),
    Protected(0x1400, 0x1BFF, "pdo-parameters", "the PDOs"),
    Protected(0x1F00, 0x1FFF, "programs-and-network", "programs and the start of the network"),
)
PERMISSIONS = frozenset({READ_ONLY_PROBES, OTHER_NODES, *(group.permission for group in PROTECTED)})


class PermissionNameError(ValueError):
    """No permission has that name."""


def parse_permission(text: str) -> str:
    """Return the permission of a name.

    Raises PermissionNameError with the nearest name.
    """
    if text in PERMISSIONS:
        return text
    hint = did_you_mean(text, sorted(PERMISSIONS))
    raise PermissionNameError(f"There is no permission called {text!r}. {hint}")


@cache
def group_of(index: int) -> Protected | None:
    """Return the group that an object belongs to, None for one that needs no permission."""
    return next((group for group in PROTECTED if group.first <= index <= group.last), None)


def protection(index: int, permissions: frozenset[str]) -> Protected | None:
    """Return the group that keeps an object from being written, or None where it may be."""
    group = group_of(index)
    return None if group is None or group.permission in permissions else group


def how_to_permit(group: Protected) -> str:
    """Name the option that permits to write a protected object."""
    return (
        f"a permission is needed to write {group.what}: --sdo-allow={group.permission}, or "
        f"[permissions] {group.permission} = true in device.toml"
    )
