"""The object dictionary of the built-in device beyond what its transfers need: all that may lie in
one, so that cases on the object dictionary have something to look at."""

from collections.abc import Container

from conformance.device.numbers import encode_number
from conformance.reference.built_in_device import UNSIGNED, reference_entries
from conformance.reference.communication import communication_entries
from conformance.reference.communication_values import value_entries
from conformance.sdo.cob_id import CobId
from conformance.sdo.emergency import ErrorCode, error_list
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry, ObjectDictionary
from conformance.sdo.pdos import Mapped
from conformance.sdo.storage_commands import (
    APPLICATION_PART,
    COMMANDS,
    command_entry,
    signature_of,
)

IDENTITY = 0x1018
CLIENT, LIMITED, GAPPY, TYPES, MEASURED = 0x1280, 0x2100, 0x2110, 0x2120, 0x2130
CONTROLLED = Multiplexer(0x2004)
STORED_EDS = Multiplexer(0x1021)
ERROR_CODE = Multiplexer(0x2140)
PLACES_FOR_ERRORS = 2
EDS = b"""[FileInfo]
FileName=reference.eds
FileVersion=1

[DeviceInfo]
VendorNumber=0x5D0C0000
ProductNumber=0x5D0C0F0E

[MandatoryObjects]
SupportedObjects=3
1=0x1000
2=0x1001
3=0x1018
"""


def all_entries(node_id: int, lacking: Container[Multiplexer] = ()) -> dict[Multiplexer, Entry]:
    """Return the entries of the built-in device, all but those that it is to lack."""
    entries = reference_entries(node_id) | _limited() | _gappy() | _types() | _measured()
    entries |= _errors() | _commands() | _client()
    entries |= communication_entries(
        node_id, Mapped(CONTROLLED, bits=32), Mapped(Multiplexer(MEASURED), bits=32)
    )
    entries |= value_entries()
    entries[STORED_EDS] = Entry(EDS, DataType.DOMAIN, Access.RO)
    left = {mux: entry for mux, entry in entries.items() if mux not in lacking}
    identity = [mux.sub_index for mux in left if mux.index == IDENTITY]
    left[Multiplexer(IDENTITY)].value = bytes([max(identity)])
    return left


def reference_device(node_id: int, lacking: Container[Multiplexer] = ()) -> ObjectDictionary:
    """Return the object dictionary of the built-in device."""
    return ObjectDictionary(all_entries(node_id, lacking))


def _errors() -> dict[Multiplexer, Entry]:
    """Return what has to do with errors, of which there are none until one is written."""
    return {**error_list(PLACES_FOR_ERRORS), ERROR_CODE: ErrorCode.none()}


def _limited() -> dict[Multiplexer, Entry]:
    """Return a record of numbers with limits."""
    numbers = (
        (DataType.UNSIGNED8, 50, 10, 100),
        (DataType.INTEGER16, -5, -100, 100),
        (DataType.UNSIGNED32, 1500, 1000, 2000),
        (DataType.INTEGER24, 0, -1_000_000, 1_000_000),
        (DataType.INTEGER64, 1, -(1 << 40), 1 << 40),
        (DataType.UNSIGNED16, 7, None, 1000),
        (DataType.REAL32, 1.5, -2.5, 10.0),
    )
    entries = {
        Multiplexer(LIMITED, sub): Entry(
            encode_number(data_type, value), data_type, low=low, high=high
        )
        for sub, (data_type, value, low, high) in enumerate(numbers, 1)
    }
    return _with_count(LIMITED, entries)


def _gappy() -> dict[Multiplexer, Entry]:
    """Return an array without its sub-index 3."""
    return _with_count(
        GAPPY,
        {
            Multiplexer(GAPPY, sub): Entry(sub.to_bytes(2, "little"), DataType.UNSIGNED16)
            for sub in (1, 2, 4)
        },
    )


def _types() -> dict[Multiplexer, Entry]:
    """Return a record with an entry of each type that is nowhere else."""
    elsewhere = {*UNSIGNED.values(), DataType.DOMAIN, DataType.VISIBLE_STRING}
    types = [data_type for data_type in DataType if data_type not in elsewhere]
    entries = {
        Multiplexer(TYPES, sub): Entry(bytes(data_type.length or 4), data_type)
        for sub, data_type in enumerate(types, 1)
    }
    return _with_count(TYPES, entries)


def _measured() -> dict[Multiplexer, Entry]:
    """Return what only the device itself changes."""
    return {
        Multiplexer(MEASURED): Entry(b"\x11\x22\x33\x44", DataType.UNSIGNED32, Access.RO),
        Multiplexer(MEASURED + 1): Entry(b"measured", DataType.OCTET_STRING, Access.RO),
    }


def _commands() -> dict[Multiplexer, Entry]:
    """Return what stores all parameters, or a part of them, and loads their defaults."""
    entries: dict[Multiplexer, Entry] = {}
    for index in COMMANDS:
        parts = [Multiplexer(index, sub) for sub in range(1, APPLICATION_PART + 1)]
        entries |= _with_count(index, {mux: command_entry(signature_of(mux)) for mux in parts})
    return entries


def _client() -> dict[Multiplexer, Entry]:
    """Return the parameter of a channel in which the device is the client, not in use."""
    unused = bytes(CobId(0, valid=False))
    return _with_count(
        CLIENT,
        {
            Multiplexer(CLIENT, 1): Entry(unused, DataType.UNSIGNED32),
            Multiplexer(CLIENT, 2): Entry(unused, DataType.UNSIGNED32),
            Multiplexer(CLIENT, 3): Entry(b"\1", DataType.UNSIGNED8, low=1, high=127),
        },
    )


def _with_count(index: int, entries: dict[Multiplexer, Entry]) -> dict[Multiplexer, Entry]:
    highest = max(mux.sub_index for mux in entries)
    count = Entry(bytes([highest]), DataType.UNSIGNED8, Access.CONST)
    return {Multiplexer(index): count} | entries
