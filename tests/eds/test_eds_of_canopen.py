"""Files that canopen's exporter writes are read back as what was exported."""

import io
import string
from pathlib import Path

from canopen.objectdictionary import (
    ObjectDictionary,
    ODArray,
    ODRecord,
    ODVariable,
    export_od,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from conformance.device.numbers import bounds, encode_number
from conformance.eds.findings import Severity
from conformance.eds.reading import parse_eds
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType

NUMBERS = [
    DataType.INTEGER8,
    DataType.INTEGER16,
    DataType.INTEGER32,
    DataType.INTEGER64,
    DataType.UNSIGNED8,
    DataType.UNSIGNED16,
    DataType.UNSIGNED32,
    DataType.UNSIGNED64,
]
NAMES = st.text(string.ascii_letters + string.digits + " -_()", min_size=1, max_size=20).map(
    lambda text: f"x{text}x"
)


@st.composite
def variables(draw: st.DrawFn, index: int, sub_index: int) -> ODVariable:
    variable = ODVariable(draw(NAMES), index, sub_index)
    data_type = draw(st.sampled_from(NUMBERS))
    variable.data_type = data_type
    variable.access_type = draw(st.sampled_from(["ro", "rw", "wo", "const"]))
    low, high = bounds(data_type)
    values = sorted(draw(st.lists(st.integers(low, high), min_size=3, max_size=3)))
    if draw(st.booleans()):
        variable.min, variable.default, variable.max = values
    variable.pdo_mappable = draw(st.booleans())
    return variable


def device_type() -> ODVariable:
    variable = ODVariable("Device type", 0x1000, 0)
    variable.data_type, variable.access_type = DataType.UNSIGNED32, "ro"
    return variable


@st.composite
def dictionaries(draw: st.DrawFn) -> ObjectDictionary:
    dictionary = ObjectDictionary()  # type: ignore[no-untyped-call]
    dictionary.add_object(device_type())
    for index in draw(st.lists(st.integers(0x2000, 0x9FFF), max_size=5, unique=True)):
        name = f"{draw(NAMES)} {index}"
        kind = draw(st.sampled_from([ODVariable, ODRecord, ODArray]))
        if kind is ODVariable:
            variable = draw(variables(index, 0))
            variable.name = name
            dictionary.add_object(variable)
            continue
        structure = kind(name, index)
        highest = ODVariable("Highest sub-index", index, 0)
        highest.data_type, highest.access_type = DataType.UNSIGNED8, "const"
        count = draw(st.integers(1, 4))
        highest.default = count
        structure.add_member(highest)
        for sub_index in range(1, count + 1):
            member = draw(variables(index, sub_index))
            member.name = f"{member.name} {sub_index}"
            structure.add_member(member)
        dictionary.add_object(structure)
    return dictionary


@given(dictionaries(), st.sampled_from(["eds", "dcf"]))
@settings(deadline=None, max_examples=60)
def test_what_is_exported_is_read_back(dictionary: ObjectDictionary, form: str) -> None:
    file = io.StringIO()
    export_od(dictionary, file, form)
    read = parse_eds(Path(f"exported.{form}"), file.getvalue(), 5)
    entries = {known.mux: known for known in read.listing.entries}
    found = [str(finding) for finding in read.findings if finding.severity is Severity.ERROR]
    assert found == [
        f"exported.{form}: error: there is no section [{index}]. "
        "[eds.mandatory-object, CiA 301 clause 7.5.2]"
        for index in ("1001", "1018")
    ]
    members = [
        member
        for item in dictionary.values()
        for member in ([item] if isinstance(item, ODVariable) else item.values())
    ]
    assert {Multiplexer(member.index, member.subindex) for member in members} == set(entries)
    for member in members:
        known = entries[Multiplexer(member.index, member.subindex)]
        assert known.data_type == member.data_type
        assert known.access == member.access_type
        assert known.name == member.name
        assert (known.low, known.high) == (member.min, member.max)
        assert known.data_type is not None
        due = None if member.default is None else encode_number(known.data_type, member.default)
        assert known.default == due
