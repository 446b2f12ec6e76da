"""Files of any size, encoding and content: each ends soon, with findings or a sentence."""

import os
import re
import time
from pathlib import Path

import pytest
from eds_bench import DRIVE, FILES, parse, sentence
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from conformance.device.files import FileError
from conformance.eds.reading import LARGEST, read_eds, read_file

ALL_LINES = [
    (FILES / name).read_text(encoding="cp1252").split("\n")
    for name in ("drive.eds", "io_module.eds", "encoder.dcf")
]
# A busy machine is no failure, a hanging reader is.
UNHURRIED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow], max_examples=200)


@pytest.mark.parametrize(
    ("content", "name"),
    [
        (DRIVE.replace("\n", "\r\n").encode(), ""),
        (DRIVE.replace("\n", "\r").encode(), ""),
        (b"\xef\xbb\xbf" + DRIVE.encode(), ""),
        (DRIVE.encode("utf-16"), "UTF-16"),
        (DRIVE.replace("BL-60", "\u00e4").encode("cp1252"), "CP1252"),
        (DRIVE.replace("BL-60", "\u00e4").encode(), "UTF-8"),
        (DRIVE.encode().replace(b"BL-60", b"\x81"), "LATIN-1"),
    ],
)
def test_encodings_and_ends_of_lines(tmp_path: Path, content: bytes, name: str) -> None:
    path = tmp_path / "drive.eds"
    path.write_bytes(content)
    file = read_file(path, 5)
    assert len(file.listing.entries) == len(parse(DRIVE).listing.entries)
    texts = [one.made for one in file.findings if one.rule.id == "eds.encoding"]
    assert not name or texts == [f"The file is read as {name}"]


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"[DeviceInfo]\n\0D\0", "line 2: a byte of 0: this is no text file."),
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
    with pytest.raises(FileError, match=r"has to end in \.eds, \.dcf, \.xdd or \.xdc"):
        read_eds(tmp_path / "drive.txt", 5)
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
    entries = parse(text).listing.objects[0x7000].entries
    assert len(entries) == 255
    assert [entries[sub].name for sub in (1, 7, 254)] == ["Speed", "Last", "Speed"]
    assert {known.mux.sub_index for known in entries.values()} == set(range(255))


def section(number: int) -> str:
    return f"[{number:04X}]\nParameterName=x\nDataType=7\nAccessType=rw\nDefaultValue=1\n"


LARGE = {
    "as many objects as go in": DRIVE + "".join(section(index) for index in range(0x7000, 0xF000)),
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
    """Return why a text is no EDS; empty where it is one."""
    try:
        parse(text)
    except FileError as error:
        return str(error)
    return ""


def only_sentences(text: str) -> None:
    told = outcome(text)
    assert not told or (told.startswith("bad.eds") and told.endswith((".", "?")))
