"""A device made of a description: it has what is listed, with the values that are stated.

What CiA 301 defines it follows, whatever the file says: the communication would fail otherwise.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from conformance.device.eds_listing import STRUCTURE_OF_OBJECT, ListedObject, Listing
from conformance.device.known_objects import KnownObject
from conformance.device.numbers import encode_number, is_number
from conformance.reference.built_in_eds import eds_text
from conformance.reference.communication import (
    EMERGENCY,
    EVENT_DRIVEN,
    RECEIVED_BASE,
    SENT_BASE,
    SYNC,
    SYNC_ID,
    TIME,
    TIME_ID,
    always,
    cob_id_check,
    is_valid,
    sync_in_use,
    time_in_use,
    type_check,
    while_invalid,
)
from conformance.reference.communication_values import (
    CONSUMED,
    COUNTER_OVERFLOW,
    CYCLE_PERIOD,
    ERROR_BEHAVIOUR,
    check_behaviour,
    consumer_check,
    overflow_check,
)
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.channel_parameters import CLIENT, Check, CheckedEntry, anything
from conformance.sdo.cob_id import DYNAMIC, HIGHEST_NODE_ID, NOT_VALID
from conformance.sdo.emergency import ERROR_LIST, error_list
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import EMERGENCY_BASE
from conformance.sdo.objects import DataType, Entry, ObjectDictionary, Refusal
from conformance.sdo.pdos import (
    COB_ID,
    RECEIVED,
    TRANSMISSION_TYPE,
    is_communication,
    is_count_of_mapping,
    is_kept_while_valid,
)
from conformance.sdo.storage_commands import COMMANDS, command_entry, signature_of

IDENTITY, VENDOR_ID, STORED_EDS = 0x1018, Multiplexer(0x1018, 1), Multiplexer(0x1021)
DEFAULT_CHANNEL = 0x1200
CHANNELS, FURTHER_SERVERS = range(0x1201, 0x1300), range(0x1201, 0x1280)
# The first four PDOs in each direction have COB-IDs of the predefined connection set.
PREDEFINED_PDOS = 4
WITHOUT_VALUE = b"none"
SOME_VENDOR = (0x5D0C_0000).to_bytes(4, "little")


@dataclass(slots=True)
class DescribedEntry(CheckedEntry):
    """An entry with the limits of its description, and what CiA 301 asks for beside."""

    def check_limits(self, data: bytes) -> None:
        """Refuse a value outside the limits, and another than now that the check refuses."""
        Entry.check_limits(self, data)
        if data != self.value:
            self.check(self.value, data)


class DescribedObjects(ObjectDictionary):
    """An object dictionary that keeps to a description: what is not listed is never added."""

    def __init__(self, entries: dict[Multiplexer, Entry], known: Mapping[Multiplexer, KnownObject]):
        super().__init__(entries)
        self._known = known

    def add(self, entries: dict[Multiplexer, Entry]) -> None:
        """Add the entries of a node that are listed, with the value and the access stated."""
        listed = {mux: entry for mux, entry in entries.items() if mux in self._known}
        for mux, entry in listed.items():
            known = self._known[mux]
            entry.access = known.access
            if known.stated is not None and len(known.stated) == entry.data_type.length:
                entry.value = known.stated
        super().add(listed)


def described_device(listing: Listing, node_id: int) -> ObjectDictionary:
    """Return the object dictionary of a node that a description describes."""
    builder = _Builder(listing, node_id)
    return DescribedObjects(builder.entries(), {known.mux: known for known in listing.entries})


@dataclass(frozen=True, slots=True)
class _Builder:
    listing: Listing
    node_id: int

    def entries(self) -> dict[Multiplexer, Entry]:
        entries = {known.mux: self._entry(known) for known in self.listing.entries}
        for mux, entry in entries.items():
            if isinstance(entry, DescribedEntry):
                entry.check = _check(mux, entries)
        if STORED_EDS in entries:
            entries[STORED_EDS].value = eds_text(entries).encode()
        return entries

    def _entry(self, known: KnownObject) -> Entry:
        mux = known.mux
        if mux.index == ERROR_LIST and mux.sub_index != STRUCTURE_OF_OBJECT:
            entry = error_list(mux.sub_index)[mux]
            entry.access = known.access
            return entry
        if mux.index in COMMANDS and 0 < mux.sub_index < STRUCTURE_OF_OBJECT:
            entry = command_entry(signature_of(mux))
            entry.access = known.access
            return entry
        return DescribedEntry(
            self._value(known),
            known.data_type or DataType.DOMAIN,
            known.access,
            known.low,
            known.high,
            mappable=known.mappable,
        )

    def _value(self, known: KnownObject) -> bytes:
        mux, value = known.mux, known.stated
        listed = self.listing.objects[mux.index]
        if mux.sub_index == STRUCTURE_OF_OBJECT:
            return _structure(listed)
        if mux.index == IDENTITY and mux.sub_index in self.listing.identity:
            value = self.listing.identity[mux.sub_index].to_bytes(4, "little")
        if value is not None:
            return value
        if mux.sub_index == 0 and listed.is_structured:
            return b"\0" if is_count_of_mapping(mux) else bytes([max(listed.entries)])
        number = self._default_number(mux)
        if number is not None and known.length == 4:
            return number.to_bytes(4, "little")
        if mux.sub_index == TRANSMISSION_TYPE and is_communication(mux.index):
            return EVENT_DRIVEN
        if known.length is None:
            return WITHOUT_VALUE
        if known.low is not None and known.data_type is not None and is_number(known.data_type):
            return encode_number(known.data_type, known.low)
        return bytes(known.length)

    def _default_number(self, mux: Multiplexer) -> int | None:
        """Return what an object of the communication has where the description leaves it open."""
        fixed = {
            SYNC: SYNC_ID,
            TIME: NOT_VALID | TIME_ID,
            EMERGENCY: EMERGENCY_BASE + self.node_id,
            VENDOR_ID: int.from_bytes(SOME_VENDOR, "little"),
        }
        if mux in fixed:
            return fixed[mux]
        if mux.sub_index == COB_ID and is_communication(mux.index):
            number = mux.index & 0x1FF
            base = RECEIVED_BASE if mux.index in RECEIVED else DYNAMIC | SENT_BASE
            known = number < PREDEFINED_PDOS
            return base + 0x100 * number + self.node_id if known else NOT_VALID
        return NOT_VALID if mux.index in CHANNELS and mux.sub_index in (1, 2) else None


def _structure(listed: ListedObject) -> bytes:
    """Return what sub-index FFh of an object holds: its data type and its type (7.4.2)."""
    return bytes([listed.object_type]) + (listed.type_code or 0).to_bytes(3, "little")


def _check(mux: Multiplexer, entries: Mapping[Multiplexer, Entry]) -> Check:
    """Return what CiA 301 has an entry refuse."""
    cob_ids: dict[Multiplexer, Check] = {
        SYNC: cob_id_check(sync_in_use, always),
        TIME: cob_id_check(time_in_use),
        EMERGENCY: cob_id_check(is_valid),
    }
    if mux in cob_ids:
        return cob_ids[mux]
    if mux.index in FURTHER_SERVERS and mux.sub_index in (1, 2):
        return cob_id_check(is_valid)
    if is_communication(mux.index):
        cob_id = entries.get(Multiplexer(mux.index, COB_ID))
        if mux.sub_index == COB_ID:
            return cob_id_check(is_valid)
        if mux.sub_index == TRANSMISSION_TYPE:
            return type_check
        if is_kept_while_valid(mux) and cob_id is not None:
            return while_invalid(cob_id)
    return _check_of_value(mux, entries)


def _check_of_value(mux: Multiplexer, entries: Mapping[Multiplexer, Entry]) -> Check:
    if mux == COUNTER_OVERFLOW and CYCLE_PERIOD in entries:
        return overflow_check(entries[CYCLE_PERIOD])
    if mux.index == CONSUMED and mux.sub_index:
        others = [
            entry
            for other, entry in entries.items()
            if other.index == CONSUMED and other.sub_index and other != mux
        ]
        return consumer_check(others)
    if mux.index in (DEFAULT_CHANNEL, *FURTHER_SERVERS) and mux.sub_index == CLIENT:
        return _check_client
    return check_behaviour if mux.index == ERROR_BEHAVIOUR and mux.sub_index else anything


def _check_client(old: bytes, new: bytes) -> None:
    """Refuse the node-ID of a client that is none."""
    if not 1 <= new[0] <= HIGHEST_NODE_ID:
        raise Refusal(AbortCode.VALUE_INVALID)
