"""Objects that change what a device is, not what it does: never written without a permission.

Writing them may store parameters, move the node to other COB-IDs, replace its program or let it
start others. Each group of them has a permission of its own, in ``[permissions]`` of device.toml.
"""

from dataclasses import dataclass

READ_ONLY_PROBES = "read-only-probes"
LOAD_DEFAULTS = "load-defaults"


@dataclass(frozen=True, slots=True)
class Denied:
    """A range of indices, both included, and the permission that lifts the denial."""

    first: int
    last: int
    permission: str
    what: str


DENIED = (
    Denied(0x1005, 0x1007, "sync-parameters", "the SYNC parameters"),
    Denied(0x1010, 0x1010, "store-parameters", "the parameter storage"),
    Denied(0x1011, 0x1011, LOAD_DEFAULTS, "the restoring of defaults"),
    Denied(0x1012, 0x1013, "time-parameters", "the TIME parameters"),
    Denied(0x1014, 0x1015, "emergency-parameters", "the EMCY parameters"),
    Denied(0x1016, 0x1017, "heartbeat-parameters", "the heartbeat times"),
    Denied(0x1019, 0x1019, "sync-parameters", "the SYNC parameters"),
    Denied(0x1020, 0x1020, "configuration-date", "the date of the configuration"),
    Denied(0x1023, 0x1026, "operating-system", "the prompt of the operating system"),
    Denied(0x1029, 0x1029, "error-behaviour", "what the device does on errors"),
    Denied(0x1200, 0x12FF, "sdo-parameters", "the SDO channels"),
    Denied(0x1300, 0x13FF, "safety-parameters", "the safety-relevant communication"),
    Denied(0x1400, 0x1BFF, "pdo-parameters", "the PDOs"),
    Denied(0x1F00, 0x1FFF, "programs-and-network", "programs and the start of the network"),
)
PERMISSIONS = frozenset({READ_ONLY_PROBES, *(group.permission for group in DENIED)})


def denial(index: int, permissions: frozenset[str]) -> Denied | None:
    """Return the group that keeps an object from being written, or None where it may be."""
    for group in DENIED:
        if group.first <= index <= group.last and group.permission not in permissions:
            return group
    return None
