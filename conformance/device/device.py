"""The device under test as far as it is known: its objects, their values, its baseline answer."""

from collections import defaultdict
from collections.abc import Collection
from dataclasses import dataclass, field
from math import inf

from conformance.device.beliefs import Beliefs
from conformance.device.deny import group_of
from conformance.device.extents import Extents
from conformance.device.keeping import Defaults, Keeping
from conformance.device.lacking import NotTestable
from conformance.device.lengths import Lengths
from conformance.device.listing import Listing
from conformance.device.objects import KnownObject
from conformance.device.permits import Permits
from conformance.device.safety import WritePolicy
from conformance.device.services import Services
from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType
from conformance.sdo.storage import COMMANDS

# Where data types are defined: no entry there holds a value.
LAST_DATA_TYPE = 0x025F
# Within how many seconds a device stores its parameters, if nothing else is declared.
STORAGE_TIME = 5.0
# The fewest bytes of a transfer that has a first, a middle and a last segment.
THREE_SEGMENTS = 15
DEVICE_TYPE = Multiplexer(0x1000)
IDENTITY_COUNT = Multiplexer(0x1018, 0)
TEXTS = (Multiplexer(0x1008), Multiplexer(0x1009), Multiplexer(0x100A))
VENDOR_ID = KnownObject(Multiplexer(0x1018, 1), DataType.UNSIGNED32, Access.CONST)
IDENTITY_NAMES = {1: "vendor-id", 2: "product-code", 3: "revision-number", 4: "serial-number"}


@dataclass(frozen=True, slots=True)
class Device:
    """A node: what the user declares of it, what it has, and what was learned about it since.

    Declared are what may be written (``policy``, ``permits``), what an EDS or the user says of its
    objects (``listing``), the time in seconds after which it gives up a transfer
    (``server_timeout``), the one within which it stores its parameters or restores their defaults
    (``storage_time``), and the nodes of the bus to which another process is talking meanwhile
    (``neighbours``).

    ``values`` holds what each object that is ``known`` read at the start of the run: what is put
    back. The ``baseline`` is the exchange that reads 1000h: requests and the responses they got,
    byte by byte. It serves as the fence and as the sign of life.
    """

    node_id: int
    known: dict[Multiplexer, KnownObject] = field(default_factory=dict)
    values: dict[Multiplexer, bytes] = field(default_factory=dict)
    baseline: list[tuple[bytes, bytes]] = field(default_factory=list)
    policy: WritePolicy = field(default_factory=lambda: WritePolicy(()))
    permits: Permits = field(default_factory=Permits)
    listing: Listing = field(default_factory=Listing)
    server_timeout: float | None = None
    storage_time: float = STORAGE_TIME
    neighbours: frozenset[int] = frozenset()
    beliefs: Beliefs = field(default_factory=Beliefs)
    services: Services = field(default_factory=Services)
    lengths: defaultdict[Multiplexer, Lengths] = field(default_factory=lambda: defaultdict(Lengths))
    extents: Extents = field(default_factory=Extents)
    keeping: Keeping = field(default_factory=Keeping)
    defaults: Defaults = field(default_factory=Defaults)

    @property
    def objects(self) -> Collection[KnownObject]:
        """What is known of its objects, in the order in which they were named or found."""
        return self.known.values()

    @property
    def permissions(self) -> frozenset[str]:
        """What the user permits by name."""
        return self.permits.permissions

    @property
    def identity(self) -> dict[str, str]:
        """What 1018h says, by name, as hexadecimal numbers."""
        found = {}
        for sub_index, name in IDENTITY_NAMES.items():
            value = self.values.get(Multiplexer(0x1018, sub_index))
            if value is not None:
                found[name] = f"0x{int.from_bytes(value, 'little'):08X}"
        return found

    def number(self, length: int | None = None) -> KnownObject:
        """Return a writable number, of so many bytes; by default the first of 4, 2, 1, 8 bytes."""
        lengths = (4, 2, 1, 8, 3, 5, 6, 7) if length is None else (length,)
        for wanted in lengths:
            for known in self.all_writable():
                if known.length == wanted and known.data_type not in _NOT_PLAIN:
                    return known
        kind = {1: "unsigned8", 2: "unsigned16", 3: "unsigned24", 4: "unsigned32"}.get(
            length or 4, "unsigned64"
        )
        size = "" if length is None else f" of {length} byte{'s' * (length > 1)}"
        raise _lacking(f"a writable number{size}", f"2001={kind}")

    def longest_number(self) -> KnownObject:
        """Return the writable number that has the most bytes."""
        found = [known for known in self.all_writable() if known.length in (2, 4, 8)]
        plain = [known for known in found if known.data_type not in _NOT_PLAIN]
        return max(plain, key=lambda known: known.length or 0) if plain else self.number()

    def variable(self) -> KnownObject:
        """Return a writable string or domain, if possible one whose bytes count to the last 00h.

        One that was found to be short comes last.
        """
        found = [known for known in self.all_writable() if _takes_any_bytes(known)]
        for known in sorted(found, key=self._last_for_long_transfers):
            return known
        raise self._lacks_text()

    def _lacks_text(self) -> NotTestable:
        lacking = _lacking("a writable string or domain", "2010=visible_string")
        for mux, why in self.beliefs.unreadable.items():
            known = self.known.get(mux)
            if known is not None and _takes_any_bytes(known) and self.policy.permits(mux):
                return NotTestable(f"{lacking}; {mux} would do, but could not be read: {why}")
        return lacking

    def _last_for_long_transfers(self, known: KnownObject) -> tuple[float, bool, bool]:
        is_large = self.permits.large is not None and known.mux == self.permits.large.mux
        most = self.lengths[known.mux].most
        shortness = -inf if most is None else -most
        return shortness, not is_large, known.data_type is DataType.VISIBLE_STRING

    def text(self) -> KnownObject:
        """Return a writable string: of a domain, an aborted write may leave a part behind.

        A domain has to do where there is no string, or none that takes three segments.
        """
        for known in self.varying():
            return known
        raise self._lacks_text()

    def _last_for_short_transfers(self, known: KnownObject) -> tuple[bool, bool]:
        most = self.lengths[known.mux].most
        return most is not None and most < THREE_SEGMENTS, known.data_type is DataType.DOMAIN

    def varying(self) -> list[KnownObject]:
        """Return the writable strings and domains, strings first."""
        found = [known for known in self.all_writable() if _takes_any_bytes(known)]
        return sorted(found, key=self._last_for_short_transfers)

    def write_only(self) -> KnownObject:
        """Return a write-only object."""
        for known in self.objects:
            if known.access is Access.WO and self.policy.permits(known.mux):
                return known
        raise _lacking("a write-only object", "2020=unsigned32,wo")

    def read_only_text(self) -> KnownObject:
        """Return a read-only object of more than 4 bytes."""
        for known in self.objects:
            value = self.values.get(known.mux, b"")
            # Only to write to it takes a permission.
            probed = not known.access.writable and (
                self.policy.permits(known.mux) or self.policy.needs_probes(known.mux)
            )
            if probed and len(value) > 4:
                return known
        raise _lacking(
            "a read-only object longer than 4 bytes: 1008h, 1009h and 100Ah are not",
            "2021=visible_string,ro",
        )

    def is_variable(self, known: KnownObject) -> bool:
        """Whether an entry is a simple object, which has sub-index 0 only.

        Without an EDS its type tells: sub-index 0 of an array or record is an UNSIGNED8.
        """
        if known.mux.sub_index:
            return False
        listed = self.listing.objects.get(known.mux.index)
        if listed is not None and self.listing.is_complete:
            return not listed.is_structured
        others = any(one.mux.index == known.mux.index and one != known for one in self.objects)
        return not others and known.data_type not in (None, DataType.UNSIGNED8)

    def writable_variable(self) -> KnownObject:
        """Return a writable object that has sub-index 0 only, a number if there is one."""
        found = [known for known in self.all_writable() if self.is_variable(known)]
        for known in sorted(found, key=lambda known: known.varies):
            return known
        raise _lacking("a writable variable of more than a byte", "2004=unsigned32")

    def declared_timeout(self) -> float:
        """Return the seconds after which the device gives up a transfer whose client is silent."""
        if self.server_timeout is None:
            raise NotTestable(
                "needs the time after which the device gives up a transfer whose client is silent: "
                "declare it with --sdo-server-timeout=SECONDS; without one there is nothing to "
                "wait for"
            )
        return self.server_timeout

    def steady(self) -> list[Multiplexer]:
        """Return what reads the same until the suite writes it, the identity included."""
        moving = {known.mux for known in self.objects if not known.is_steady}
        return sorted(self.values.keys() - moving)

    def resettable(self) -> list[KnownObject]:
        """Return what was read, stays until somebody writes it, and goes back in a reset."""
        return [
            known
            for known in self.objects
            if known.access is Access.RW
            and known.is_steady
            and known.mux in self.values
            and known.mux.index not in (ERROR_LIST, *COMMANDS)
        ]

    def may_put_back(self, mux: Multiplexer) -> bool:
        """Say whether an entry may be written with the value that it had before the run."""
        return self.policy.permits(mux) and mux not in self.permits.never

    def kept(self, mux: Multiplexer) -> bytes | None:
        """Return the value that an entry has to have again; a read-only object has kept its own."""
        known = self.known.get(mux)
        keeps = (
            known is not None and known.access.writable and mux.index not in (ERROR_LIST, *COMMANDS)
        )
        if keeps and mux in self.values:
            return self.values[mux]
        return self.keeping.parameters.get(mux)

    def will_change(self, mux: Multiplexer) -> None:
        """Note, before it is done, that an entry may be changed."""
        value = self.kept(mux)
        if value is not None:
            known = self.known.get(mux)
            self.keeping.changes.changes(mux, value, None if known is None else known.data_type)

    def longest(self, mux: Multiplexer) -> int:
        """Return how many bytes an upload of an entry may bring before it has no end."""
        return self.extents.longest(self.known.get(mux), self.values.get(mux))

    def is_constant(self, mux: Multiplexer) -> bool:
        """Whether an entry that was read must read the same for ever."""
        known = self.known.get(mux)
        return known is not None and known.access is Access.CONST

    def lacks(self, mux: Multiplexer) -> bool:
        """Say whether it was seen that nothing can be written there, or there never can be.

        What is left over of a multiplexer where a value ends, filled up with 0, is meant as well.
        """
        return mux.index <= LAST_DATA_TYPE or any(
            mux.index == one.index and mux.sub_index in (0, one.sub_index)
            for one in self.beliefs.nowhere
        )

    def writable(self) -> KnownObject:
        """Return any object that may be written and was read."""
        for known in self.all_writable():
            return known
        raise _lacking("a writable object", "2001=unsigned8")

    def shortest_readable(self) -> Multiplexer:
        """Return what reads with the fewest bytes, always the same: leaks would show there."""
        readable = self.steady()
        if not readable:
            raise _lacking("an object that can be read", "2001=unsigned8")
        return min(readable, key=lambda mux: (len(self.values[mux]), mux))

    def all_writable(self) -> list[KnownObject]:
        """Return what may be written and was read; what has limits last.

        Not what a permission alone lets be written: it does more than to keep a value.
        """
        found = [
            known
            for known in self.objects
            if known.access is Access.RW
            and known.mux in self.values
            and self.policy.permits(known.mux)
            and group_of(known.mux.index) is None
        ]
        return sorted(found, key=lambda known: known.is_limited)


_NOT_PLAIN = (DataType.BOOLEAN, DataType.REAL32, DataType.REAL64)


def _takes_any_bytes(known: KnownObject) -> bool:
    """Say whether it is a string or domain of any length; UNICODE_STRING may insist on pairs."""
    return known.varies and known.data_type is not DataType.UNICODE_STRING


def _lacking(what: str, example: str) -> NotTestable:
    return NotTestable(
        f"needs {what}: name one with its type, --sdo-object={example} or in device.toml "
        f'[objects] writable = ["{example}"]'
    )
