"""Nodes that are wrong in types, defaults and values of the communication."""

from functools import partial

from conformance.faults import registry
from conformance.faults.altered_nodes import AlteredNode
from conformance.faults.registry import About, Defect
from conformance.faults.unusual.communication_values import COMMUNICATION_ERROR, ErrorFromTheStart
from conformance.reference.communication import EMERGENCY, SYNC
from conformance.reference.communication_values import (
    CONFIGURATION,
    CONSUMED,
    CONSUMED_NODES,
    COUNTER_OVERFLOW,
    ERROR_BEHAVIOUR,
    RESERVED_OVERFLOWS,
)
from conformance.reference.node import HEARTBEAT_TIME
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.channel_parameters import Check, CheckedEntry
from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import EMERGENCY_BASE
from conformance.sdo.objects import Access, DataType, Entry

fault = partial(registry.fault, about=About.OBJECTS)


class _Checks(AlteredNode):
    """Checks some entries otherwise."""

    entries: tuple[Multiplexer, ...] = ()

    def alter(self) -> None:
        for mux in self.entries:
            entry = self.objects.get(mux)
            if isinstance(entry, CheckedEntry):
                entry.check = partial(self.check, entry.check)

    def check(self, right: Check, old: bytes, new: bytes) -> None:
        """Take anything; ``right`` is how it ought to be checked."""


@fault("heartbeat-time-of-one-byte", Defect.ACCESS_OR_SIZE, "communication.type[1017h]")
class HeartbeatTimeOfOneByte(AlteredNode):
    """Has a heartbeat time (1017h) of 8 bits."""

    def alter(self) -> None:
        self.heartbeat_time = Entry(bytes(1), DataType.UNSIGNED8)
        self.objects.add({HEARTBEAT_TIME: self.heartbeat_time})


@fault("consumed-twice-taken", Defect.ACCESS_OR_SIZE, "communication.consumed-twice")
class ConsumedTwice(_Checks):
    """Awaits the heartbeat of one node by two entries of 1016h."""

    entries = tuple(Multiplexer(CONSUMED, sub) for sub in range(1, CONSUMED_NODES + 1))


@fault("sync-counter-reserved-taken", Defect.ACCESS_OR_SIZE, "communication.sync-counter[255]")
class CounterReserved(_Checks):
    """Takes reserved values for the SYNC counter (1019h)."""

    entries = (COUNTER_OVERFLOW,)

    def check(self, right: Check, old: bytes, new: bytes) -> None:
        if new[0] not in RESERVED_OVERFLOWS:
            right(old, new)


@fault("sync-counter-1-taken", Defect.ACCESS_OR_SIZE, "communication.sync-counter[1]")
class CounterOfOne(_Checks):
    """Takes a SYNC counter (1019h) that goes up to 1."""

    entries = (COUNTER_OVERFLOW,)

    def check(self, right: Check, old: bytes, new: bytes) -> None:
        if new != b"\x01":
            right(old, new)


@fault("sync-counter-moved", Defect.ACCESS_OR_SIZE, "communication.sync-counter-in-use")
class CounterMoved(_Checks):
    """Takes another SYNC counter (1019h) while there is a period (1006h)."""

    entries = (COUNTER_OVERFLOW,)

    def check(self, right: Check, old: bytes, new: bytes) -> None:
        if new[0] in RESERVED_OVERFLOWS:
            right(old, new)


@fault("error-behaviour-any", Defect.ACCESS_OR_SIZE, "communication.error-behaviour")
class AnyBehaviour(_Checks):
    """Takes reserved behaviours on an error (1029h:01)."""

    entries = (Multiplexer(ERROR_BEHAVIOUR, 1),)


class _Defaults(AlteredNode):
    """Has another default, and the right value stored when a run begins."""

    entry = SYNC

    def alter(self) -> None:
        altered, default = self.objects.find(self.entry), self.default().to_bytes(4, "little")
        self.defaults = [
            (entry, in_area, default if entry is altered else value)
            for entry, in_area, value in self.defaults
        ]

    def default(self) -> int:
        """Return the COB-ID."""
        return EMERGENCY_BASE + self.node_id


@fault("sync-default-of-emcy", Defect.ACCESS_OR_SIZE, "communication.default-identifier[1005h]")
class SyncDefault(_Defaults):
    """Has 080h plus node-ID as the default of SYNC (1005h)."""


@fault("emcy-default-of-sync", Defect.ACCESS_OR_SIZE, "communication.default-identifier[1014h]")
class EmergencyDefault(_Defaults):
    """Has 080h, without the node-ID, as the default of EMCY (1014h)."""

    entry = EMERGENCY

    def default(self) -> int:
        return EMERGENCY_BASE


@fault("emergency-not-listed", Defect.ACCESS_OR_SIZE, "communication.emergency-listed")
class EmergencyNotListed(ErrorFromTheStart):
    """Tells of an error by an emergency, and keeps an empty list."""

    def emergencies(self) -> list[CanFrame]:
        frames = super().emergencies()
        self.objects.find(Multiplexer(ERROR_LIST)).value = bytes(1)
        return frames


@fault("latest-error-last", Defect.ACCESS_OR_SIZE, "communication.emergency-listed", soft=True)
class LatestErrorLast(ErrorFromTheStart):
    """Keeps the latest error behind an earlier one."""

    def emergencies(self) -> list[CanFrame]:
        frames = super().emergencies()
        if frames:
            self.objects.find(Multiplexer(ERROR_LIST)).value = b"\x02"
            for place, code in enumerate((b"\x10\x23\0\0", COMMUNICATION_ERROR + bytes(2)), 1):
                entry = self.objects.find(Multiplexer(ERROR_LIST, place))
                entry.value, entry.has_data = code, True
        return frames


@fault("configuration-date-not-stored", Defect.STATE, "communication.configuration-date")
class DateNotStored(AlteredNode):
    """Forgets the date of its configuration (1020h) in a reset, though it was stored."""

    def save(self) -> None:
        dates = [self.objects.find(Multiplexer(CONFIGURATION, sub)) for sub in (1, 2)]
        earlier = self.power_on
        super().save()
        self.power_on = [
            before if any(before[0] is date for date in dates) else stored
            for before, stored in zip(earlier, self.power_on, strict=True)
        ]


@fault("product-code-written", Defect.ACCESS_OR_SIZE, "communication.read-only[1018h]")
class ProductCodeWritten(AlteredNode):
    """Lets its product code (1018h:02) be written."""

    def alter(self) -> None:
        self.objects.find(Multiplexer(0x1018, 2)).access = Access.RW


@fault("identity-has-a-fifth-entry", Defect.ACCESS_OR_SIZE, "communication.no-further-entry[1018h]")
class FifthEntry(AlteredNode):
    """Serves a sub-index 05h of its identity."""

    def alter(self) -> None:
        entry = Entry(bytes(4), DataType.UNSIGNED32, Access.CONST)
        self.objects.add({Multiplexer(0x1018, 5): entry})
