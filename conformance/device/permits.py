"""The objects of a device that may be written, and the options that permit others."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from conformance.device.eds_listing import Listing
from conformance.device.effort import Effort
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.device.protected_objects import (
    LOAD_DEFAULTS,
    NMT,
    READ_ONLY_PROBES,
    SDO_PARAMETERS,
    STORE_PARAMETERS,
    Protected,
    how_to_permit,
    protection,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access

PURPOSES = {
    NMT: "to send NMT commands to the device",
    SDO_PARAMETERS: "to write the SDO parameters of the device (1200h to 12FFh)",
    STORE_PARAMETERS: "to let the device store its parameters (1010h)",
    LOAD_DEFAULTS: "to let the device load its defaults (1011h)",
}
CONSTANT = (0x1000, 0x1018)
# The objects of the device and of its profile; communication parameters are below.
FIRST_OF_DEVICE, LAST_OF_DEVICE = 0x2000, 0x9FFF


class NotPermitted(ValueError):
    """The user named an object that takes a permission; the text says which."""


@dataclass(frozen=True, slots=True)
class Permits:
    """The permits of the user: named objects, all rw objects of an EDS, or permissions by name.

    ``at_defaults`` says that the defaults of the device were loaded before the run; ``effort``,
    how much of it the user wants to spend.
    """

    named: tuple[KnownObject, ...] = ()
    all_rw: bool = False
    large: KnownObject | None = None
    never: frozenset[Multiplexer] = frozenset()
    permissions: frozenset[str] = frozenset()
    at_defaults: bool = False
    effort: Effort = Effort.USUAL

    def check(self) -> None:
        """Raise NotPermitted for an object that was named and takes a permission."""
        for known in self.named:
            group = protection(known.mux.index, self.permissions)
            if group is not None and known.access.writable:
                raise NotPermitted(f"{known.mux} was named, but {how_to_permit(group)}.")

    def require(self, permission: str) -> None:
        """Raise NotTestable without a permission."""
        if permission not in self.permissions:
            raise NotTestable(
                f"needs permission {PURPOSES[permission]}: add --sdo-allow={permission}",
                Missing(Lack.PERMISSION, permission),
            )

    def require_write(self, index: int) -> None:
        """Raise NotTestable without the permission that lets an object be written."""
        group = protection(index, self.permissions)
        if group is not None:
            raise _protected(group)

    def refusal(self, known: KnownObject) -> NotTestable | None:
        """Say why an entry may not be written, and which option permits it; None if it may."""
        if known.mux in self.never:
            return NotTestable(f"device.toml says that {known.mux} is never written")
        if any(known.mux == one.mux and one.access.writable for one in self.named):
            return None
        group = protection(known.mux.index, self.permissions)
        if group is not None:
            return _protected(group)
        if known.refuses_download:
            return NotTestable(
                "the EDS excludes it from writing (ObjFlags): name it if it may be written"
            )
        lifted = protection(known.mux.index, frozenset()) is not None
        of_device = FIRST_OF_DEVICE <= known.mux.index <= LAST_OF_DEVICE
        if self.all_rw and known.access is Access.RW and (of_device or lifted):
            return None
        if known.may_do_harm:
            return NotTestable(
                "writing it is not permitted, and may do harm: by its name, or because drives and "
                "outputs may move ('conformance init' lists such objects)"
            )
        name = f"--sdo-object={known.named}"
        if known.access is Access.RW and of_device:
            return NotTestable(
                "writing it is not permitted: name what may be written in device.toml, which "
                f"'conformance init' drafts, or with --sdo-object, as {name}",
                Missing(Lack.OBJECT),
            )
        return NotTestable(
            f"writing it is not permitted: add {name}", Missing(Lack.OBJECT, known.named)
        )

    def probe_refusal(self, known: KnownObject) -> NotTestable | None:
        """Say why a read-only entry may not be written with the value that it has."""
        if known.mux in self.never:
            return NotTestable(f"device.toml says that {known.mux} is never written")
        group = protection(known.mux.index, self.permissions)
        if group is not None:
            return _protected(group)
        if known.refuses_download:
            return NotTestable("the EDS excludes it from writing (ObjFlags)")
        if READ_ONLY_PROBES in self.permissions or known.mux in {one.mux for one in self.named}:
            return None
        return NotTestable(
            "a faulty device would accept the write (of the value that it has): add "
            f"--sdo-allow={READ_ONLY_PROBES}",
            Missing(Lack.PERMISSION, READ_ONLY_PROBES),
        )

    def allowed(self, objects: Iterable[KnownObject]) -> list[Multiplexer]:
        """Return which of the entries may be written, or probed because they refuse it."""
        return [
            known.mux
            for known in objects
            if not (self.refusal(known) if known.access.writable else self.probe_refusal(known))
        ]


def _protected(group: Protected) -> NotTestable:
    return NotTestable(how_to_permit(group), Missing(Lack.PERMISSION, group.permission))


def known_objects(named: Iterable[KnownObject], listing: Listing) -> list[KnownObject]:
    """Return the objects of the user, with their properties in the listing, then all it lists."""
    found: dict[Multiplexer, KnownObject] = {}
    for known in named:
        found[known.mux] = _completed(known, listing.find(known.mux))
    for known in listing.entries:
        found.setdefault(known.mux, _by_standard(known))
    return list(found.values())


def _by_standard(known: KnownObject) -> KnownObject:
    """Return an entry as CiA 301 has it: device type and identity never change."""
    constant = known.access is Access.RO and known.mux.index in CONSTANT
    return replace(known, access=Access.CONST) if constant else known


def _completed(known: KnownObject, listed: KnownObject | None) -> KnownObject:
    """Return an entry as the EDS describes it; where the user states a type, that counts."""
    if listed is None:
        return known
    if known.data_type is None:
        return listed
    if known.data_type is listed.data_type:
        return replace(listed, access=known.access)
    return known
