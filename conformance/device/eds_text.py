"""The text of an EDS or DCF as sections, checked and brought into one form (CiA 306-1, 4).

canopen's importer does the reading (see ``eds``). It knows no lines, stops at the first surprise
with whatever exception that causes, and takes names and numbers in one spelling only. So the text
is scanned before: every key keeps its line, names get the spelling of CiA 306-1, numbers become
Python's, and what cannot be read is a sentence.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import islice
from pathlib import Path

from conformance.device.files import FileError, read_text, shortened
from conformance.sdo.nearest import nearest

SUFFIXES = (".eds", ".dcf")
LARGEST = 2 * 1024 * 1024
# The largest devices list some 5,000 entries by sections of their own.
MOST_SECTIONS = 16_384
ENCODINGS = ("utf-8-sig", "cp1252")
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
)
INFO_KEYS = ("VendorNumber", "ProductNumber", "RevisionNumber")
NODE_ID_KEY = "NodeID"
# Spelt like that in CiA 306-1.
COMMISSIONING = "DeviceComissioning"
LISTS = ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects")
NEEDED = ("DeviceInfo", "MandatoryObjects")
# Where a misspelt name would go unnoticed: what else there is says nothing about objects.
_SECTIONS = (*LISTS, "FileInfo", "DeviceInfo", "DummyUsage", "Comments", COMMISSIONING)
_CANONICAL = {name.lower(): name for name in (*OBJECT_KEYS, *INFO_KEYS, NODE_ID_KEY, *_SECTIONS)}
_CANONICAL["supportedobjects"] = "SupportedObjects"
_OBJECT = re.compile(r"([0-9a-f]{4})(?:sub([0-9a-f]{1,3}))?", re.IGNORECASE)
_COMPANION = re.compile(r"[0-9a-f]{4}(name|value|denotation|objectlinks)", re.IGNORECASE)
_NUMBER = re.compile(r"[+-]?(0x[0-9a-f]+|[0-9]+)", re.IGNORECASE)
_MOST_DIGITS = 40
_MOST_REMEMBERED = 80
# How many names are compared with one that is misspelt.
MOST_COMPARED = 1000


@dataclass(frozen=True, slots=True)
class Value:
    """What stands behind a key, and its line."""

    line: int
    text: str


@dataclass(frozen=True, slots=True)
class Section:
    """A section, its line, and its keys in the spelling of CiA 306-1."""

    path: Path
    name: str
    line: int
    values: dict[str, Value] = field(default_factory=dict)

    def error(self, sentence: str, key: str = "") -> FileError:
        """Build an error at the line of a key, or at that of the section."""
        value = self.values.get(key)
        return FileError(self.path, value.line if value else self.line, sentence)

    def text(self, key: str) -> str:
        """Return what stands behind a key; empty when there is nothing."""
        value = self.values.get(key)
        return value.text if value else ""

    def number(self, key: str, node_id: int, missing: int | None = None) -> int | None:
        """Return the number behind a key, ``missing`` without one; raises FileError."""
        text = self.text(key)
        if not text:
            return missing
        number = parse_number(text, node_id)
        if number is None:
            raise self.error(
                f"{key}={shortened(text)} is no number: write 10, 0x0A or $NODEID+0x180.", key
            )
        return number

    def require(self, key: str) -> str:
        """Return what stands behind a key that has to be there; raises FileError."""
        if self.text(key):
            return self.text(key)
        if key in self.values:
            raise self.error(f"{key} in [{self.name}] has no value.", key)
        unknown = (name for name in self.values if name not in OBJECT_KEYS)
        for name in islice(unknown, MOST_COMPARED):
            if nearest(name, [key]):
                raise self.error(
                    f"[{self.name}] has no {key}, but {name!r}. Did you mean {key!r}?", name
                )
        raise self.error(f"[{self.name}] has no {key}.")


def parse_number(text: str, node_id: int) -> int | None:
    """Return a number as CiA 306-1 writes it: decimal, 0x…, octal with a 0, or a $NODEID formula.

    Returns None for what is none.

    >>> parse_number("$NODEID+0x600", 5) == 0x605
    True
    """
    return _parsed(text, node_id) if len(text) <= _MOST_REMEMBERED else _parse(text, node_id)


def _parse(text: str, node_id: int) -> int | None:
    compact = text.replace(" ", "").replace("\t", "").upper()
    offset = 0
    if "$NODEID" in compact:
        offset = node_id
        compact = compact.replace("$NODEID", "", 1).strip("+") or "0"
    # Longer numbers belong to no type, and Python refuses to read those that are very long.
    if len(compact) > _MOST_DIGITS or not _NUMBER.fullmatch(compact):
        return None
    digits = compact.lstrip("+-")
    octal = digits.startswith("0") and digits.isdigit() and len(digits) > 1
    if octal and not set(digits) <= set("01234567"):
        return None
    number = int(digits, 8 if octal else 0)
    return (-number if compact.startswith("-") else number) + offset


# The same few numbers stand in all objects.
_parsed = lru_cache(maxsize=4096)(_parse)


def object_of(name: str) -> tuple[int, int | None] | None:
    """Return index and sub-index of an object's section, None for other sections."""
    match = _OBJECT.fullmatch(name)
    if match is None:
        return None
    return int(match[1], 16), int(match[2], 16) if match[2] else None


def read_eds_text(path: Path) -> str:
    """Return the text of a file; raises FileError."""
    if path.suffix.lower() not in SUFFIXES:
        raise FileError(path, None, "the name of the file has to end in .eds or .dcf.")
    return read_text(path, limit=LARGEST, encodings=ENCODINGS)


def sections_of(path: Path, text: str) -> dict[str, Section]:
    """Return the sections of a text by name; raises FileError with the name of its file."""
    sections: dict[str, Section] = {}
    section: Section | None = None
    for line, content in _lines(text):
        if content.startswith("["):
            section = _begin(path, line, content, sections)
            if len(sections) >= MOST_SECTIONS:
                raise section.error(
                    f"more than {MOST_SECTIONS} sections: no device has as many; is it the right "
                    "file?"
                )
            sections[section.name] = section
        elif section is None:
            raise FileError(
                path, line, f"{shortened(content)} stands before the first [section]: no EDS?"
            )
        else:
            _add(section, line, content)
    _check(path, sections)
    return sections


def commissioned_node_id(sections: Mapping[str, Section]) -> int | None:
    """Return which node a DCF is for; None where the file leaves that open. Raises FileError."""
    section = sections.get(COMMISSIONING)
    return section.number(NODE_ID_KEY, 0) if section else None


def _lines(text: str) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(text.split("\n"), 1):
        content = line.strip()
        if content and content[0] not in ";#":
            yield number, content


def _begin(path: Path, line: int, content: str, sections: Mapping[str, Section]) -> Section:
    written = content.partition("]")[0].removeprefix("[").strip()
    if "]" not in content or not written:
        raise FileError(path, line, f"{shortened(content)} is no section: write [1018sub1].")
    name = _canonical_section(path, line, written)
    if name in sections:
        raise FileError(
            path, line, f"[{shortened(name)[1:-1]}] is there already, in line "
            f"{sections[name].line}: leave one of them out."
        )  # fmt: skip
    return Section(path, name, line)


def _canonical_section(path: Path, line: int, written: str) -> str:
    found = object_of(written)
    if found is not None:
        index, sub_index = found
        if sub_index is None:
            return f"{index:04X}"
        if sub_index > 0xFF:
            raise FileError(path, line, f"[{written}]: sub-indices go up to FFh.")
        return f"{index:04X}sub{sub_index:X}"
    if _COMPANION.fullmatch(written):
        return written[:4].upper() + written[4:].capitalize()
    if re.match(r"[0-9][0-9a-f]{3}[a-z]", written, re.IGNORECASE):
        raise FileError(
            path, line, f"[{shortened(written)[1:-1]}] is no section of an object: write "
            f"[{written[:4]}], [{written[:4]}sub1] or [{written[:4]}Name]."
        )  # fmt: skip
    return _CANONICAL.get(written.lower(), written)


def _add(section: Section, line: int, content: str) -> None:
    written, equals, text = content.partition("=")
    key = _CANONICAL.get(written.strip().lower(), written.strip())
    if not equals or not key:
        raise FileError(
            section.path,
            line,
            f"{shortened(content)} in [{shortened(section.name)[1:-1]}] is neither Key=Value nor "
            "a [section] nor a ; comment.",
        )
    if key in section.values:
        raise FileError(
            section.path, line, f"{shortened(key)[1:-1]} stands in [{section.name}] already, in "
            f"line {section.values[key].line}: leave one of them out."
        )  # fmt: skip
    section.values[key] = Value(line, _without_comment(text))


def _without_comment(text: str) -> str:
    """Cut a comment behind a value: a semicolon with a blank in front of it."""
    match = re.search(r"\s;", text) if ";" in text else None
    return (text[: match.start()] if match else text).strip()


def _check(path: Path, sections: Mapping[str, Section]) -> None:
    for name in NEEDED:
        if name in sections:
            continue
        for other, section in islice(sections.items(), MOST_COMPARED):
            if other not in _SECTIONS and nearest(other, [name]):
                raise section.error(f"[{other}] is no section of an EDS. Did you mean [{name}]?")
        raise FileError(
            path, None, f"there is no section [{name}], which every EDS has: is this an EDS?"
        )
    for name in LISTS:
        if name in sections:
            _check_list(sections[name], sections)


def _check_list(section: Section, sections: Mapping[str, Section]) -> None:
    """See that every object which is listed is described."""
    for key, value in section.values.items():
        if key == "SupportedObjects":
            continue
        index = parse_number(value.text, 0) if key.isdigit() else None
        if index is None or not 0 < index <= 0xFFFF:
            raise section.error(
                f"{shortened(key)[1:-1]}={shortened(value.text)} in [{section.name}] is no entry "
                "of the list: write 1=0x1000.",
                key,
            )
        if f"{index:04X}" not in sections:
            raise section.error(
                f"[{section.name}] lists {index:04X}h, but there is no section [{index:04X}].",
                key,
            )
