"""A bad EDS ends in a sentence with file, line and what to try; never in a traceback."""

import os
import re
import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from conformance.device.eds import parse_eds, read_eds
from conformance.device.eds_text import LARGEST, MOST_SECTIONS
from conformance.device.files import FileError

FILES = Path(__file__).parent / "files"
PATH = Path("bad.eds")
DRIVE = (FILES / "drive.eds").read_text(encoding="utf-8")
LINES = DRIVE.split("\n")
ALL_LINES = [
    (FILES / name).read_text(encoding="cp1252").split("\n")
    for name in ("drive.eds", "io_module.eds", "encoder.dcf")
]
# A busy machine is no failure, a hanging reader is.
UNHURRIED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow], max_examples=200)


def parse(text: str) -> None:
    parse_eds(PATH, text, 5)


def sentence(text: str) -> str:
    with pytest.raises(FileError) as caught:
        parse(text)
    return str(caught.value)


def line_of(content: str, behind: str = "[FileInfo]") -> int:
    """Return the number of the line, as an editor shows it, that comes behind another one."""
    return LINES.index(content, LINES.index(behind)) + 1


def test_so_many_sections_has_no_device() -> None:
    many = "".join(f"[x{number}]\n" for number in range(MOST_SECTIONS))
    assert f"more than {MOST_SECTIONS} sections" in sentence(DRIVE + many)


REPLACED = {
    "AccessType=rww": (
        "AccesType=rww",
        "[6040] has no AccessType, but 'AccesType'. Did you mean 'AccessType'?",
    ),
    "AccessType=wo": (
        "AccessType=contsw",
        "AccessType='contsw' is unknown. Did you mean 'const'?",
    ),
    "LowLimit=-4": (
        "LowLimit=-400",
        "LowLimit='-400' is no INTEGER8: INTEGER8 goes from -128 to 127.",
    ),
    "HighLimit=10": (
        "HighLimit=ten",
        "HighLimit='ten' is no INTEGER8: write a number, as 10, 0x0A or $NODEID+0x180.",
    ),
    "LowLimit=0.5": (
        "LowLimit=13",
        "LowLimit 13.0 is above HighLimit 12.5.",
    ),
    "DefaultValue=4": (
        "DefaultValue=444",
        "DefaultValue='444': UNSIGNED8 goes from 0 to 255.",
    ),
    "DefaultValue=-1": (
        "DefaultValue=minus one",
        "DefaultValue='minus one' is no INTEGER24.",
    ),
    "DataType=0x1B": (
        "DataType=0x1C",
        "DataType='0x1C' is no data type: 0x5 is UNSIGNED8, 0x6 UNSIGNED16, "
        "0x7 UNSIGNED32, 0x9 VISIBLE_STRING.",
    ),
    "ObjectType=2": (
        "ObjectType=4",
        "ObjectType='4' is none of 0x2 (DOMAIN), 0x7 (VAR), 0x8 (ARRAY) and 0x9 (RECORD).",
    ),
    "CompactSubObj=0": ("CompactSubObj=255", "CompactSubObj goes up to 254."),
    "[2000sub7]": (
        "[2000sbu7]",
        "[2000sbu7] is no section of an object: write [2000], [2000sub1] or [2000Name].",
    ),
    "[2000sub5]": (
        "[2000sub3]",
        "[2000sub3] is there already, in line N: leave one of them out.",
    ),
    "[2030]": (
        "[2031]",
        "[ManufacturerObjects] lists 2030h, but there is no section [2030].",
    ),
    "1=0x2000": (
        "1=2000h",
        "1='2000h' in [ManufacturerObjects] is no entry of the list: write 1=0x1000.",
    ),
    "[DeviceInfo]": (
        "[DevceInfo]",
        "[DevceInfo] is no section of an EDS. Did you mean [DeviceInfo]?",
    ),
    "[MandatoryObjects]": (
        "[Mandatory]",
        "[Mandatory] is no section of an EDS. Did you mean [MandatoryObjects]?",
    ),
    "PDOMapping=1": (
        "PDOMapping",
        "'PDOMapping' in [6040] is neither Key=Value nor a [section] nor a ; comment.",
    ),
    "ObjFlags=0x1": (
        "DataType=0x1",
        "DataType stands in [6040] already, in line N: leave one of them out.",
    ),
    "[FileInfo]": (
        "FileInfo",
        "'FileInfo' stands before the first [section]: no EDS?",
    ),
    "[1000]": (
        "[1000",
        "'[1000' is no section: write [1018sub1].",
    ),
}


ELSEWHERE = {
    "[2031]": [line_of("4=0x2030")],
    "DataType=0x1": [line_of("ObjFlags=0x1"), line_of("DataType=0x6", behind="[6040]")],
    "[2000sub3]": [line_of("[2000sub5]"), line_of("[2000sub3]")],
}


@pytest.mark.parametrize(("old", "new", "expected"), [(a, *b) for a, b in REPLACED.items()])
def test_sentences(old: str, new: str, expected: str) -> None:
    """Each names the line that was spoiled, and other lines by what stands there."""
    text = DRIVE.replace(old, new, 1)
    spoiled = 1 + DRIVE[: DRIVE.index(old)].count("\n")
    found = sentence(text)
    for line in ELSEWHERE.get(new, [spoiled]):
        assert f"line {line}" in found
    assert re.sub(r"line \d+", "line N", found) == f"bad.eds, line N: {expected}"


def test_what_lacks_a_section() -> None:
    start = DRIVE.index("[1000]")
    without = DRIVE[:start] + DRIVE[DRIVE.index("[1001]") :]
    assert sentence(without) == (
        f"bad.eds, line {line_of('1=0x1000')}: [MandatoryObjects] lists 1000h, but there is no "
        "section [1000]."
    )
    assert sentence("") == (
        "bad.eds: there is no section [DeviceInfo], which every EDS has: is this an EDS?"
    )
    bare = "[DeviceInfo]\n[MandatoryObjects]\n"
    assert sentence(bare) == (
        "bad.eds: there is no section [1000], the device type of every device."
    )
    alone = "[2000]\nParameterName=x\nObjectType=8\n"
    assert sentence(bare + alone) == (
        "bad.eds, line 3: [2000] is an ARRAY and has neither sections [2000sub0] and so on nor "
        "CompactSubObj."
    )
    assert sentence(bare + "[2000sub1]\nParameterName=x\n") == (
        "bad.eds, line 3: [2000sub1] belongs to an object without a section [2000]."
    )


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"\xff\xfe[\0D\0", "line 1: a byte of 0: this is no text file, or one in UTF-16."),
        (b"[DeviceInfo]\n;\x81\n", "line 2: the text is not in UTF-8 nor CP1252: save it in"),
        (b"x" * (LARGEST + 1), "the file is larger than 2048 KiB: is it the right one?"),
    ],
)
def test_files_that_are_no_text(tmp_path: Path, content: bytes, expected: str) -> None:
    path = tmp_path / "bad.eds"
    path.write_bytes(content)
    with pytest.raises(FileError, match=r"bad\.eds") as caught:
        read_eds(path, 5)
    assert expected in str(caught.value)


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"none\.eds: the file cannot be read: No such file"):
        read_eds(tmp_path / "none.eds", 5)
    (tmp_path / "folder.eds").mkdir()
    with pytest.raises(FileError, match="the file cannot be read: Is a directory"):
        read_eds(tmp_path / "folder.eds", 5)
    with pytest.raises(FileError, match=r"has to end in \.eds or \.dcf"):
        read_eds(tmp_path / "drive.xdd", 5)
    # To open it is to wait for a writer.
    os.mkfifo(tmp_path / "pipe.eds")
    with pytest.raises(FileError, match=r"that is a pipe or a device, and no file\."):
        read_eds(tmp_path / "pipe.eds", 5)


def compact(number: int) -> str:
    return (
        f"[{number:04X}]\nParameterName=x\nObjectType=8\nDataType=5\nAccessType=rw\n"
        "CompactSubObj=254\n"
    )


def test_a_small_file_does_not_stand_for_a_million_entries() -> None:
    """One thousand arrays of 254 elements are 80 kB of text."""
    begin = time.process_time()
    told = sentence(DRIVE + "".join(compact(index) for index in range(0x7000, 0x7000 + 1000)))
    assert re.search(r"line \d+: so far the file lists 65\d\d\d entries, by sections and by", told)
    assert time.process_time() - begin < 2


def test_all_elements_of_an_array_are_as_it_is_described() -> None:
    text = DRIVE + compact(0x7000).replace("=x", "=Speed") + "[7000Name]\nNrOfEntries=1\n7=Last\n"
    entries = parse_eds(PATH, text, 5).objects[0x7000].entries
    assert len(entries) == 255
    assert [entries[sub].name for sub in (1, 7, 254)] == ["Speed", "Last", "Speed"]
    assert {known.mux.sub_index for known in entries.values()} == set(range(255))


def entry(number: int) -> str:
    return f"[{number:04X}]\nParameterName=x\nDataType=7\nAccessType=rw\nDefaultValue=1\n"


LARGE = {
    "as many objects as go in": DRIVE + "".join(entry(index) for index in range(0x7000, 0xF000)),
    "one long line of blanks": DRIVE.replace("0x00020192", "1" + " " * 3_000_000 + "1", 1),
    "blanks in a key": DRIVE.replace("ParameterName", "Par" + " " * 3_000_000 + "r", 1),
    "many long lines": DRIVE + "[X]\n" + "".join(f"{n}{' ' * 9000}=\n" for n in range(400)),
    "a huge number": DRIVE.replace("DefaultValue=0x19A", "DefaultValue=" + "9" * 3_000_000, 1),
    "a huge section": DRIVE + "[" * 3_000_000,
    "many semicolons": DRIVE.replace("DefaultValue=0x19A", "DefaultValue=" + ";" * 3_000_000, 1),
    "many lines of nothing": "\n" * 4_000_000,
    "many sections": DRIVE + "".join(f"[x{number}]\n" for number in range(300_000)),
    "a list of misspelt names": "".join(f"[x{number}]\n" for number in range(150_000)),
    "many keys": DRIVE + "[X]\n" + "".join(f"k{number}=1\n" for number in range(300_000)),
}


@pytest.mark.parametrize("text", LARGE.values(), ids=LARGE)
def test_large_files_end_soon(text: str) -> None:
    begin = time.process_time()
    assert len(outcome(text[:LARGEST])) < 400
    # 1 s or 2 on a machine that does nothing else; what is quadratic takes minutes.
    assert time.process_time() - begin < 10


@UNHURRIED
@given(st.text(max_size=400))
def test_any_text(text: str) -> None:
    only_sentences(text)


@UNHURRIED
@given(st.binary(max_size=400))
def test_any_bytes(content: bytes) -> None:
    only_sentences(content.decode("latin-1"))


VALUES = st.one_of(
    st.integers(-(1 << 70), 1 << 70).map(str),
    st.integers(0, 1 << 70).map(hex),
    st.sampled_from(["", "$NODEID", "$NODEID+", "+$NODEID+1", "$NODEID+$NODEID", "0x", "08", "-"]),
    st.sampled_from(["nan", "inf", "1e999", "0b1", "1_0", "rw", "[1000]", "=", ";", "%(x)s", "\r"]),
    st.text(max_size=12),
)


@UNHURRIED
@given(st.data())
def test_mutated_files(data: st.DataObject) -> None:
    """Values replaced, lines doubled, left out or moved, in a file that is right."""
    lines = data.draw(st.sampled_from(ALL_LINES))[:]
    for _ in range(data.draw(st.integers(1, 6))):
        number = data.draw(st.integers(0, len(lines) - 1))
        key, equals, _ = lines[number].partition("=")
        match data.draw(st.sampled_from(["value", "value", "double", "drop", "move", "cut"])):
            case "value" if equals:
                lines[number] = f"{key}={data.draw(VALUES)}"
            case "double":
                lines.insert(data.draw(st.integers(0, len(lines))), lines[number])
            case "drop":
                del lines[number]
            case "move":
                lines.insert(data.draw(st.integers(0, len(lines) - 1)), lines.pop(number))
            case _:
                lines[number] = lines[number][: data.draw(st.integers(0, 12))]
    only_sentences("\n".join(lines))


def outcome(text: str) -> str:
    """Return what is said of a text; empty when nothing is wrong."""
    try:
        parse(text)
    except FileError as error:
        return str(error)
    return ""


def only_sentences(text: str) -> None:
    found = outcome(text)
    assert not found or (found.startswith("bad.eds") and found.endswith((".", "?")))
