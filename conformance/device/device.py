"""The device under test as far as it is known: its objects, their values, its baseline answer."""

from collections.abc import Collection, Container, Iterator, Sequence
from dataclasses import dataclass, field, replace

from conformance.device.contents import Contents, Defaults
from conformance.device.eds_listing import Listing
from conformance.device.effort import LONG_VALUE
from conformance.device.known_objects import KnownObject
from conformance.device.learned import Learned, Reason
from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.device.options import STORAGE_TIME
from conformance.device.permits import Permits
from conformance.device.protected_objects import group_of
from conformance.device.safety import IDENTITY, WritePolicy
from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.frames import DownloadInitiate, Request
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH
from conformance.sdo.objects import Access, DataType, Habits
from conformance.sdo.storage_commands import COMMANDS

# Where data types are defined: no entry there holds a value.
LAST_DATA_TYPE = 0x025F
# The fewest bytes of a transfer in two segments, and of one with a first, a middle and a last one.
TWO_SEGMENTS = 8
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
    back. The ``contents`` are what has become of them. The ``baseline`` is the exchange that reads
    1000h: requests and the responses they got, byte by byte. It serves as the fence and as the sign
    of life.
    """

    node_id: int
    known: dict[Multiplexer, KnownObject] = field(default_factory=dict)
    values: dict[Multiplexer, bytes] = field(default_factory=dict)
    baseline: list[tuple[bytes, bytes]] = field(default_factory=list)
    policy: WritePolicy = field(default_factory=lambda: WritePolicy(()))
    permits: Permits = field(default_factory=Permits)
    listing: Listing = field(default_factory=Listing)
    server_timeout: float | None = None
    storage_time: float = STORAGE_TIME.default
    neighbours: frozenset[int] = frozenset()
    learned: Learned = field(default_factory=Learned)
    contents: Contents = field(default_factory=Contents)
    defaults: Defaults = field(default_factory=Defaults)

    def __post_init__(self) -> None:
        """Let the contents be those of the objects of this device."""
        self.contents.known, self.contents.own = self.known, self.values

    @property
    def objects(self) -> Collection[KnownObject]:
        """What is known of its objects, in the order in which they were named or found."""
        return self.known.values()

    @property
    def permissions(self) -> frozenset[str]:
        """What the user permits by name."""
        return self.permits.permissions

    @property
    def device_type(self) -> bytes:
        """What 1000h reads, as far as it was read: the only value that may be written there."""
        return self.values.get(DEVICE_TYPE, b"")[:EXPEDITED_LENGTH] or bytes(4)

    @property
    def identity(self) -> dict[str, str]:
        """What 1018h says, by name, as hexadecimal numbers."""
        found = {}
        for sub_index, name in IDENTITY_NAMES.items():
            value = self.values.get(Multiplexer(0x1018, sub_index))
            if value is not None:
                found[name] = f"0x{int.from_bytes(value, 'little'):08X}"
        return found

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

    def declared_timeout(self) -> float:
        """Return the seconds after which the device gives up a transfer whose client is silent."""
        if self.server_timeout is None:
            raise NotTestable(
                "needs the time after which the device aborts the transfer of a silent client: if "
                "it has such a time-out, declare it with --sdo-server-timeout=SECONDS",
                Missing(Lack.SERVER_TIMEOUT),
            )
        return self.server_timeout

    def steady(self) -> list[Multiplexer]:
        """Return what reads the same until the suite writes it, the identity included."""
        moving = {known.mux for known in self.objects if not known.is_steady}
        return sorted(self.values.keys() - moving)

    def briefly_read(self) -> Sequence[Multiplexer]:
        """Return the steady objects without long values; in haste, some of very many."""
        brief = [mux for mux in self.steady() if len(self.values[mux]) <= LONG_VALUE]
        return self.permits.effort.sampled(brief)

    def resettable(self) -> list[KnownObject]:
        """Return what was read, stays until it is written, and goes back in a reset."""
        return [known for known in self._parameters() if known.mux in self.values]

    def lost_in_reset(self, indices: Container[int] | None = None) -> list[KnownObject]:
        """Return what a reset changes, perhaps, and was not read: very many objects are not.

        That is of all ``indices``, or of some.
        """
        over = self.learned.unread_for(Reason.PASSED_OVER)
        lost = [known for known in self._parameters() if known.mux in over]
        return [known for known in lost if indices is None or known.mux.index in indices]

    def _parameters(self) -> Iterator[KnownObject]:
        for known in self.objects:
            keeps = known.access is Access.RW and known.is_steady
            if keeps and known.mux.index not in (ERROR_LIST, *COMMANDS):
                yield known

    def may_put_back(self, mux: Multiplexer) -> bool:
        """Say whether an entry may be written with the value that it had before the run."""
        if mux in self.learned.lengths and self.learned.lengths[mux].irreplaceable:
            return False
        return self.policy.permits(mux) and mux not in self.permits.never

    def may_be_sent(self, request: Request, target: Multiplexer) -> bool:
        """Say whether a request that writes may be sent by chance, whatever follows it.

        Not to an object that takes a permission: a write does more there than to keep a value. What
        only a probe may write to is sent the value that it has.
        """
        known = self.known.get(target)
        if not self.policy.permits(target) or group_of(target.index) is not None:
            return False
        probe = target.index in IDENTITY if known is None else not known.access.writable
        if not probe or self.policy.is_missing(target):
            return True
        own = isinstance(request, DownloadInitiate) and request.expedited and request.data
        return own == self.values.get(target)

    def learn(self, known: KnownObject, habits: Habits) -> KnownObject:
        """Take how an object reads otherwise than it was written; return the object with that."""
        self.known[known.mux] = known = replace(known, habits=habits)
        return known

    def would_lose(self, mux: Multiplexer) -> bool:
        """Say whether the device has an object, as far as is known, that could not be put back."""
        first = Multiplexer(mux.index)
        there = mux in self.known or first in self.known or mux.index in self.listing.objects
        if not there or self.lacks(mux):
            return False
        known = self.known.get(mux)
        named = known is not None and known.access.writable and self.may_put_back(mux)
        return not named or self.contents.kept(mux) is None

    def taken_for(self, mux: Multiplexer) -> list[Multiplexer]:
        """Return what a device may write instead of an entry that it lacks: its sub-index apart."""
        if not self.policy.is_missing(mux):
            return []
        return list(self.contents.due(one for one in self.values if one.index == mux.index))

    def was_taken(self, mux: Multiplexer, before: bytes | None) -> None:
        """Note that a write was confirmed that had to be refused; ``before`` is what was there.

        What is read-only has to be put back from now on. What could not be read cannot be.
        """
        known = self.known.get(mux)
        protected = group_of(mux.index) is not None
        refuses = known is not None and not known.access.writable and not protected
        if self.contents.kept(mux) is not None or not (refuses or self.policy.is_missing(mux)):
            return
        if before is None:
            self.contents.takes(mux)
        else:
            self.contents.parameters[mux] = before
            self.contents.will_change(mux)

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
            for one in self.learned.nowhere
        )
