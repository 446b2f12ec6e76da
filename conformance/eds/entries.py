"""One section of an EDS as an entry of the object dictionary, and what is wrong with it."""

from dataclasses import dataclass

from conformance.device.eds_listing import ObjectType
from conformance.device.files import shortened
from conformance.device.known_objects import KnownObject
from conformance.device.numbers import Number, is_number
from conformance.eds import rules
from conformance.eds.findings import EdsRule, Findings
from conformance.eds.text import Section, text_of
from conformance.eds.values import number_of, parse_number, quoted, read_value
from conformance.sdo.fixed_objects import entry_at
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nearest import meant
from conformance.sdo.objects import Access, DataType

LONGEST_NAME = 241
FLAGS = 0b11
_ACCESS = {access.value: access for access in Access} | {"rwr": Access.RW, "rww": Access.RW}
_PROCESS_DATA = ("rwr", "rww")
_TYPES = frozenset(DataType)
# Types that a profile or a vendor defines: their values are bytes to the suite.
_DEFINED_TYPES = range(0x20, 0x1000)
LEFT_OUT = "It is left out"


@dataclass(frozen=True, slots=True)
class EntryReader:
    """Reads the sections of one file for one node."""

    findings: Findings
    node_id: int

    def number(self, section: Section, key: str, missing: int | None = None) -> int | None:
        """Return the number behind a keyword; ``missing`` where there is none that can be read."""
        text = section.text(key)
        if not text:
            return missing
        written = parse_number(text, self.node_id)
        if written is None:
            sentence = f"{quoted(key, text)} is no number: write 10 or 0x0A"
            self.findings.add(rules.NUMBER, section.at(key), sentence, LEFT_OUT)
            return missing
        if written.odd:
            self._note(rules.NUMBER_STYLE, section, key, f"is written with {written.odd}")
        return written.number

    def entry(
        self, section: Section, mux: Multiplexer, kind: ObjectType = ObjectType.VAR
    ) -> KnownObject | None:
        """Return the entry that a section describes; None where no case could be about it."""
        name = self._name(section)
        access = self._access(section, mux, kind)
        data_type = self._data_type(section, kind)
        default = self._value(section, "DefaultValue", data_type)
        configured = self._value(section, "ParameterValue", data_type)
        low, high = self._limits(section, data_type, default, configured)
        flags = self.number(section, "ObjFlags", 0) or 0
        if flags & ~FLAGS:
            self._note(rules.OBJ_FLAGS, section, "ObjFlags", "has other bits than 0 and 1")
        mappable = self._mappable(section, access)
        if access is None:
            return None
        return KnownObject(
            mux,
            data_type,
            _ACCESS[access],
            name=name,
            low=low,
            high=high,
            default=default,
            configured=configured,
            flags=flags & FLAGS,
            mappable=mappable,
            floats=access == "rwr",
        )

    def _note(self, rule: EdsRule, section: Section, key: str, wrong: str, made: str = "") -> None:
        sentence = f"{quoted(key, section.text(key))} {wrong}"
        self.findings.add(rule, section.at(key), sentence, made)

    def _name(self, section: Section) -> str:
        name = text_of(section, "ParameterName", self.findings)
        if not name:
            sentence = f"[{section.name}] has no ParameterName"
            self.findings.add(rules.NAME, section.at("ParameterName"), sentence)
        elif len(name) > LONGEST_NAME:
            sentence = f"the ParameterName of [{section.name}] has {len(name)} characters"
            self.findings.add(rules.NAME, section.at("ParameterName"), sentence)
        return name

    def _access(self, section: Section, mux: Multiplexer, kind: ObjectType) -> str | None:
        text = text_of(section, "AccessType", self.findings)
        access = text.lower()
        if access in _ACCESS:
            return access
        if not access and kind is ObjectType.DOMAIN:
            return Access.RW.value
        wrong = (
            f"AccessType={shortened(text)[1:-1]} is unknown.{meant(text, _ACCESS)}".rstrip(".")
            if text
            else f"[{section.name}] has no AccessType"
        )
        fixed = entry_at(mux)
        if fixed is not None and not fixed.access.writable:
            made = "It is read as ro, as CiA 301 has it"
            self.findings.add(rules.ACCESS, section.at("AccessType"), wrong, made)
            return Access.RO.value
        made = "No case is about the entry"
        self.findings.add(rules.ACCESS, section.at("AccessType"), wrong, made)
        return None

    def _data_type(self, section: Section, kind: ObjectType) -> DataType | None:
        """Return the type of an entry; None for one that the device defines, or none at all."""
        text = text_of(section, "DataType", self.findings)
        if not text and kind is ObjectType.DOMAIN:
            return DataType.DOMAIN
        written = parse_number(text, self.node_id)
        if written is not None and written.number in _TYPES:
            return DataType(written.number)
        if written is None or written.number not in _DEFINED_TYPES:
            wrong = (
                f"DataType={shortened(text)[1:-1]} is no data type: 0x0005 is UNSIGNED8, 0x0006 "
                "UNSIGNED16, 0x0007 UNSIGNED32, 0x0009 VISIBLE_STRING"
                if text
                else f"[{section.name}] has no DataType"
            )
            made = "A value may have any length"
            self.findings.add(rules.DATA_TYPE, section.at("DataType"), wrong, made)
        return None

    def _value(self, section: Section, key: str, data_type: DataType | None) -> bytes | None:
        """Return a value as it goes over the wire; None where there is none to compare."""
        text = section.text(key)
        if not text or data_type is None:
            return None
        return self.value(section, key, data_type)

    def value(self, section: Section, key: str, data_type: DataType) -> bytes | None:
        """Return the value behind a keyword; None where it cannot be read."""
        reading = read_value(data_type, section.text(key), self.node_id)
        if reading.rule is not None:
            made = LEFT_OUT if reading.data is None else _as_bytes(data_type, reading.data)
            self._note(reading.rule, section, key, reading.wrong, made)
        return reading.data

    def _limits(
        self, section: Section, data_type: DataType | None, *values: bytes | None
    ) -> tuple[Number | None, Number | None]:
        """Return the limits; none where they contradict each other, or a value."""
        low = self._limit(section, "LowLimit", data_type)
        high = self._limit(section, "HighLimit", data_type)
        if low is not None and high is not None and low > high:
            self.findings.add(
                rules.LIMIT_ORDER,
                section.at("LowLimit"),
                f"{quoted('LowLimit', section.text('LowLimit'))}, the number {low}, is above "
                f"{quoted('HighLimit', section.text('HighLimit'))}, the number {high}",
                "Both are left out",
            )
            return None, None
        for key, data in zip(("DefaultValue", "ParameterValue"), values, strict=True):
            number = number_of(data_type, data)
            if number is None:
                continue
            is_below = low is not None and number < low
            if is_below or (high is not None and number > high):
                side = f"below the LowLimit {low}" if is_below else f"above the HighLimit {high}"
                made = "The limits are left out"
                self._note(rules.WITHIN_LIMITS, section, key, f"is {side}", made)
                return None, None
        return low, high

    def _limit(self, section: Section, key: str, data_type: DataType | None) -> Number | None:
        text = section.text(key)
        if not text or data_type is None or not is_number(data_type):
            return None
        reading = read_value(data_type, text, self.node_id)
        data, rule = reading.data, reading.rule
        if rule in (rules.VALUE_TYPE, rules.SIGN):  # with another sign it would be another limit
            data, rule = None, rules.LIMIT_TYPE
        if rule is not None:
            made = LEFT_OUT if data is None else _as_bytes(data_type, data)
            self._note(rule, section, key, reading.wrong, made)
        return number_of(data_type, data)

    def _mappable(self, section: Section, access: str | None) -> bool | None:
        """Return what PDOMapping says; None where it is left out, or contradicts the access.

        An entry that is rwr or rww holds process data.
        """
        number = self.number(section, "PDOMapping")
        if number is not None and number not in (0, 1):
            self._note(rules.PDO_MAPPING, section, "PDOMapping", "is neither 0 nor 1")
        if number is None or (not number and access in _PROCESS_DATA):
            return None
        return bool(number)


def _as_bytes(data_type: DataType, data: bytes) -> str:
    number = number_of(data_type, data)
    return f"It is read as {data.hex(' ').upper() if number is None else number}"
