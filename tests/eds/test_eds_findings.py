"""A bad EDS is read all the same, and each thing that is wrong is a finding with its line."""

import pytest
from eds_bench import DRIVE, FILES, entry, found, ids, parse, sentence

from conformance.device.eds_listing import STRUCTURE_OF_OBJECT
from conformance.eds.findings import MOST_OF_A_RULE
from conformance.eds.reading import DeviceFile, read_eds, read_file
from conformance.eds.text import MOST_SECTIONS
from conformance.sdo.objects import Access, DataType


def test_so_many_sections_has_no_device() -> None:
    many = "".join(f"[x{number}]\n" for number in range(MOST_SECTIONS))
    assert f"more than {MOST_SECTIONS} sections" in sentence(DRIVE + many)


REPLACED = {
    "AccessType=rww": (
        "AccesType=rww",
        ["misspelt: AccesType is no keyword of CiA 306-1. It is read as AccessType."],
    ),
    "AccessType=wo": (
        "AccessType=contsw",
        [
            "access: AccessType=contsw is unknown. Did you mean 'const'?. No case is about the "
            "entry."
        ],
    ),
    "LowLimit=-4": (
        "LowLimit=-400",
        ["limit-type: LowLimit=-400 is no INTEGER8, which goes from -128 to 127. It is left out."],
    ),
    "HighLimit=10": ("HighLimit=ten", ["number: HighLimit=ten is no INTEGER8. It is left out."]),
    "LowLimit=0.5": (
        "LowLimit=13",
        [
            "limit-order: LowLimit=13, the number 13.0, is above HighLimit=12.5, the number 12.5. "
            "Both are left out."
        ],
    ),
    "DefaultValue=4": (
        "DefaultValue=444",
        ["value-type: DefaultValue=444 is no UNSIGNED8, which goes from 0 to 255. It is left out."],
    ),
    "DefaultValue=-1": (
        "DefaultValue=minus one",
        ["number: DefaultValue=minus one is no INTEGER24. It is left out."],
    ),
    "DataType=0x1B": (
        "DataType=0x1C",
        [
            "data-type: DataType=0x1C is no data type: 0x0005 is UNSIGNED8, 0x0006 UNSIGNED16, "
            "0x0007 UNSIGNED32, 0x0009 VISIBLE_STRING. A value may have any length."
        ],
    ),
    "ObjectType=2": (
        "ObjectType=4",
        [
            "data-type: [2010] has no DataType. A value may have any length.",
            "object-type: ObjectType=4 is none of 0x2 (DOMAIN), 0x7 (VAR), 0x8 (ARRAY) and 0x9 "
            "(RECORD). The object is read as a VAR.",
        ],
    ),
    "CompactSubObj=0": (
        "CompactSubObj=255",
        ["compact: CompactSubObj=255 is beyond 254. It is left out."],
    ),
    "[2000sub7]": (
        "[2000sbu7]",
        [
            "sub-number: SubNumber=6, and 5 are described. The sections count.",
            "highest: the default of 2000h:00 is 7, and the highest sub-index that is described "
            "is 5. No case compares it.",
            "section-name: [2000sbu7] is no section of an object: write [2000], [2000sub1] or "
            "[2000Name]. It is left out.",
        ],
    ),
    "[2000sub5]": (
        "[2000sub3]",
        [
            "sub-number: SubNumber=6, and 5 are described. The sections count.",
            "section-twice: [2000sub3] is there already, in line N. The keywords of both are "
            "read; where both have one, the first counts.",
            *[
                f"key-twice: {key} stands in [2000sub3] already, in line N. The first counts."
                for key in ("ParameterName", "DataType", "AccessType", "DefaultValue")
            ],
        ],
    ),
    "[2030]": (
        "[2031]",
        [
            "listed: 2030h is listed, and there is no section [2030]. No case is about the object.",
            "unlisted: [2031] is in none of the lists. It is read as if it were listed.",
        ],
    ),
    "1=0x2000": (
        "1=$000",
        [
            "list-count: SupportedObjects=5, and [ManufacturerObjects] lists 4. All are read.",
            "list-entry: 1=$000 in [ManufacturerObjects] is no entry of the list: write "
            "1=0x1000. It is left out.",
            "unlisted: [2000] is in none of the lists. It is read as if it were listed.",
        ],
    ),
    "[DeviceInfo]": (
        "[DevceInfo]",
        ["misspelt: [DevceInfo] is no section of CiA 306-1. It is read as [DeviceInfo]."],
    ),
    "[MandatoryObjects]": (
        "[Mandatory]",
        ["misspelt: [Mandatory] is no section of CiA 306-1. It is read as [MandatoryObjects]."],
    ),
    "PDOMapping=1": (
        "PDOMapping",
        [
            "line: 'PDOMapping' in [6040] is neither Keyword=Value nor a [section] nor a "
            ";comment. It is left out."
        ],
    ),
    "ObjFlags=0x1": (
        "DataType=0x1",
        ["key-twice: DataType stands in [6040] already, in line N. The first counts."],
    ),
    "[FileInfo]": (
        "FileInfo",
        [
            "mandatory-section: there is no section [FileInfo].",
            *[
                f"line: '{line}' stands before the first [section]. It is left out."
                for line in ("FileInfo", *DRIVE.split("\n")[1:5])
            ],
        ],
    ),
    "[1000]": ("[1000", ["line: '[1000' is no section. It is read as [1000]."]),
}


@pytest.mark.parametrize(("old", "new", "expected"), [(a, *b) for a, b in REPLACED.items()])
def test_findings(old: str, new: str, expected: list[str]) -> None:
    """Each names the line that was spoiled, and what was made of it."""
    file = parse(DRIVE.replace(old, new, 1))
    spoiled = 1 + DRIVE[: DRIVE.index(old)].count("\n")
    assert found(file) == expected
    assert spoiled in [one.place.line for one in file.findings]
    assert len(file.listing.objects) >= 18


KINDS = {
    "int8-limits-00-FF": ["limit-order"],
    "u16-high-65536": ["limit-type"],
    "access-unknown": ["access"],
    "listed-without-section": ["listed"],
    "array-without-entries": ["structure"],
    "default-LL": ["number-style"],
    "mpdo-FE": [],
    "fixed-mapping-5-of-8": [],
    "heartbeat-default-const": [],
    "stored-eds": [],
}


@pytest.mark.parametrize(("name", "rules"), KINDS.items())
def test_kinds_that_vendors_write(name: str, rules: list[str]) -> None:
    file = read_file(FILES / "faulty" / f"{name}.eds", 5)
    assert ids(file) == rules
    assert 0x1018 in file.listing.objects


def test_an_unknown_access_is_that_of_cia_301_where_it_leaves_no_choice() -> None:
    file = parse(DRIVE.replace("AccessType=ro", "AccessType=r", 1))
    assert ids(file) == ["access"]
    assert entry(file.listing, 0x1000).access is Access.RO


def test_what_is_unclear_is_there_and_not_tested() -> None:
    listing = read_eds(FILES / "faulty" / "listed-without-section.eds", 5)
    assert not listing.objects[0x6505].entries
    assert listing.objects[0x6505].unclear == {0, STRUCTURE_OF_OBJECT}
    text = DRIVE.replace("AccessType=ro", "AccessType=r", 40)
    assert parse(text).listing.objects[0x1018].gaps == []


def test_what_lacks_a_section() -> None:
    assert sentence("") == (
        "bad.eds: there is no section of an object, as [1000], which every EDS has: is this an EDS?"
    )
    file = parse("[DeviceInfo]\n[MandatoryObjects]\n[2000sub1]\nAccessType=rw\nDataType=5\n")
    assert found(file) == [
        "mandatory-section: there is no section [FileInfo].",
        "mandatory-object: there is no section [1000]. It is tested all the same.",
        "mandatory-object: there is no section [1001].",
        "mandatory-object: there is no section [1018].",
        "list-count: SupportedObjects=, and [MandatoryObjects] lists 0. All are read.",
        "orphan: [2000sub1] belongs to an object without a section [2000]. The object is read "
        "as a RECORD.",
        "name: [2000sub1] has no ParameterName.",
        "highest-missing: [2000] has no sub-index 00h. It is added, an UNSIGNED8 that is ro.",
    ]
    assert entry(file.listing, 0x1000).data_type is DataType.UNSIGNED32
    assert entry(file.listing, 0x2000).access is Access.RO


def one_entry(text: str) -> DeviceFile:
    return parse(f"{DRIVE}\n[OptionalObjects]\n[2FFF]\nParameterName=x\n{text}\n")


@pytest.mark.parametrize(
    ("data_type", "written", "value", "rule"),
    [
        (2, "0xFF", "FF", ""),
        (2, "0x80", "80", ""),
        (2, "200", "C8", "sign"),
        (2, "-0x01", "FF", ""),
        (2, "0x-1", "FF", "number-style"),
        (5, "-1", "FF", "sign"),
        (5, "0x100", None, "value-type"),
        (6, "010", "0800", ""),
        (6, "08", "0800", "number-style"),
        (6, "0x10UL", "1000", "number-style"),
        (6, "10U", "0A00", "number-style"),
        (6, "10h", "1000", "number-style"),
        (6, "1.0", "0100", "number-style"),
        (6, "", None, ""),
        (7, "$NODEID+0x180", "85010000", ""),
        (7, "$nodeid + 384", "85010000", ""),
        (7, "$NODEID", "05000000", ""),
        (7, "0x180+$NODEID", "85010000", "number-style"),
        (7, "$NODEID-1", "04000000", "number-style"),
        (7, "0x100 + $NODEID + 0x80", "85010000", "number-style"),
        (7, "NODEID+0x180", "85010000", "number-style"),
        (7, "$NODEID+0x80000180", "85010080", ""),
        (7, "0x80000000|0x10", None, "number"),
        (7, "0x10 0x20", None, "number"),
        (1, "true", "01", "number-style"),
        (1, "2", None, "value-type"),
        (8, "1.5", "0000C03F", ""),
        (8, "1,5f", "0000C03F", "number-style"),
        (8, "0x3FC00000", "0000C03F", "number-style"),
        (8, "1e39", None, "value-type"),
        (8, "inf", None, "value-type"),
        (8, "1_0", None, "number"),
        (0x11, "-1.5", "000000000000F8BF", ""),
        (9, "Gr\u00fc\u00dfe", None, "value-type"),
        (9, "text", "74657874", ""),
        (0xA, "0A 1B", "0A1B", ""),
        (0xA, "text", None, "value-type"),
        (0xB, "ab", "61006200", ""),
        (0xF, "anything", None, ""),
    ],
)
def test_values(data_type: int, written: str, value: str | None, rule: str) -> None:
    file = one_entry(f"DataType={data_type:#x}\nAccessType=rw\nDefaultValue={written}")
    known = entry(file.listing, 0x2FFF)
    assert known.default == (None if value is None else bytes.fromhex(value))
    told = [one.rule.id for one in file.findings if one.place.section == "2FFF"]
    assert told == ["eds.unlisted", *([f"eds.{rule}"] if rule else [])]


@pytest.mark.parametrize(
    ("limits", "due"),
    [
        ("LowLimit=0x80\nHighLimit=0x7F", (-128, 127)),
        ("LowLimit=0x00\nHighLimit=0xFF", (None, None)),
        ("LowLimit=-128\nHighLimit=128", (-128, None)),
        ("LowLimit=5\nHighLimit=\nDefaultValue=4", (None, None)),
        ("LowLimit=5\nHighLimit=\nDefaultValue=5", (5, None)),
    ],
)
def test_limits_of_a_signed_type(limits: str, due: tuple[int | None, int | None]) -> None:
    """Hexadecimal ones are the bits of a number; what contradicts itself is left out."""
    known = entry(one_entry(f"DataType=2\nAccessType=rw\n{limits}").listing, 0x2FFF)
    assert (known.low, known.high) == due


def test_a_highest_sub_index_that_the_file_contradicts_is_compared_with_nothing() -> None:
    listing = parse(DRIVE.replace("DefaultValue=7", "DefaultValue=9", 1)).listing
    assert 0 in listing.objects[0x2000].unclear
    assert entry(listing, 0x2000).default is None


def test_an_identity_that_the_file_contradicts_is_compared_with_nothing() -> None:
    file = parse(DRIVE.replace("VendorNumber=0x0000019A", "VendorNumber=0x19B", 1))
    assert ids(file) == ["identity"]
    assert 1 not in file.listing.identity
    assert entry(file.listing, 0x1018, 1).default is None


def test_objects_without_a_section_that_the_file_says_are_there() -> None:
    """CompactPDO leaves out those of PDOs; modules bring objects with them."""
    text = DRIVE.replace("[DeviceInfo]", "[DeviceInfo]\nCompactPDO=1", 1)
    text = text.replace("NrOfRXPDO=4", "NrOfRXPDO=2")
    text += "\n[M1SubExtends]\nNrOfEntries=1\n1=0x6200\n"
    file = parse(text)
    assert not found(file)
    for index in (0x1401, 0x1601, 0x6200):
        assert index in file.listing.objects
    assert 0x1402 not in file.listing.objects


def test_of_one_rule_so_many_findings_are_kept() -> None:
    file = parse(DRIVE + "no key\n" * (MOST_OF_A_RULE + 7))
    assert len(found(file)) == MOST_OF_A_RULE
    assert file.left_out == (("eds.line", 7),)
