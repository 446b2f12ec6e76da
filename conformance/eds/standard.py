"""What CiA 301 fixes of the objects at 1000h to 1BFFh, whatever a file says of them.

A device follows the specification, so a case is about what that says; a file that says something
else is wrong, and no case compares what it states.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from conformance.device.known_objects import KnownObject
from conformance.device.numbers import Number, encode_number
from conformance.eds import rules
from conformance.eds.findings import EdsRule, Findings
from conformance.eds.text import Section
from conformance.eds.values import number_of
from conformance.sdo.cob_id import ChannelIds, CobId
from conformance.sdo.fixed_objects import FixedEntry, entry_at, is_forbidden
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import EMERGENCY_BASE
from conformance.sdo.objects import Access, DataType
from conformance.sdo.pdos import COB_ID, RESERVED_TYPES, TRANSMISSION_TYPE, is_communication

SYNC, TIME, EMERGENCY = Multiplexer(0x1005), Multiplexer(0x1012), Multiplexer(0x1014)
SYNC_ID = 0x080
VENDOR_ID = Multiplexer(0x1018, 1)
FIRST_CHANNEL = 0x1200
FURTHER_CHANNELS = range(0x1201, 0x1280)
NOT_COMPARED = "No case compares it"


@dataclass(frozen=True, slots=True)
class Standard:
    """Holds the entries of one file against CiA 301, for one node."""

    findings: Findings
    node_id: int

    def entry(self, known: KnownObject, section: Section) -> KnownObject | None:
        """Return an entry as CiA 301 has it; None for one that it forbids."""
        if is_forbidden(known.mux):
            sentence = f"CiA 301 has no {known.mux}"
            made = "No case is about the entry"
            self.findings.add(rules.STANDARD_SUB_INDEX, section.at(), sentence, made)
            return None
        fixed = entry_at(known.mux)
        if fixed is None:
            return known
        return self._with_right_value(self._with_right_type(known, fixed, section), section)

    def _with_right_type(
        self, known: KnownObject, fixed: FixedEntry, section: Section
    ) -> KnownObject:
        due = fixed.data_type
        if due is not None and known.data_type is not due:
            name = known.data_type.name if known.data_type else "of another type"
            sentence = f"{known.mux} is {name}, and {due.name} in CiA 301"
            made = f"It is read as {due.name}"
            self.findings.add(rules.STANDARD_TYPE, section.at("DataType"), sentence, made)
            default = _as(due, number_of(known.data_type, known.default))
            configured = _as(due, number_of(known.data_type, known.configured))
            known = replace(
                known, data_type=due, default=default, configured=configured, low=None, high=None
            )
        if known.access.writable and not fixed.access.writable:
            sentence = f"{known.mux} is {known.access}, and {fixed.access} in CiA 301"
            made = "It is read as ro"
            self.findings.add(rules.STANDARD_ACCESS, section.at("AccessType"), sentence, made)
            known = replace(known, access=Access.RO)
        return known

    def _with_right_value(self, known: KnownObject, section: Section) -> KnownObject:
        """Return an entry without the values that it cannot have."""
        number = number_of(known.data_type, known.stated)
        wrong = self._wrong(known.mux, number) if isinstance(number, int) else None
        if wrong is None:
            return known
        rule, why = wrong
        key = "DefaultValue" if known.configured is None else "ParameterValue"
        sentence = f"{known.mux} has {number:X}h, {why}"
        self.findings.add(rule, section.at(key), sentence, NOT_COMPARED)
        return replace(known, default=None, configured=None)

    def _wrong(self, mux: Multiplexer, number: int) -> tuple[EdsRule, str] | None:
        """Return the rule that a number breaks, and why."""
        if mux == VENDOR_ID:
            return None if number else (rules.VENDOR_ID, "which is the vendor-ID of nobody")
        if mux.sub_index == TRANSMISSION_TYPE and is_communication(mux.index):
            is_reserved = number in RESERVED_TYPES
            return (rules.TRANSMISSION_TYPE, "which is reserved") if is_reserved else None
        check = self._cob_ids(mux)
        why = check(CobId.from_bytes(number.to_bytes(4, "little"))) if check else ""
        return (rules.COB_ID, why) if why else None

    def _cob_ids(self, mux: Multiplexer) -> Callable[[CobId], str] | None:
        """Return what says why a COB-ID is wrong at a place; None for what is no COB-ID."""
        ids = ChannelIds.default(self.node_id)
        if mux.index == FIRST_CHANNEL and mux.sub_index in (1, 2):
            due = ids.request if mux.sub_index == 1 else ids.response
            return lambda cob_id: "" if cob_id == due else f"and is {due} of this node"
        if mux == SYNC:
            return lambda cob_id: _predefined(cob_id, SYNC_ID)
        if mux == EMERGENCY:
            return lambda cob_id: _predefined(cob_id, EMERGENCY_BASE + self.node_id)
        is_channel = mux.index in FURTHER_CHANNELS and mux.sub_index in (1, 2)
        is_pdo = mux.sub_index == COB_ID and is_communication(mux.index)
        if mux == TIME or is_channel or is_pdo:
            return _free
        return None


def _as(data_type: DataType, number: Number | None) -> bytes | None:
    """Return a number in another type; None where that does not hold it."""
    if not isinstance(number, int) or data_type.length is None:
        return None
    try:
        return encode_number(data_type, number)
    except OverflowError:
        return None


def _predefined(cob_id: CobId, due: int) -> str:
    if cob_id.can_id == due and not cob_id.extended:
        return ""
    return f"and {due:03X}h by the predefined connection set"


def _free(cob_id: CobId) -> str:
    """Say why neither TIME nor a PDO nor a further channel may have a COB-ID; empty if they may."""
    if cob_id.has_stray_bits:
        return "with bits 11 to 28 of a CAN-ID of 11 bits"
    if cob_id.valid and cob_id.is_restricted:
        return "which belongs to another service"
    return ""
