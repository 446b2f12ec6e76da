"""EDS and DCF files: what they list, read with the importer of canopen (CiA 306-1)."""

import configparser
import io
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from canopen.objectdictionary import ObjectDictionary as Imported
from canopen.objectdictionary import ODArray, ODRecord, ODVariable, import_od

from conformance.device.eds_listing import ListedObject, Listing, ObjectType
from conformance.device.eds_text import (
    INFO_KEYS,
    Section,
    object_of,
    parse_number,
    read_eds_text,
    sections_of,
)
from conformance.device.files import FileError, shortened
from conformance.device.known_objects import KnownObject
from conformance.device.numbers import Number, decode_number, encode_number, is_number
from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nearest import did_you_mean
from conformance.sdo.objects import Access, DataType

MOST_COMPACT = 0xFE
MOST_ENTRIES = 0x10000
# The objects that describe types of the device, and none at all: no server reads them.
_NO_OBJECTS = (0x00, 0x05, 0x06)
_ACCESS = {access.value: access for access in Access} | {"rwr": Access.RW, "rww": Access.RW}
_PROCESS_DATA = ("rwr", "rww")
_TYPES = frozenset(DataType)
_OBJECT_TYPES = frozenset(ObjectType)


def read_eds(path: Path, node_id: int) -> Listing:
    """Return what an EDS or a DCF lists of the node; ``$NODEID`` stands for ``node_id``.

    Raises FileError.
    """
    return parse_eds(path, read_eds_text(path), node_id)


def parse_eds(path: Path, text: str, node_id: int) -> Listing:
    """Return what the text of an EDS lists; raises FileError with the name of its file."""
    sections = sections_of(path, text)
    heads = {
        index: section
        for name, section in sections.items()
        if (found := object_of(name)) and found[1] is None and not _is_type(section, node_id)
        for index in (found[0],)
    }
    _count_entries(sections, heads, node_id)
    imported = _import(path, "\n".join(_plain_text(sections, heads, node_id)), node_id)
    objects = {
        index: _listed(imported, sections, section, index, node_id)
        for index, section in heads.items()
    }
    if 0x1000 not in objects:
        raise FileError(path, None, "there is no section [1000], the device type of every device.")
    device = imported.device_information
    said = (device.vendor_number, device.product_number, device.revision_number)
    identity = {sub: number for sub, number in enumerate(said, 1) if number is not None}
    revision = _revision(sections["FileInfo"]) if "FileInfo" in sections else ""
    return Listing(objects, is_complete=True, identity=identity, revision=revision)


def _revision(info: Section) -> str:
    """Return version and revision of the file, as far as it states them (CiA 306-1, FileInfo)."""
    stated = (info.text("FileVersion"), info.text("FileRevision"))
    return ".".join(part for part in stated if part)


def _count_entries(
    sections: Mapping[str, Section], heads: Mapping[int, Section], node_id: int
) -> None:
    """Raise FileError where there is more than a device can have and a run can test."""
    own = sum(bool(found and found[1] is not None) for found in map(object_of, sections))
    count = own + len(heads)
    for section in heads.values():
        if section.text("CompactSubObj"):
            count += _compact(section, node_id)
        if count > MOST_ENTRIES:
            raise section.error(
                f"so far the file lists {count} entries, by sections and by CompactSubObj; more "
                f"than {MOST_ENTRIES} cannot be tested: is it the right one?"
            )


def _is_type(section: Section, node_id: int) -> bool:
    return section.number("ObjectType", node_id, ObjectType.VAR) in _NO_OBJECTS


# What canopen is given: the same in one spelling, in the order that it needs, and nothing else


def _plain_text(
    sections: Mapping[str, Section], heads: Mapping[int, Section], node_id: int
) -> Iterator[str]:
    yield "[DeviceInfo]"
    info = sections["DeviceInfo"]
    for key in INFO_KEYS:
        number = info.number(key, node_id)
        if number is not None:
            yield f"{key}={number}"
    by_index: dict[int, list[tuple[int, Section]]] = {index: [] for index in heads}
    for name, section in sections.items():
        found = object_of(name)
        if found is None or found[1] is None:
            continue
        if found[0] in by_index:
            by_index[found[0]].append((found[1], section))
        elif f"{found[0]:04X}" not in sections:
            raise section.error(f"[{name}] belongs to an object without a section [{name[:4]}].")
    for index, section in sorted(heads.items()):
        yield from _object_text(section, bool(by_index[index]), node_id)
        for _, sub in sorted(by_index[index], key=lambda item: item[0]):
            yield f"[{sub.name}]"
            yield from _entry_text(sub, node_id)


def _object_text(section: Section, has_subs: bool, node_id: int) -> Iterator[str]:
    kind = _object_type(section, node_id)
    yield f"[{section.name}]"
    if kind in (ObjectType.VAR, ObjectType.DOMAIN):
        yield f"ObjectType={kind}"
        yield from _entry_text(section, node_id, kind)
    elif _compact(section, node_id):
        yield f"ObjectType={ObjectType.ARRAY}"
        yield "CompactSubObj=1"
        yield from _entry_text(section, node_id)
    elif has_subs:
        yield f"ObjectType={kind}"
        yield "ParameterName=" + (section.text("ParameterName") or section.name)
    else:
        raise section.error(
            f"[{section.name}] is an {kind.name} and has neither sections [{section.name}sub0] and "
            "so on nor CompactSubObj."
        )


def _object_type(section: Section, node_id: int) -> ObjectType:
    number = section.number("ObjectType", node_id, ObjectType.VAR)
    if number not in _OBJECT_TYPES:
        raise section.error(
            f"ObjectType={shortened(section.text('ObjectType'))} is none of 0x2 (DOMAIN), 0x7 "
            "(VAR), 0x8 (ARRAY) and 0x9 (RECORD).",
            "ObjectType",
        )
    return ObjectType(number)


def _compact(section: Section, node_id: int) -> int:
    """Return to which sub-index one description counts; 0 when each has its own."""
    number = section.number("CompactSubObj", node_id, 0) or 0
    if not 0 <= number <= MOST_COMPACT:
        raise section.error(f"CompactSubObj goes up to {MOST_COMPACT}.", "CompactSubObj")
    return number


def _entry_text(section: Section, node_id: int, kind: ObjectType = ObjectType.VAR) -> Iterator[str]:
    yield "ParameterName=" + (section.text("ParameterName") or section.name)
    access = section.text("AccessType").lower()
    if not access and kind is ObjectType.DOMAIN:
        access = "rw"
    elif (access or section.require("AccessType")) not in _ACCESS:
        raise section.error(
            f"AccessType={shortened(section.text('AccessType'))} is unknown. "
            f"{did_you_mean(access, _ACCESS)}",
            "AccessType",
        )
    yield f"AccessType={access}"
    data_type = _data_type(section, node_id, kind)
    yield f"DataType={DataType.DOMAIN if data_type is None else data_type:#x}"
    for key in ("DefaultValue", "ParameterValue"):
        text = section.text(key)
        if text and data_type is not None:
            yield f"{key}={_plain_value(section, key, data_type, node_id)}"


def _data_type(section: Section, node_id: int, kind: ObjectType) -> DataType | None:
    """Return the type of an entry; None for one that the device itself defines."""
    if kind is ObjectType.DOMAIN and not section.text("DataType"):
        return DataType.DOMAIN
    section.require("DataType")
    code = section.number("DataType", node_id) or 0
    if code in _TYPES:
        return DataType(code)
    if not 0x20 <= code <= 0x25F:
        raise section.error(
            f"DataType={shortened(section.text('DataType'))} is no data type: 0x5 is UNSIGNED8, "
            "0x6 UNSIGNED16, 0x7 UNSIGNED32, 0x9 VISIBLE_STRING.",
            "DataType",
        )
    return None


def _plain_value(section: Section, key: str, data_type: DataType, node_id: int) -> str:
    text = section.text(key)
    if data_type.length is None or data_type in (DataType.REAL32, DataType.REAL64):
        return text
    number = parse_number(text, node_id)
    if number is None:
        raise section.error(f"{key}={shortened(text)} is no {data_type.name}.", key)
    return str(number)


class _NamedText(io.StringIO):
    """What ``import_od`` takes for a file: the end of its name says what it is."""

    name = "device.eds"


def _import(path: Path, text: str, node_id: int) -> Imported:
    try:
        return import_od(_NamedText(text), node_id)
    except (ValueError, LookupError, OverflowError, configparser.Error) as error:
        raise FileError(path, None, f"canopen cannot read the file: {error}") from error


# What canopen has read, and beside it what it leaves out


def _listed(
    imported: Imported,
    sections: Mapping[str, Section],
    section: Section,
    index: int,
    node_id: int,
) -> ListedObject:
    kind = _object_type(section, node_id)
    found = imported[index]
    if isinstance(found, ODVariable):
        entries = {0: _entry(found, section, 0, node_id)}
    elif count := _compact(section, node_id):
        entries = _compact_entries(found, sections, section, count, node_id)
    else:
        entries = {
            sub: _entry(variable, sections[f"{index:04X}sub{sub:X}"], sub, node_id)
            for sub, variable in found.items()
        }
    type_code = section.number("DataType", node_id)
    return ListedObject(index, kind, entries, section.text("ParameterName"), type_code)


def _compact_entries(
    found: ODArray | ODRecord,
    sections: Mapping[str, Section],
    section: Section,
    count: int,
    node_id: int,
) -> dict[int, KnownObject]:
    """Return the entries of an object of which one description serves for all sub-indices."""
    # By CiA 306-1 sub-index 0 is read-only then; that of 1003h is not, by CiA 301.
    access = Access.RW if found.index == ERROR_LIST else Access.RO
    number = KnownObject(
        Multiplexer(found.index), DataType.UNSIGNED8, access, default=bytes([count])
    )
    names = sections.get(f"{section.name}Name")
    entries = {0: number}
    described = _entry(found[1], section, 1, node_id)
    for sub in range(1, count + 1):
        name = (names.text(str(sub)) if names else "") or described.name
        entries[sub] = replace(described, mux=Multiplexer(found.index, sub), name=name)
    return entries


def _entry(variable: ODVariable, section: Section, sub_index: int, node_id: int) -> KnownObject:
    kind = ObjectType.VAR
    if object_of(section.name) == (variable.index, None) and not sub_index:
        kind = _object_type(section, node_id)
    data_type = _data_type(section, node_id, kind)
    low = _limit(section, "LowLimit", data_type, node_id)
    high = _limit(section, "HighLimit", data_type, node_id)
    if low is not None and high is not None and low > high:
        raise section.error(f"LowLimit {low} is above HighLimit {high}.", "LowLimit")
    return KnownObject(
        Multiplexer(variable.index, sub_index),
        data_type,
        _ACCESS[variable.access_type],
        name=section.text("ParameterName"),
        low=low,
        high=high,
        default=_value(variable.default, section, "DefaultValue", data_type),
        configured=_value(variable.value, section, "ParameterValue", data_type),
        flags=section.number("ObjFlags", node_id, 0) or 0,
        mappable=_mappable(section, variable.access_type, node_id),
        floats=variable.access_type == "rwr",
    )


def _mappable(section: Section, access: str, node_id: int) -> bool | None:
    """Return what PDOMapping says; None where it is left out, or contradicts the access.

    An entry that is rwr or rww holds process data.
    """
    number = section.number("PDOMapping", node_id)
    if number is None or (not number and access in _PROCESS_DATA):
        return None
    return bool(number)


def _limit(section: Section, key: str, data_type: DataType | None, node_id: int) -> Number | None:
    """Return a limit: canopen leaves out those of most types, and formulas."""
    text = section.text(key)
    if not text or data_type is None or not is_number(data_type):
        return None
    number: Number | None = parse_number(text, node_id)
    if data_type in (DataType.REAL32, DataType.REAL64):
        try:
            number = float(text)
        except ValueError:
            number = None
        if number is not None and not math.isfinite(number):
            number = None
    try:
        if number is None:
            raise OverflowError("write a number, as 10, 0x0A or $NODEID+0x180")
        data = encode_number(data_type, number)
    except OverflowError as error:
        raise section.error(
            f"{key}={shortened(text)} is no {data_type.name}: {error}.", key
        ) from None
    return decode_number(data_type, data)


def _value(value: object, section: Section, key: str, data_type: DataType | None) -> bytes | None:
    """Return a value as it goes over the wire; None where there is none to compare."""
    if data_type is None or value is None:
        return None
    if isinstance(value, str):
        encoding = "utf-16-le" if data_type is DataType.UNICODE_STRING else "latin-1"
        return value.encode(encoding, "replace")
    if isinstance(value, bytes | bytearray):
        return bytes(value)
    if not isinstance(value, int | float):
        return None
    try:
        return encode_number(data_type, value)
    except OverflowError as error:
        raise section.error(f"{key}={shortened(section.text(key))}: {error}.", key) from None
