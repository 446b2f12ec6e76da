"""The EDS of the built-in device, written from its object dictionary, and what it permits."""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from conformance.device.eds_listing import Listing, ObjectType
from conformance.device.numbers import decode_number, is_number
from conformance.device.permits import Permits
from conformance.device.protected_objects import PERMISSIONS
from conformance.eds.reading import parse_eds
from conformance.reference.built_in_device import REFERENCE_OBJECTS
from conformance.reference.communication import EMERGENCY, RECEIVED, SENT, is_mappable
from conformance.reference.dictionary import GAPPY
from conformance.reference.node import Node
from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry

# COB-IDs, which every node has others of.
_FORMULAS = {
    EMERGENCY: "$NODEID+0x80",
    Multiplexer(RECEIVED, 1): "$NODEID+0x200",
    Multiplexer(SENT, 1): "$NODEID+0x40000180",
    Multiplexer(0x1200, 1): "$NODEID+0x600",
    Multiplexer(0x1200, 2): "$NODEID+0x580",
}
_TYPE_CODES = {0x1018: 0x23, 0x1200: 0x22, 0x1280: 0x22}


def listing_of(node: Node) -> Listing:
    """Return what the EDS of a built-in device lists."""
    return _parsed(eds_of(node), node.node_id)


@lru_cache(16)
def _parsed(text: str, node_id: int) -> Listing:
    """Parse an EDS once: a process that tests many servers meets the same device each time."""
    return parse_eds(Path("reference.eds"), text, node_id).listing


def permits_for(node: Node) -> Permits:
    """Return what the user of a built-in device would permit: everything that is there."""
    there = dict(node.objects.items())
    named = tuple(
        replace(known, data_type=there[known.mux].data_type)
        for known in REFERENCE_OBJECTS
        if known.mux in there
    )
    return Permits(named, all_rw=True, permissions=PERMISSIONS)


def eds_of(node: Node) -> str:
    """Return the EDS of a built-in device that has just been built."""
    return eds_text(dict(node.objects.items()))


def eds_text(entries: dict[Multiplexer, Entry]) -> str:
    """Return an EDS of these entries."""
    return "\n".join(_lines(entries))


def _lines(entries: dict[Multiplexer, Entry]) -> Iterator[str]:
    by_index: defaultdict[int, dict[int, Entry]] = defaultdict(dict)
    for mux, entry in sorted(entries.items()):
        by_index[mux.index][mux.sub_index] = entry
    yield "[DeviceInfo]"
    for sub_index, key in enumerate(("VendorNumber", "ProductNumber", "RevisionNumber"), 1):
        number = entries.get(Multiplexer(0x1018, sub_index))
        if number is not None:
            yield f"{key}={int.from_bytes(number.value, 'little'):#x}"
    mandatory = [index for index in by_index if index in (0x1000, 0x1001, 0x1018)]
    own = [index for index in by_index if index >= 0x2000]
    optional = [index for index in by_index if index not in mandatory and index not in own]
    for name, indices in (("Mandatory", mandatory), ("Optional", optional), ("Manufacturer", own)):
        yield f"[{name}Objects]"
        yield f"SupportedObjects={len(indices)}"
        yield from (f"{number}={index:#06x}" for number, index in enumerate(indices, 1))
    for index, subs in by_index.items():
        yield f"[{index:04X}]"
        if list(subs) == [0]:
            yield from _entry_lines(Multiplexer(index), subs[0])
            continue
        kind = ObjectType.ARRAY if index in (ERROR_LIST, GAPPY) else ObjectType.RECORD
        type_code = (
            subs[max(subs)].data_type if kind is ObjectType.ARRAY else _TYPE_CODES.get(index)
        )
        yield f"ParameterName=Object {index:04X}"
        yield f"ObjectType={kind:#x}"
        yield f"SubNumber={len(subs)}"
        if type_code is not None:
            yield f"DataType={type_code:#06x}"
        for sub_index, entry in subs.items():
            yield f"[{index:04X}sub{sub_index:X}]"
            yield from _entry_lines(Multiplexer(index, sub_index), entry)


def _entry_lines(mux: Multiplexer, entry: Entry) -> Iterator[str]:
    data_type = entry.data_type
    kind = ObjectType.DOMAIN if data_type is DataType.DOMAIN else ObjectType.VAR
    yield f"ParameterName=Entry {mux}"
    yield f"ObjectType={kind:#x}"
    yield f"DataType={data_type:#06x}"
    yield f"AccessType={entry.access}"
    yield f"PDOMapping={is_mappable(mux, entry):d}"
    yield f"DefaultValue={_FORMULAS.get(mux) or _text(data_type, entry.value)}"
    if entry.low is not None:
        yield f"LowLimit={entry.low}"
    if entry.high is not None:
        yield f"HighLimit={entry.high}"


def _text(data_type: DataType, value: bytes) -> str:
    if data_type is DataType.VISIBLE_STRING:
        return value.decode("ascii")
    if data_type is DataType.UNICODE_STRING:
        return value.decode("utf-16-le").replace("\0", "")
    if is_number(data_type):
        return str(decode_number(data_type, value))
    return value.hex() if data_type.length is None else str(int.from_bytes(value, "little"))
