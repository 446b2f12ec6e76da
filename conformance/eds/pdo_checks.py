"""PDOs in a description: their parameters, and what they map (CiA 301, 7.5.2.35 to 7.5.2.38)."""

import re
from collections.abc import Iterator
from dataclasses import replace

from conformance.device.eds_listing import ListedObject, Listing
from conformance.eds import rules
from conformance.eds.findings import Findings, Place
from conformance.eds.object_checks import place_of
from conformance.eds.text import Sections
from conformance.eds.values import number_of, parse_number, quoted
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType
from conformance.sdo.pdos import (
    DUMMIES,
    MAPPING_OF,
    MOST_BITS,
    MOST_MAPPED,
    RECEIVED,
    RECEIVED_MAPPINGS,
    SENT,
    Mapped,
    is_mapping,
    is_multiplexed,
)

# No device can have what breaks one of them.
IMPOSSIBLE = (rules.MAPPED_OBJECT, rules.MAPPED_ACCESS, rules.MAPPED_LENGTH)
_DUMMY = re.compile(r"Dummy0*([1-9a-f][0-9a-f]?)", re.IGNORECASE)


def check_pdos(sections: Sections, listing: Listing, findings: Findings) -> Listing:
    """Check what the PDOs of a device are.

    Return the listing without the mappings that no device could have: no case compares them.
    """
    _check_pairs(sections, listing, findings)
    allowed = _dummies(sections, findings)
    objects = dict(listing.objects)
    for index, listed in listing.objects.items():
        if not is_mapping(index):
            continue
        before = findings.count(IMPOSSIBLE)
        _check_mapping(sections, listing, listed, allowed, findings)
        if findings.count(IMPOSSIBLE) > before:
            entries = {
                sub: replace(known, default=None, configured=None)
                for sub, known in listed.entries.items()
            }
            objects[index] = replace(listed, entries=entries, unclear=listed.unclear | {0})
    return replace(listing, objects=objects)


def _check_pairs(sections: Sections, listing: Listing, findings: Findings) -> None:
    info = sections.get("DeviceInfo")
    for area, name, key in ((RECEIVED, "RPDO", "NrOfRXPDO"), (SENT, "TPDO", "NrOfTXPDO")):
        count = 0
        for index in area:
            parts = (index, index + MAPPING_OF)
            there = [part for part in parts if part in listing.objects]
            count += bool(there)
            if len(there) == 1:
                missing = next(part for part in parts if part not in there)
                sentence = f"{name} {index - area.start + 1} has {there[0]:04X}h and no"
                place = place_of(sections, Multiplexer(there[0]))
                findings.add(rules.PDO_PAIR, place, f"{sentence} {missing:04X}h")
        written = parse_number(info.text(key), 0) if info else None
        if info and written and written.number != count:
            sentence = f"{quoted(key, info.text(key))}, and {count} are described"
            findings.add(rules.PDO_COUNT, info.at(key), sentence)


def _dummies(sections: Sections, findings: Findings) -> frozenset[int]:
    """Return the types that an RPDO may map as dummies."""
    section = sections.get("DummyUsage")
    allowed = set()
    for key, value in section.values.items() if section else ():
        match = _DUMMY.fullmatch(key)
        written = parse_number(value.text, 0)
        is_right = match and written and written.number in (0, 1)
        if section and not is_right:
            sentence = f"{quoted(key, value.text)} is no line as Dummy0005=1"
            findings.add(rules.DUMMY_USAGE, section.at(key), sentence, "It is left out")
        if match and written and written.number == 1:
            allowed.add(int(match[1], 16))
    return frozenset(allowed)


def _check_mapping(
    sections: Sections,
    listing: Listing,
    listed: ListedObject,
    allowed: frozenset[int],
    findings: Findings,
) -> None:
    bits = 0
    for place, mapped in _mapped(sections, listed):
        bits += mapped.bits
        if mapped.mux.index in DUMMIES:
            if listed.index not in RECEIVED_MAPPINGS:
                sentence = f"a TPDO maps the dummy {mapped.mux.index:04X}h"
                findings.add(rules.MAPPED_OBJECT, place, sentence)
            elif mapped.mux.index not in allowed:
                sentence = f"[DummyUsage] does not allow the dummy {mapped.mux.index:04X}h"
                findings.add(rules.DUMMY, place, sentence)
            continue
        _check_mapped(listing, listed.index, mapped, place, findings)
    if bits > MOST_BITS:
        place = place_of(sections, Multiplexer(listed.index))
        sentence = f"{listed.index:04X}h maps {bits} bits"
        findings.add(rules.MAPPED_LENGTH, place, sentence)


def _check_mapped(
    listing: Listing, index: int, mapped: Mapped, place: Place, findings: Findings
) -> None:
    """See that what is mapped is there, has this length, and may be mapped."""
    known = listing.find(mapped.mux)
    if known is None:
        listed = listing.objects.get(mapped.mux.index)
        if listed is None or listed.entries:
            sentence = f"{mapped.mux} is mapped, and not described"
            findings.add(rules.MAPPED_OBJECT, place, sentence)
        return
    length = 1 if known.data_type is DataType.BOOLEAN else 8 * (known.length or 0)
    if known.length is not None and mapped.bits not in (length, 8 * known.length):
        sentence = f"{mapped} are mapped, which has {length}"
        findings.add(rules.MAPPED_OBJECT, place, sentence)
    if known.mappable is False:
        sentence = f"{mapped.mux} is mapped, and has PDOMapping=0"
        findings.add(rules.MAPPED_ACCESS, place, sentence)
    is_received = index in RECEIVED_MAPPINGS
    if not (known.access.writable if is_received else known.access.readable):
        kind = "an RPDO" if is_received else "a TPDO"
        sentence = f"{kind} maps {mapped.mux}, which is {known.access}"
        findings.add(rules.MAPPED_ACCESS, place, sentence)


def _mapped(sections: Sections, listed: ListedObject) -> Iterator[tuple[Place, Mapped]]:
    """Yield what a PDO maps by default."""
    count = listed.entries.get(0)
    stated = count.stated if count else None
    if stated is not None and is_multiplexed(Multiplexer(listed.index), stated):
        return
    most = stated[0] if stated else MOST_MAPPED
    for sub in range(1, min(most, MOST_MAPPED) + 1):
        known = listed.entries.get(sub)
        number = number_of(known.data_type, known.stated) if known else None
        if known and isinstance(number, int) and number:
            key = "DefaultValue" if known.configured is None else "ParameterValue"
            yield place_of(sections, known.mux, key), Mapped.of(number)
