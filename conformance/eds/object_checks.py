"""The objects of a description as a whole: names, PDOMapping, error control, COB-IDs."""

import re

from conformance.device.eds_listing import Listing
from conformance.device.known_objects import KnownObject
from conformance.eds import rules
from conformance.eds.findings import Findings, Place
from conformance.eds.text import Sections
from conformance.eds.values import number_of
from conformance.sdo.cob_id import CobId
from conformance.sdo.layout import Multiplexer
from conformance.sdo.pdos import COB_ID, MOST_BITS, is_communication

HEARTBEAT, GUARDING = 0x1017, (0x100C, 0x100D)
# Words of which the name of an object has one at least, by index.
NAMES = {
    0x1000: "device type",
    0x1001: "error register",
    0x1002: "manufacturer status register",
    0x1003: "pre-defined predefined error field",
    0x1005: "cob-id cobid sync",
    0x1006: "communication cycle period",
    0x1007: "synchronous sync window length",
    0x1008: "device name",
    0x1009: "hardware version",
    0x100A: "software version",
    0x100C: "guard time",
    0x100D: "life lifetime time factor",
    0x1010: "store save parameters",
    0x1011: "restore load default parameters",
    0x1012: "cob-id cobid time stamp",
    0x1014: "cob-id cobid emcy emergency",
    0x1015: "inhibit time emcy emergency",
    0x1016: "consumer heartbeat",
    0x1017: "producer heartbeat",
    0x1018: "identity",
    0x1019: "synchronous sync counter overflow",
    0x1020: "verify configuration",
    0x1021: "store eds",
    0x1022: "store storage format",
    0x1029: "error behavior behaviour",
    0x1200: "sdo server",
}
# COB-IDs that are one service each, beside those of PDOs.
SERVICES = tuple(Multiplexer(index) for index in (0x1005, 0x1012, 0x1014))


def check_objects(sections: Sections, listing: Listing, findings: Findings) -> None:
    """Check what the entries of all objects say beside their values."""
    for known in listing.entries:
        _check_mapping(known, place_of(sections, known.mux, "PDOMapping"), sections, findings)
    for index, words in NAMES.items():
        listed = listing.objects.get(index)
        if listed and listed.name and not _words(listed.name) & _words(words):
            place = place_of(sections, Multiplexer(index), "ParameterName")
            sentence = f"{index:04X}h is called {listed.name!r}"
            findings.add(rules.STANDARD_NAME, place, sentence)
    there = listing.objects
    if HEARTBEAT not in there and not all(index in there for index in GUARDING):
        sentence = "there is neither 1017h nor 100Ch with 100Dh"
        findings.add(rules.ERROR_CONTROL, Place(), sentence)
    _check_cob_ids(sections, listing, findings)


def place_of(sections: Sections, mux: Multiplexer, key: str = "") -> Place:
    """Return where a file says something of an entry, or at least of its object."""
    head = f"{mux.index:04X}"
    for name in (f"{head}sub{mux.sub_index:X}", head):
        if name in sections and (mux.sub_index == 0 or name != head or key != "PDOMapping"):
            return sections[name].at(key)
    return sections[head].at(key) if head in sections else Place()


def _words(text: str) -> set[str]:
    return set(re.findall(r"[a-z]{3,}", text.lower()))


def _check_mapping(
    known: KnownObject, place: Place, sections: Sections, findings: Findings
) -> None:
    """See that PDOMapping fits the access, and the type."""
    section = sections.get(place.section)
    if section is None:
        return
    access = section.text("AccessType").lower()
    if access in ("rwr", "rww") and known.mappable is None and section.text("PDOMapping"):
        sentence = f"{known.mux} is {access}, and has PDOMapping=0"
        findings.add(rules.PROCESS_DATA, place, sentence, "It may be mapped")
    is_long = known.length is None or 8 * known.length > MOST_BITS
    if known.mappable and known.data_type is not None and is_long:
        sentence = f"{known.mux} is a {known.data_type.name}, and has PDOMapping=1"
        findings.add(rules.PROCESS_DATA, place, sentence)


def _check_cob_ids(sections: Sections, listing: Listing, findings: Findings) -> None:
    """See that no two services have one COB-ID by default."""
    taken: dict[int, Multiplexer] = {}
    for known in listing.entries:
        is_pdo = known.mux.sub_index == COB_ID and is_communication(known.mux.index)
        if not is_pdo and known.mux not in SERVICES:
            continue
        number = number_of(known.data_type, known.stated)
        if not isinstance(number, int) or not number:
            continue
        cob_id = CobId.from_bytes(number.to_bytes(4, "little"))
        if not cob_id.valid:
            continue
        other = taken.setdefault(cob_id.identifier, known.mux)
        if other != known.mux:
            sentence = f"{known.mux} has the COB-ID {cob_id}, as {other} has"
            place = place_of(sections, known.mux, "DefaultValue")
            findings.add(rules.COB_ID_TWICE, place, sentence)
