"""The objects that the sections of a description list, each as far as it can be understood."""

from collections.abc import Iterator
from dataclasses import replace

from conformance.device.eds_listing import (
    MANDATORY,
    STRUCTURE_OF_OBJECT,
    ListedObject,
    Listing,
    ObjectType,
)
from conformance.device.files import FileError
from conformance.device.known_objects import KnownObject
from conformance.eds import rules
from conformance.eds.entries import LEFT_OUT, EntryReader
from conformance.eds.findings import Findings, Place
from conformance.eds.lists import listed_indices
from conformance.eds.standard import Standard
from conformance.eds.text import IDENTITY_KEYS, Section, Sections, Value, by_object
from conformance.eds.values import number_of, parse_number, quoted
from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType
from conformance.sdo.pdos import MAPPING_OF, RECEIVED, SENT, is_mapping, is_multiplexed

MOST_COMPACT = 0xFE
MOST_ENTRIES = 0x10000
FIRST_OBJECT = 0x1000
IDENTITY = 0x1018
# The objects that describe types of the device, and none at all: no server reads them.
_NO_OBJECTS = (0x00, 0x05, 0x06)
_OBJECT_TYPES = frozenset(ObjectType)
# What is not clear of an object of which nothing is: how far it goes, and of what type it is.
_ALL_UNCLEAR = frozenset((0, STRUCTURE_OF_OBJECT))


class ListingReader:
    """Reads what the sections of one file list of one node."""

    def __init__(self, sections: Sections, findings: Findings, node_id: int) -> None:
        self._sections = sections
        self._findings = findings
        self._entries = EntryReader(findings, node_id)
        self._standard = Standard(findings, node_id)
        self._count = 0

    def read(self) -> Listing:
        """Return what is listed; raises FileError where that is more than can be tested."""
        objects = self._objects()
        described = frozenset(objects)
        for index in listed_indices(self._sections):
            objects.setdefault(index, _unclear(index))
        for index in self._only_named():
            objects.setdefault(index, _unclear(index))
        self._add_mandatory(objects, described)
        identity = self._identity(objects)
        info = self._sections.get("FileInfo")
        stated = (info.text("FileVersion"), info.text("FileRevision")) if info else ()
        revision = ".".join(part for part in stated if part)
        return Listing(
            dict(sorted(objects.items())), is_complete=True, identity=identity, revision=revision
        )

    def _objects(self) -> dict[int, ListedObject]:
        objects: dict[int, ListedObject] = {}
        for index, sections in sorted(by_object(self._sections).items()):
            head = sections.get(None)
            if head is None:
                head = next(iter(sections.values()))
                sentence = f"[{head.name}] belongs to an object without a section [{index:04X}]"
                made = "The object is read as a RECORD"
                self._findings.add(rules.ORPHAN, head.at(), sentence, made)
                record = Value(head.line, str(ObjectType.RECORD.value))
                head = Section(f"{index:04X}", head.line, {"ObjectType": record})
            elif self._entries.number(head, "ObjectType") in _NO_OBJECTS:
                continue
            if index < FIRST_OBJECT:
                sentence = f"[{head.name}] is a data type, and no object"
                self._findings.add(rules.DATA_TYPE_AREA, head.at(), sentence, LEFT_OUT)
                continue
            subs = {sub: section for sub, section in sections.items() if sub is not None}
            objects[index] = self._object(index, head, subs)
        return objects

    def _object(self, index: int, head: Section, subs: dict[int, Section]) -> ListedObject:
        kind, is_certain = self._object_type(head, subs)
        compact = self._compact(head) if kind in (ObjectType.ARRAY, ObjectType.RECORD) else 0
        self._add_to_count(head, len(subs) + 1 + compact)
        unclear = set() if is_certain else {STRUCTURE_OF_OBJECT}
        if kind in (ObjectType.VAR, ObjectType.DOMAIN):
            entry = self._entries.entry(head, Multiplexer(index), kind)
            if entry is None:
                return _unclear(index, kind)
            written = parse_number(head.text("DataType"), 0)
            type_code = written.number if written else None
            listed = ListedObject(
                index, kind, {0: entry}, entry.name, type_code, frozenset(unclear)
            )
            return self._by_standard(listed, head, subs)
        name = head.text("ParameterName")
        type_code_of_file = self._entries.number(head, "DataType")
        entries: dict[int, KnownObject] = {}
        if compact:
            entries = self._compact_entries(index, head, compact)
        elif not subs:
            wrong = (
                f"[{head.name}] is an {kind.name} and has neither sections [{head.name}sub0] and "
                "so on nor CompactSubObj"
            )
            made = "No case is about the object"
            self._findings.add(rules.STRUCTURE, head.at("ObjectType"), wrong, made)
            return _unclear(index, kind)
        else:
            self._check_sub_number(head, subs)
        for sub, section in sorted(subs.items()):
            if sub > STRUCTURE_OF_OBJECT:
                sentence = f"[{section.name}]: sub-indices go up to FFh"
                self._findings.add(rules.SUB_INDEX, section.at(), sentence, LEFT_OUT)
                continue
            entry = self._entries.entry(section, Multiplexer(index, sub))
            if entry is None:
                unclear.add(sub)
                entries.pop(sub, None)
            else:
                entries[sub] = entry
        listed = ListedObject(index, kind, entries, name, type_code_of_file, frozenset(unclear))
        listed = self._with_highest(listed, head, subs.get(0))
        return self._by_standard(listed, head, subs)

    def _by_standard(
        self, listed: ListedObject, head: Section, subs: dict[int, Section]
    ) -> ListedObject:
        """Return an object as CiA 301 has it, where that defines it."""
        entries: dict[int, KnownObject] = {}
        for sub, known in listed.entries.items():
            entry = self._standard.entry(known, subs.get(sub, head))
            if entry is not None:
                entries[sub] = entry
        forbidden = set(listed.entries) - set(entries)
        if forbidden and 0 in entries:  # it counts them
            forbidden.add(0)
            entries[0] = replace(entries[0], default=None)
        return replace(listed, entries=entries, unclear=listed.unclear | forbidden)

    def _object_type(self, head: Section, subs: dict[int, Section]) -> tuple[ObjectType, bool]:
        """Return the type of an object, and whether the file leaves no doubt."""
        number = self._entries.number(head, "ObjectType", ObjectType.VAR)
        likely = ObjectType.RECORD if subs or head.text("CompactSubObj") else ObjectType.VAR
        if number not in _OBJECT_TYPES:
            wrong = (
                f"{quoted('ObjectType', head.text('ObjectType'))} is none of 0x2 (DOMAIN), 0x7 "
                "(VAR), 0x8 (ARRAY) and 0x9 (RECORD)"
            )
            made = f"The object is read as a {likely.name}"
            self._findings.add(rules.OBJECT_TYPE, head.at("ObjectType"), wrong, made)
            return likely, False
        kind = ObjectType(number)
        if kind in (ObjectType.VAR, ObjectType.DOMAIN) and subs:
            wrong = f"[{head.name}] is a {kind.name}, and has sub-indices"
            made = "The object is read as a RECORD"
            self._findings.add(rules.STRUCTURE, head.at("ObjectType"), wrong, made)
            return ObjectType.RECORD, False
        return kind, True

    def _compact(self, head: Section) -> int:
        """Return to which sub-index one description counts; 0 when each has its own."""
        number = self._entries.number(head, "CompactSubObj", 0) or 0
        if 0 <= number <= MOST_COMPACT:
            return number
        wrong = f"{quoted('CompactSubObj', head.text('CompactSubObj'))} is beyond {MOST_COMPACT}"
        self._findings.add(rules.COMPACT, head.at("CompactSubObj"), wrong, LEFT_OUT)
        return 0

    def _compact_entries(self, index: int, head: Section, count: int) -> dict[int, KnownObject]:
        """Return the entries of an object of which one description serves for all sub-indices."""
        # By CiA 306-1 sub-index 0 is read-only then; that of 1003h is not, by CiA 301.
        access = Access.RW if index == ERROR_LIST else Access.RO
        number = KnownObject(Multiplexer(index), DataType.UNSIGNED8, access, default=bytes([count]))
        described = self._entries.entry(head, Multiplexer(index, 1))
        if described is None:
            return {0: number}
        names = self._sections.get(f"{index:04X}Name")
        values = self._sections.get(f"{index:04X}Value")
        entries = {0: number}
        for sub in range(1, count + 1):
            mux, key = Multiplexer(index, sub), str(sub)
            name = (names.text(key) if names else "") or described.name
            configured = described.configured
            if values and values.text(key) and described.data_type is not None:
                configured = self._entries.value(values, key, described.data_type)
            entries[sub] = replace(described, mux=mux, name=name, configured=configured)
        return entries

    def _check_sub_number(self, head: Section, subs: dict[int, Section]) -> None:
        stated = self._entries.number(head, "SubNumber")
        described = sum(sub < STRUCTURE_OF_OBJECT for sub in subs)
        if stated is not None and stated != described:
            wrong = f"SubNumber={head.text('SubNumber')}, and {described} are described"
            made = "The sections count"
            self._findings.add(rules.SUB_NUMBER, head.at("SubNumber"), wrong, made)

    def _with_highest(
        self, listed: ListedObject, head: Section, section: Section | None
    ) -> ListedObject:
        """See that sub-index 0 of an array or record can hold the highest sub-index."""
        if 0 in listed.unclear:
            return listed
        mux = Multiplexer(listed.index)
        known = listed.entries.get(0)
        if known is None:
            sentence = f"[{head.name}] has no sub-index 00h"
            made = "It is added, an UNSIGNED8 that is ro"
            self._findings.add(rules.HIGHEST_MISSING, head.at(), sentence, made)
            entries = {0: KnownObject(mux, DataType.UNSIGNED8, Access.RO), **listed.entries}
            return replace(listed, entries=entries)
        place = section.at("DataType") if section else head.at()
        if known.data_type is not DataType.UNSIGNED8:
            kind = "of no type" if known.data_type is None else known.data_type.name
            sentence = f"sub-index 00h of {listed.index:04X}h is {kind}"
            made = "It is read as an UNSIGNED8"
            self._findings.add(rules.HIGHEST_MISSING, place, sentence, made)
            number = number_of(known.data_type, known.default)
            fits = isinstance(number, int) and 0 <= number <= 0xFF
            default = bytes([int(number)]) if fits and number is not None else None
            known = replace(
                known, data_type=DataType.UNSIGNED8, default=default, configured=None,
                low=None, high=None,
            )  # fmt: skip
            listed = replace(listed, entries={**listed.entries, 0: known})
        stated, highest = known.default, listed.highest
        if stated is None or is_multiplexed(mux, stated):
            return listed
        may_be_lower = (
            known.access is Access.RW or listed.index == ERROR_LIST or is_mapping(listed.index)
        )
        if stated[0] == highest or (may_be_lower and stated[0] < highest):
            return listed
        sentence = (
            f"the default of {mux} is {stated[0]}, and the highest sub-index that is described "
            f"is {highest}"
        )
        place = section.at("DefaultValue") if section else head.at()
        made = "No case compares it"
        self._findings.add(rules.HIGHEST, place, sentence, made)
        entries = {**listed.entries, 0: replace(known, default=None)}
        return replace(listed, entries=entries, unclear=listed.unclear | {0})

    def _add_to_count(self, head: Section, more: int) -> None:
        self._count += more
        if self._count > MOST_ENTRIES:
            raise FileError(
                self._findings.path,
                head.line,
                f"so far the file lists {self._count} entries, by sections and by CompactSubObj; "
                f"more than {MOST_ENTRIES} cannot be tested: is it the right one?",
            )

    # What the file names beside its objects

    def _only_named(self) -> Iterator[int]:
        """Yield the objects that are there, as the file says, without a section of their own.

        CompactPDO leaves out those of PDOs, and modules add some (clauses 6.5 and 8.3).
        """
        info = self._sections.get("DeviceInfo")
        if info is not None and self._entries.number(info, "CompactPDO"):
            for key, area in (("NrOfRXPDO", RECEIVED), ("NrOfTXPDO", SENT)):
                count = min(self._entries.number(info, key, 0) or 0, len(area))
                for index in area[: max(count, 0)]:
                    yield from (index, index + MAPPING_OF)
        for name, section in self._sections.items():
            if name.startswith("M") and name.lower().endswith("subextends"):
                for key, value in section.values.items():
                    written = parse_number(value.text, 0)
                    if key.isdigit() and written and FIRST_OBJECT <= written.number <= 0xFFFF:
                        yield written.number

    def _add_mandatory(self, objects: dict[int, ListedObject], described: frozenset[int]) -> None:
        for index in (0x1000, 0x1001, IDENTITY):
            if index not in described:
                made = "It is tested all the same" if index == 0x1000 else ""
                sentence = f"there is no section [{index:04X}]"
                self._findings.add(rules.MANDATORY_OBJECT, Place(), sentence, made)
        device_type = objects.get(0x1000)
        if device_type is None or 0 not in device_type.entries:
            objects[0x1000] = ListedObject(0x1000, ObjectType.VAR, {0: MANDATORY[0]})

    def _identity(self, objects: dict[int, ListedObject]) -> dict[int, int]:
        """Return what [DeviceInfo] says of the identity; nothing that 1018h contradicts."""
        info = self._sections.get("DeviceInfo")
        identity: dict[int, int] = {}
        for sub, key in IDENTITY_KEYS.items() if info else ():
            number = self._entries.number(info, key) if info else None
            if number is None or info is None:
                continue
            if not 0 <= number < 1 << 32:
                sentence = f"{quoted(key, info.text(key))} is no UNSIGNED32"
                self._findings.add(rules.VALUE_TYPE, info.at(key), sentence, LEFT_OUT)
                continue
            listed = objects.get(IDENTITY)
            known = listed.entries.get(sub) if listed else None
            default = number_of(known.data_type, known.default) if known else None
            if listed and known and default is not None and default != number:
                sentence = (
                    f"{quoted(key, info.text(key))}, and the default of {known.mux} is {default:#x}"
                )
                made = "No case compares them"
                self._findings.add(rules.IDENTITY, info.at(key), sentence, made)
                entries = {**listed.entries, sub: replace(known, default=None)}
                objects[IDENTITY] = replace(listed, entries=entries)
                continue
            identity[sub] = number
        return identity


def _unclear(index: int, kind: ObjectType = ObjectType.VAR) -> ListedObject:
    """Return an object of which a file says that it is there, and nothing else that is clear."""
    return ListedObject(index, kind, {}, unclear=_ALL_UNCLEAR)
