"""Descriptions of devices: what they list, and all that is wrong with them (CiA 306-1, CiA 311).

Whatever can be understood is read. A file that lists no object at all is none.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Self

from conformance.device.eds_listing import Listing
from conformance.device.files import FileError, read_bytes
from conformance.eds import rules
from conformance.eds.checks import check, check_text
from conformance.eds.entries import LEFT_OUT
from conformance.eds.findings import Finding, FindingRecord, Findings, Place
from conformance.eds.objects import ListingReader
from conformance.eds.text import COMMISSIONING, NODE_ID_KEY, Sections, by_object, sections_of
from conformance.eds.values import parse_number
from conformance.eds.xdd import sections_of_xml

SUFFIXES, XML_SUFFIXES = (".eds", ".dcf"), (".xdd", ".xdc")
LARGEST, LARGEST_XML = 2 * 1024 * 1024, 8 * 1024 * 1024
ENCODINGS = ("utf-8", "cp1252", "latin-1")


@dataclass(frozen=True, slots=True)
class DeviceFile:
    """A description that was read: its sections, what they list of one node, what is wrong."""

    path: Path
    sections: Sections
    listing: Listing
    findings: tuple[Finding, ...]
    left_out: tuple[tuple[str, int], ...] = ()

    @property
    def records(self) -> list[FindingRecord]:
        """The findings as they stand in a record."""
        return [finding.record for finding in self.findings]

    @classmethod
    def unreadable(cls, path: Path, finding: Finding) -> Self:
        """Return what is known of a file that is no description."""
        return cls(path, {}, Listing(), (finding,))


def read_eds(path: Path, node_id: int) -> Listing:
    """Return what a file lists of the node; raises FileError where it is no description."""
    return read_file(path, node_id).listing


def read_file(path: Path, node_id: int) -> DeviceFile:
    """Return all of a file; ``$NODEID`` stands for ``node_id``. Raises FileError."""
    findings = Findings(path)
    if path.suffix.lower() in XML_SUFFIXES:
        sections = sections_of_xml(path, read_bytes(path, limit=LARGEST_XML))
        return _read(sections, findings, node_id, is_xml=True)
    if path.suffix.lower() not in SUFFIXES:
        named = "the name of the file has to end in .eds, .dcf, .xdd or .xdc."
        raise FileError(path, None, named)
    text = _decoded(read_bytes(path, limit=LARGEST), findings)
    return _read(sections_of(text, findings), findings, node_id)


def parse_eds(path: Path, text: str, node_id: int) -> DeviceFile:
    """Return what the text of an EDS says; raises FileError with the name of its file."""
    findings = Findings(path)
    return _read(sections_of(text, findings), findings, node_id)


def commissioned_node_id(sections: Sections) -> int | None:
    """Return which node a DCF is for; None where the file leaves that open."""
    section = sections.get(COMMISSIONING)
    written = parse_number(section.text(NODE_ID_KEY), 0) if section else None
    return written.number if written else None


def _decoded(content: bytes, findings: Findings) -> str:
    """Return the text of a file, whatever its encoding."""
    encoding = "utf-16" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else ""
    if content.startswith(b"\xef\xbb\xbf"):
        content = content[3:]
        findings.add(rules.ENCODING, Place(1), "the file begins with a byte order mark", LEFT_OUT)
    elif not encoding and b"\0" in content:
        line = content[: content.index(b"\0")].count(b"\n") + 1
        raise FileError(findings.path, line, "a byte of 0: this is no text file.")
    if content.isascii() and not encoding:
        return content.decode("ascii")
    for name in (encoding, *ENCODINGS):
        try:
            text = content.decode(name or "ascii")
        except UnicodeDecodeError:
            continue
        first = next((place for place, sign in enumerate(text) if not sign.isascii()), 0)
        line = text.count("\n", 0, first) + 1
        made = f"The file is read as {name.upper()}"
        findings.add(rules.ENCODING, Place(line), "the text is not in ASCII", made)
        return text
    raise FileError(findings.path, None, "the text is in no encoding that is known.")


def _read(
    sections: Sections, findings: Findings, node_id: int, *, is_xml: bool = False
) -> DeviceFile:
    if not by_object(sections):
        raise FileError(
            findings.path,
            None,
            "there is no section of an object, as [1000], which every EDS has: is this an EDS?",
        )
    if not is_xml:
        check_text(sections, findings)
    listing = ListingReader(sections, findings, node_id).read()
    listing = check(sections, listing, findings)
    return DeviceFile(
        findings.path, sections, listing, findings.sorted(), tuple(findings.left_out())
    )
