"""What may be done: writes to what the user named, probes that a device has to refuse, and what
was permitted by name.
"""

import difflib
from collections.abc import Iterable
from enum import StrEnum

from conformance.bus.errors import WriteNotPermitted
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    DownloadInitiate,
    Request,
)
from conformance.sdo.layout import Multiplexer

IDENTITY = (0x1000, 0x1008, 0x1009, 0x100A, 0x1018)


class Permission(StrEnum):
    """What a run does only when it is told that it may."""

    NMT = "nmt"
    SDO_PARAMETERS = "sdo-parameters"


NO_PERMISSIONS: frozenset[Permission] = frozenset()
ALL_PERMISSIONS = frozenset(Permission)

# Objects on which it depends how a device communicates, what it keeps and which program it runs,
# with what permits to write them; None stands for nothing.
PROTECTED: tuple[tuple[range, Permission | None], ...] = (
    (range(0x1010, 0x1012), None),
    (range(0x1014, 0x1017), None),
    (range(0x1017, 0x1018), Permission.NMT),
    (range(0x1020, 0x1021), None),
    (range(0x1200, 0x1300), Permission.SDO_PARAMETERS),
    (range(0x1400, 0x1C00), None),
    (range(0x1F50, 0x1F58), None),
    (range(0x1F80, 0x1F90), None),
)


class PermissionNameError(ValueError):
    """No permission has that name."""


def parse_permission(text: str) -> Permission:
    """Return the permission of a name.

    Raises PermissionNameError with the nearest name.
    """
    known = [permission.value for permission in Permission]
    if text in known:
        return Permission(text)
    near = difflib.get_close_matches(text, known, n=1)
    hint = f"Did you mean {near[0]!r}?" if near else f"Known: {', '.join(known)}."
    raise PermissionNameError(f"There is no permission called {text!r}. {hint}")


def is_protected(index: int) -> bool:
    """Say whether an object may be written by a permission only, if at all."""
    return any(index in indices for indices, _ in PROTECTED)


def permission_for(index: int) -> Permission | None:
    """Return what permits to write a protected object; None when nothing does."""
    return next((needed for indices, needed in PROTECTED if index in indices), None)


def how_to_permit(index: int) -> str:
    """Say in a sentence what would have to be done to write a protected object."""
    needed = permission_for(index)
    if needed is None:
        return f"{index:04X}h is never written: a device could be lost or do harm."
    return f"{index:04X}h is written with permission only: add --allow={needed}."


class WritePolicy:
    """Decides on every request before it is sent.

    Allowed are the objects that the user named, entries that are read-only by the standard
    (a probe writes them with the value just read, and a conformant device refuses), and entries
    that the device has said it does not have. Protected objects are allowed by permissions
    alone, whoever named them.
    """

    def __init__(
        self,
        writable: Iterable[Multiplexer],
        permissions: frozenset[Permission] = NO_PERMISSIONS,
    ) -> None:
        """Take what the user named and permitted."""
        self._writable = frozenset(writable)
        self._permissions = permissions
        self._missing: set[Multiplexer] = set()

    def allow_missing(self, mux: Multiplexer) -> None:
        """Allow writes to an entry that the device does not have."""
        self._missing.add(mux)

    def permits(self, mux: Multiplexer) -> bool:
        """Say whether a download to this entry may be sent."""
        if is_protected(mux.index):
            return permission_for(mux.index) in self._permissions
        return mux in self._writable or mux in self._missing or mux.index in IDENTITY

    def check(self, request: Request) -> None:
        """Raise WriteNotPermitted for a request that would write elsewhere."""
        target = written_by(request)
        if target is None or self.permits(target):
            return
        if is_protected(target.index):
            raise WriteNotPermitted(
                f"A case was about to write to {target}. {how_to_permit(target.index)}"
            )
        raise WriteNotPermitted(
            f"A case was about to write to {target}, which nobody allowed. Allow it with "
            f"--object={target.index:04X}:{target.sub_index:02X}, or leave the case out."
        )


def written_by(request: Request) -> Multiplexer | None:
    """Return the entry that a request starts to write, if it does."""
    if isinstance(request, DownloadInitiate | BlockDownloadInitiate):
        return request.mux
    return None
