"""A device made of an EDS: it has what is listed, with the default values, and nothing else."""

from conformance.device.eds_listing import Listing
from conformance.device.known_objects import KnownObject
from conformance.device.numbers import encode_number, is_number
from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry, ObjectDictionary
from conformance.sdo.storage_commands import COMMANDS, SIGNATURES, command_entry, signature_of

IDENTITY = 0x1018
WITHOUT_VALUE = b"none"


def described_device(listing: Listing) -> ObjectDictionary:
    """Return an object dictionary that an EDS describes; its error list is empty."""
    entries = {known.mux: _entry(known, listing) for known in listing.entries}
    for mux, entry in entries.items():
        if mux.index == ERROR_LIST:
            entry.value = bytes(len(entry.value))
            entry.has_data = mux.sub_index == 0
    return ObjectDictionary(entries)


def _entry(known: KnownObject, listing: Listing) -> Entry:
    is_part = known.mux.index in COMMANDS and known.mux.sub_index > 0 and known.access.writable
    if is_part or known.mux in SIGNATURES:
        return command_entry(signature_of(known.mux))
    data_type = known.data_type or DataType.DOMAIN
    return Entry(_value(known, listing), data_type, known.access, known.low, known.high)


def _value(known: KnownObject, listing: Listing) -> bytes:
    value = known.stated
    if known.mux.index == IDENTITY and known.mux.sub_index in listing.identity:
        return listing.identity[known.mux.sub_index].to_bytes(4, "little")
    if value is not None:
        return value
    if known.mux == Multiplexer(known.mux.index) and listing.objects[known.mux.index].is_structured:
        return bytes([listing.objects[known.mux.index].highest])
    if known.length is None:
        return WITHOUT_VALUE
    if known.low is not None and known.data_type is not None and is_number(known.data_type):
        return encode_number(known.data_type, known.low)
    return bytes(known.length)
