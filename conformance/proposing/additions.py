"""The effect of each permission, and the number of cases that need it.

The numbers are those of the built-in device without an EDS, rounded; an EDS adds cases for the
objects themselves.
"""

from dataclasses import dataclass

from conformance.device.protected_objects import (
    CLEAR_ERRORS,
    LOAD_DEFAULTS,
    NMT,
    OTHER_NODES,
    PROTECTED,
    READ_ONLY_PROBES,
    SDO_PARAMETERS,
    STORE_PARAMETERS,
)

ALL_CASES = 3300
# By writable objects, most cases first.
BY_OBJECT = {
    "a string or domain": 2600,
    "a number of 4 bytes": 40,
    "any object": 20,
    "a number of 2 bytes": 20,
    "a number of 1 byte": 15,
    "a number of 8 or 3 bytes": 10,
}


@dataclass(frozen=True, slots=True)
class Permission:
    """The effect of a permission, and how many ``cases`` need it without an EDS.

    A permission that is not ``proposed`` may do harm that nobody can undo over SDO.
    """

    name: str
    effect: str
    cases: int = 0
    proposed: bool = True

    @property
    def indices(self) -> list[range]:
        """The objects that it lets be written; none where it is about something else."""
        groups = (group for group in PROTECTED if group.permission == self.name)
        return [range(group.first, group.last + 1) for group in groups]

    @property
    def needed_by(self) -> str:
        """How many cases need it, in words."""
        if not self.cases:
            return "With an EDS, cases on these objects"
        return f"{self.cases} case{'s' * (self.cases > 1)}"


PERMISSIONS = (
    Permission(
        READ_ONLY_PROBES,
        "downloads that a right device refuses: to what is read-only, with the value that it has, "
        "and to what is missing",
        100,
    ),
    Permission(SDO_PARAMETERS, "1200h to 12FFh: moves further SDO channels, and back", 350),
    Permission(
        NMT,
        "1017h, and NMT commands: the device is stopped and reset, and left in Pre-operational",
        310,
    ),
    Permission(
        OTHER_NODES, "SDO requests to other node-IDs: a transfer of those nodes may be aborted", 20
    ),
    Permission("pdo-parameters", "1400h to 1BFFh: COB-IDs and mapping of PDOs, restored", 27),
    Permission("sync-parameters", "1005h to 1007h, 1019h: COB-ID and period of SYNC, restored", 8),
    Permission("time-parameters", "1012h, 1013h: the COB-ID of TIME, restored", 3),
    Permission("emergency-parameters", "1014h, 1015h: the COB-ID of EMCY, restored", 3),
    Permission(CLEAR_ERRORS, "1003h: clears the list of errors, for good", 3),
    Permission("heartbeat-parameters", "1016h: whose heartbeat the device awaits, restored", 1),
    Permission(STORE_PARAMETERS, "1010h: the device stores its parameters, which wears its memory"),
    Permission(
        LOAD_DEFAULTS,
        "1011h: loads the defaults, which erases what was stored; takes nmt, and more than that",
    ),
    Permission("configuration-date", "1020h: the date and time of the configuration, restored"),
    Permission("error-behaviour", "1029h: what the device does on errors, restored", 2),
    Permission("operating-system", "1023h to 1026h: commands of its own", proposed=False),
    Permission("safety-parameters", "1300h to 13FFh: what protects people", proposed=False),
    Permission("programs-and-network", "1F00h to 1FFFh: may replace its program", proposed=False),
)
