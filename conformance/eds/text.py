"""The text of an EDS or DCF as sections, whatever is wrong with it (CiA 306-1, clause 6.2).

Every keyword keeps its line, names get the spelling of CiA 306-1, and a line that cannot be
understood is a finding.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice

from conformance.device.files import FileError, shortened
from conformance.eds import rules
from conformance.eds.findings import Findings, Place
from conformance.sdo.nearest import nearest

# The largest devices list some 5,000 entries by sections of their own.
MOST_SECTIONS = 16_384
LONGEST_LINE = 255
OBJECT_KEYS = (
    "ParameterName",
    "ObjectType",
    "DataType",
    "AccessType",
    "DefaultValue",
    "ParameterValue",
    "LowLimit",
    "HighLimit",
    "ObjFlags",
    "SubNumber",
    "CompactSubObj",
    "PDOMapping",
    "Denotation",
    "StorageLocation",
    "UploadFile",
    "DownloadFile",
)
IDENTITY_KEYS = {1: "VendorNumber", 2: "ProductNumber", 3: "RevisionNumber"}
INFO_KEYS = (
    *IDENTITY_KEYS.values(),
    "VendorName",
    "ProductName",
    "OrderCode",
    "Granularity",
    "DynamicChannelsSupported",
    "GroupMessaging",
    "NrOfRXPDO",
    "NrOfTXPDO",
    "LSS_Supported",
    "CompactPDO",
    "SimpleBootUpMaster",
    "SimpleBootUpSlave",
)
OTHER_KEYS = ("SupportedObjects", "NrOfEntries", "FileVersion", "FileRevision", "NodeID")
NODE_ID_KEY = "NodeID"
# Spelt like that in CiA 306-1.
COMMISSIONING = "DeviceComissioning"
LISTS = ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects")
SECTIONS = (
    *LISTS,
    "FileInfo",
    "DeviceInfo",
    "DummyUsage",
    "Comments",
    COMMISSIONING,
    "DynamicChannels",
    "SupportedModules",
    "ConnectedModules",
    "StandardDataTypes",
    "Tools",
)
_CANONICAL = {name.lower(): name for name in (*OBJECT_KEYS, *INFO_KEYS, *OTHER_KEYS, *SECTIONS)}
_CANONICAL["devicecommissioning"] = COMMISSIONING
_OBJECT = re.compile(r"([0-9a-f]{4})(?:sub([0-9a-f]{1,3}))?", re.IGNORECASE)
_COMPANION = re.compile(r"([0-9a-f]{4})(name|value|denotation|objectlinks)", re.IGNORECASE)
_LIKE_AN_OBJECT = re.compile(r"[0-9][0-9a-f]{3}[a-z]", re.IGNORECASE)
_COMMENTS = (";", "#", "//")
# How many names are compared with one that is misspelt.
MOST_COMPARED = 1000


@dataclass(frozen=True, slots=True)
class Value:
    """What stands behind a keyword, and its line."""

    line: int
    text: str


@dataclass(frozen=True, slots=True)
class Section:
    """A section, its line, and its keywords in the spelling of CiA 306-1."""

    name: str
    line: int
    values: dict[str, Value] = field(default_factory=dict)

    def at(self, key: str = "") -> Place:
        """Return the place of a keyword, or that of the section."""
        value = self.values.get(key)
        return Place(value.line if value else self.line, self.name)

    def text(self, key: str) -> str:
        """Return what stands behind a keyword; empty where there is nothing."""
        value = self.values.get(key)
        return value.text if value else ""


Sections = dict[str, Section]


def object_of(name: str) -> tuple[int, int | None] | None:
    """Return index and sub-index of an object's section, None for other sections."""
    match = _OBJECT.fullmatch(name)
    if match is None:
        return None
    return int(match[1], 16), int(match[2], 16) if match[2] else None


def sections_of(text: str, findings: Findings) -> Sections:
    """Return the sections of a text by name.

    Raises FileError where there are more than any device has.
    """
    sections: Sections = {}
    section: Section | None = None
    is_skipped = False
    for line, content in _lines(text, findings):
        if content.startswith("["):
            section = _begin(line, content, sections, findings)
            is_skipped = section is None
            if len(sections) > MOST_SECTIONS:
                raise FileError(
                    findings.path,
                    line,
                    f"more than {MOST_SECTIONS} sections: no device has as many; is it the right "
                    "file?",
                )
        elif section is not None:
            _add(section, line, content, findings)
        elif not is_skipped:
            findings.add(
                rules.LINE,
                Place(line),
                f"{shortened(content)} stands before the first [section]",
                "It is left out",
            )
    _mend_names(sections, findings)
    return sections


def _lines(text: str, findings: Findings) -> Iterator[tuple[int, str]]:
    """Yield the lines that say something, whatever ends them: CR LF, LF or CR."""
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    for number, line in enumerate(text.split("\n"), 1):
        content = line.strip()
        if not content or content.startswith(_COMMENTS):
            continue
        if len(content) > LONGEST_LINE:
            findings.add(
                rules.LINE_LENGTH,
                Place(number),
                f"a line of {len(content)} characters",
                "It is read whole",
            )
        yield number, content


def _begin(line: int, content: str, sections: Sections, findings: Findings) -> Section | None:
    """Return the section that begins, None where its keywords are left out."""
    written, bracket, _ = content[1:].partition("]")
    written = written.strip()
    if not bracket or not written:
        made = f"It is read as [{shortened(written)[1:-1]}]" if written else "It is left out"
        findings.add(rules.LINE, Place(line), f"{shortened(content)} is no section", made)
        if not written:
            return None
    name = _canonical_section(written)
    if not name:
        findings.add(
            rules.SECTION_NAME,
            Place(line, written),
            f"[{shortened(written)[1:-1]}] is no section of an object: write [{written[:4]}], "
            f"[{written[:4]}sub1] or [{written[:4]}Name]",
            "It is left out",
        )
        return None
    there = sections.get(name)
    if there is not None:
        findings.add(
            rules.SECTION_TWICE,
            Place(line, name),
            f"[{shortened(name)[1:-1]}] is there already, in line {there.line}",
            "The keywords of both are read; where both have one, the first counts",
        )
        return there
    sections[name] = Section(name, line)
    return sections[name]


def _canonical_section(written: str) -> str:
    """Return a name as CiA 306-1 spells it; empty for an object's that cannot be read."""
    found = object_of(written)
    if found is not None:
        index, sub_index = found
        return f"{index:04X}" if sub_index is None else f"{index:04X}sub{sub_index:X}"
    if match := _COMPANION.fullmatch(written):
        return match[1].upper() + match[2].capitalize()
    if _LIKE_AN_OBJECT.match(written):
        return ""
    return _CANONICAL.get(written.lower(), written)


def _add(section: Section, line: int, content: str, findings: Findings) -> None:
    written, equals, text = content.partition("=")
    written = written.strip()
    key = _CANONICAL.get(written.lower(), written)
    if not equals or not key:
        findings.add(
            rules.LINE,
            Place(line, section.name),
            f"{shortened(content)} in [{shortened(section.name)[1:-1]}] is neither Keyword=Value "
            "nor a [section] nor a ;comment",
            "It is left out",
        )
        return
    if key in section.values:
        findings.add(
            rules.KEY_TWICE,
            Place(line, section.name),
            f"{shortened(key)[1:-1]} stands in [{shortened(section.name)[1:-1]}] already, in line "
            f"{section.values[key].line}",
            "The first counts",
        )
        return
    section.values[key] = Value(line, _without_comment(text))


def _without_comment(text: str) -> str:
    """Cut a comment behind a value: a semicolon with a blank in front of it."""
    match = re.search(r"\s;", text) if ";" in text else None
    return (text[: match.start()] if match else text).strip()


def _mend_names(sections: Sections, findings: Findings) -> None:
    """Find the sections that the reader needs under names that are misspelt."""
    for name in ("DeviceInfo", *LISTS):
        if name in sections:
            continue
        for other in islice(list(sections), MOST_COMPARED):
            if other not in SECTIONS and object_of(other) is None and nearest(other, [name]):
                section = sections.pop(other)
                findings.add(
                    rules.MISSPELT,
                    section.at(),
                    f"[{other}] is no section of CiA 306-1",
                    f"It is read as [{name}]",
                )
                sections[name] = Section(name, section.line, section.values)
                break


def text_of(section: Section, key: str, findings: Findings) -> str:
    """Return what stands behind a keyword that has to be there, also where it is misspelt."""
    if key in section.values:
        return section.text(key)
    unknown = (name for name in section.values if name not in OBJECT_KEYS)
    for name in islice(unknown, MOST_COMPARED):
        if nearest(name, [key]):
            findings.add(
                rules.MISSPELT,
                section.at(name),
                f"{shortened(name)[1:-1]} is no keyword of CiA 306-1",
                f"It is read as {key}",
            )
            return section.text(name)
    return ""


def by_object(sections: Mapping[str, Section]) -> dict[int, dict[int | None, Section]]:
    """Return the sections of each object, by index and by sub-index; None is the object's own."""
    found: dict[int, dict[int | None, Section]] = {}
    for name, section in sections.items():
        place = object_of(name)
        if place is not None:
            found.setdefault(place[0], {})[place[1]] = section
    return found
