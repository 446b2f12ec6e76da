"""Each rule for descriptions catches a faulty file, and passes a right one."""

import re
from pathlib import Path

import pytest

from conformance.eds.reading import DeviceFile, read_file
from conformance.eds.rules import RULES

FILES = Path(__file__).parent / "files"
RIGHT = (FILES / "right.eds").read_text(encoding="utf-8")

# By rule: what stands in the right file, and what in the faulty one.
FAULTS = {
    "encoding": ("Written for tests", "Geschrieben für Tests"),
    "line-length": ("Line1=Written", f"Line1={'x' * 300}"),
    "line": ("[Comments]", "[Comments]\nWritten for tests"),
    "section-name": ("[2000]", "[2000su1]\nParameterName=x\n[2000]"),
    "section-twice": ("[2000]", "[1000]\n[2000]"),
    "key-twice": ("ObjFlags=0x1", "ObjFlags=0x1\nObjFlags=0x1"),
    "misspelt": ("AccessType=rww", "AccesType=rww"),
    "mandatory-section": ("[FileInfo]", "[File]"),
    "mandatory-object": ("[1001]", "[2001]"),
    "list-entry": ("3=0x2002", "3=2002 and 2003"),
    "list-count": ("SupportedObjects=10", "SupportedObjects=9"),
    "list-range": ("3=0x2002", "3=0x6002"),
    "listed-twice": ("3=0x2002", "3=0x2001"),
    "listed": ("3=0x2002", "3=0x2003"),
    "unlisted": ("3=0x2002", "3=0x2003"),
    "orphan": ("[2000]", "[2003sub1]\n[2000]"),
    "object-type": ("ObjectType=0x8\nDataType=0x0005", "ObjectType=0x3\nDataType=0x0005"),
    "structure": ("CompactSubObj=4", "CompactSubObj=0"),
    "sub-number": ("SubNumber=5", "SubNumber=4"),
    "sub-index": ("[2000]", "[6000sub100]\n[2000]"),
    "compact": ("CompactSubObj=4", "CompactSubObj=255"),
    "highest-missing": ("[6000sub0]", "[6000sub2]"),
    "highest": ("DefaultValue=4\n", "DefaultValue=5\n"),
    "data-type-area": ("[2000]", "[0005]\nParameterName=UNSIGNED8\n[2000]"),
    "name": ("ParameterName=Offset", f"ParameterName={'x' * 242}"),
    "access": ("AccessType=rww", "AccessType=w"),
    "data-type": ("DataType=0x0003", "DataType=0x000E"),
    "number": ("ObjFlags=0x1", "ObjFlags=one"),
    "number-style": ("$NODEID+0x200", "0x200+$NODEID"),
    "value-type": ("DefaultValue=-5", "DefaultValue=-55555"),
    "sign": ("DefaultValue=0xFE", "DefaultValue=-2"),
    "limit-type": ("HighLimit=0x00FF", "HighLimit=0x100FF"),
    "limit-order": ("HighLimit=0x00FF", "HighLimit=0xFE00"),
    "within-limits": ("DefaultValue=-5", "DefaultValue=256"),
    "obj-flags": ("ObjFlags=0x1", "ObjFlags=0x5"),
    "pdo-mapping": ("PDOMapping=0", "PDOMapping=2"),
    "identity": ("VendorNumber=0x000002F1", "VendorNumber=0x000002F2"),
    "standard-type": (
        "DataType=0x0006\nAccessType=rw\nDefaultValue=0\n",
        "DataType=0x0005\nAccessType=rw\n",
    ),
    "standard-access": ("AccessType=ro\nDefaultValue=0x00020191", "AccessType=rw"),
    "standard-sub-index": ("[1018sub4]", "[1018sub5]"),
    "standard-name": ("ParameterName=Identity object", "ParameterName=Label"),
    "vendor-id": ("DefaultValue=0x2F1", "DefaultValue=0"),
    "transmission-type": ("DefaultValue=0xFE", "DefaultValue=0xFB"),
    "cob-id": ("DefaultValue=$NODEID+0x80", "DefaultValue=0x80"),
    "cob-id-twice": ("$NODEID+0x40000180", "$NODEID+0x40000200"),
    "error-control": ("1017", "1015"),
    "pdo-pair": ("1A00", "1A01"),
    "pdo-count": ("NrOfRXPDO=1", "NrOfRXPDO=2"),
    "mapped-object": ("0x60000108", "0x60000208"),
    "mapped-access": ("0x60000108", "0x20000010"),
    "mapped-length": ("0x20010010", "0x200100F0"),
    "process-data": ("DefaultValue=0\nPDOMapping=1", "DefaultValue=0\nPDOMapping=0"),
    "dummy": ("Dummy0005=1", "Dummy0005=0"),
    "dummy-usage": ("Dummy0007=0", "Dummy0007=7"),
    "file-info": ("FileVersion=1\n", ""),
    "dates": ("03-14-2019", "2019-03-14"),
    "device-info": ("ProductName=Sensor\n", ""),
    "bit-rate": ("BaudRate_800=0", "BaudRate_800=yes"),
    "switch": ("Granularity=8", "Granularity=65"),
    "comments": ("Lines=1", "Lines=2"),
    "commissioned": ("NodeID=5", "NodeID=128"),
}


def found(file: DeviceFile) -> set[str]:
    return {finding.rule.id.removeprefix("eds.") for finding in file.findings}


@pytest.mark.parametrize(("rule", "change"), FAULTS.items())
def test_a_faulty_file_is_caught(rule: str, change: tuple[str, str], tmp_path: Path) -> None:
    assert change[0] in RIGHT
    path = tmp_path / "faulty.eds"
    path.write_text(RIGHT.replace(*change), encoding="utf-8")
    assert rule in found(read_file(path, 5))


def test_the_right_file_passes() -> None:
    assert read_file(FILES / "right.eds", 5).findings == ()


def test_each_rule_has_a_faulty_file() -> None:
    untried = {rule.id.removeprefix("eds.") for rule in RULES} - set(FAULTS)
    assert untried == {"readable"}, "test_eds_findings.py and test_eds_command.py have those"


def test_rules_are_as_those_on_sdo() -> None:
    assert len({rule.id for rule in RULES}) == len(RULES)
    for rule in RULES:
        assert re.fullmatch(r"CiA 30[16](-1)? clauses? [0-9.]+( (and|to) [0-9.]+)?", rule.clause)
        assert rule.sentence.endswith(".")
