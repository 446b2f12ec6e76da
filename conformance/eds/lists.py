"""The lists of objects in an EDS, held against its sections (CiA 306-1, clause 6.6.2)."""

from collections.abc import Iterator

from conformance.device.files import shortened
from conformance.eds import rules
from conformance.eds.findings import Findings, Place
from conformance.eds.text import LISTS, Section, Sections, by_object
from conformance.eds.values import parse_number

MANDATORY = (0x1000, 0x1001, 0x1018)
MANUFACTURER = range(0x2000, 0x6000)
FIRST_OBJECT = 0x1000


def check_lists(sections: Sections, findings: Findings) -> None:
    """Hold the lists against the sections."""
    for name in ("FileInfo", "DeviceInfo", "MandatoryObjects"):
        if name not in sections:
            findings.add(rules.MANDATORY_SECTION, Place(), f"there is no section [{name}]")
    listed: dict[int, str] = {}
    described = by_object(sections)
    for name in LISTS:
        if name not in sections:
            continue
        for key, index in _indices(sections[name], findings):
            place = sections[name].at(key)
            if index in listed:
                sentence = f"[{listed[index]}] lists {index:04X}h already"
                findings.add(rules.LISTED_TWICE, place, sentence)
                continue
            listed[index] = name
            _check_range(name, index, place, findings)
            if index not in described and index >= FIRST_OBJECT:
                sentence = f"{index:04X}h is listed, and there is no section [{index:04X}]"
                findings.add(rules.LISTED, place, sentence, "No case is about the object")
    for index, own in described.items():
        head = own.get(None)
        if head is not None and index >= FIRST_OBJECT and index not in listed:
            sentence = f"[{head.name}] is in none of the lists"
            findings.add(rules.UNLISTED, head.at(), sentence, "It is read as if it were listed")


def listed_indices(sections: Sections) -> Iterator[int]:
    """Yield the indices of all lists."""
    for name in LISTS:
        for key, value in sections[name].values.items() if name in sections else ():
            written = parse_number(value.text, 0) if key.isdigit() else None
            if written is not None and FIRST_OBJECT <= written.number <= 0xFFFF:
                yield written.number


def _indices(section: Section, findings: Findings) -> list[tuple[str, int]]:
    """Return the indices in a list, each with its keyword."""
    found = []
    for key, value in section.values.items():
        if key == "SupportedObjects":
            continue
        written = parse_number(value.text, 0) if key.isdigit() else None
        if written is None or not 0 < written.number <= 0xFFFF:
            sentence = (
                f"{shortened(key)[1:-1]}={shortened(value.text)[1:-1]} in [{section.name}] is no "
                "entry of the list: write 1=0x1000"
            )
            findings.add(rules.LIST_ENTRY, section.at(key), sentence, "It is left out")
            continue
        found.append((key, written.number))
    count = parse_number(section.text("SupportedObjects"), 0)
    if count is None or count.number != len(found):
        stated = shortened(section.text("SupportedObjects"))[1:-1]
        sentence = f"SupportedObjects={stated}, and [{section.name}] lists {len(found)}"
        findings.add(rules.LIST_COUNT, section.at("SupportedObjects"), sentence, "All are read")
    return found


def _check_range(name: str, index: int, place: Place, findings: Findings) -> None:
    if index in MANDATORY:
        due = "MandatoryObjects"
    else:
        due = "ManufacturerObjects" if index in MANUFACTURER else "OptionalObjects"
    if name != due:
        findings.add(
            rules.LIST_RANGE, place, f"{index:04X}h stands in [{name}], and belongs to [{due}]"
        )
