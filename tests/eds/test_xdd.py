"""XDD and XDC list the same as an EDS does; hostile XML ends in a sentence."""

import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conformance.device.eds_listing import ObjectType
from conformance.device.files import FileError
from conformance.device.known_objects import KnownObject
from conformance.eds.reading import LARGEST_XML, commissioned_node_id, read_file
from conformance.eds.xdd import sections_of_xml
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType

PATH = Path(__file__).parent / "files" / "sensor.xdd"
TEXT = PATH.read_text(encoding="utf-8")


def entry(index: int, sub_index: int = 0) -> KnownObject:
    known = read_file(PATH, 5).listing.find(Multiplexer(index, sub_index))
    assert known is not None
    return known


def test_all_objects_are_listed_and_right() -> None:
    file = read_file(PATH, 5)
    assert file.findings == ()
    assert [f"{index:04X}" for index in file.listing.objects] == (
        ["1000", "1001", "1014", "1017", "1018", "2000", "6000"]
    )
    assert file.listing.identity == {1: 0x2F1, 2: 0x10}
    assert file.listing.objects[0x6000].object_type is ObjectType.ARRAY
    assert commissioned_node_id(file.sections) == 5


def test_values_of_objects_and_of_parameters() -> None:
    assert entry(0x1014).default == bytes.fromhex("85000000")
    offset = entry(0x2000)
    assert (offset.data_type, offset.access) == (DataType.INTEGER16, Access.RW)
    assert (offset.default, offset.low, offset.high) == (bytes.fromhex("FBFF"), -100, 100)
    inputs = entry(0x6000, 1)
    assert (inputs.floats, inputs.mappable, inputs.data_type) == (True, True, DataType.UNSIGNED8)


def test_a_finding_has_the_line_of_its_element(tmp_path: Path) -> None:
    path = tmp_path / "faulty.xdc"
    path.write_text(TEXT.replace('accessType="rw" defaultValue="0"', 'accessType="w"'), "utf-8")
    (finding,) = read_file(path, 5).findings
    line = 1 + TEXT[: TEXT.index('index="1017"')].count("\n")
    assert finding.where == f"{path}:{line}"
    assert finding.rule.id == "eds.access"


BOMB = "<!DOCTYPE x [<!ENTITY a 'aaaaaaaaaa'>" + "".join(
    f"<!ENTITY {name} '{f'&{previous};' * 10}'>"
    for previous, name in zip("abcdefgh", "bcdefghi", strict=True)
)
ATTRIBUTES = " ".join(f"a{number}='1'" for number in range(400_000))
HOSTILE = {
    "entities": (f"{BOMB}]><x>&i;</x>", "line 1: there is a <!DOCTYPE: no XDD or XDC has any."),
    "files": ("<!DOCTYPE x [<!ENTITY a SYSTEM 'file:///etc/passwd'>]><x>&a;</x>", "<!DOCTYPE"),
    "depth": ("<x>" * 100_000, "this is no XML: Excessive depth"),
    "elements": ("<x>" + "<y/>" * 1_500_000, "more than 100000 elements: no XDD or XDC has any."),
    "attributes": (f"<x {ATTRIBUTES}/>", "line 1: more than 128 KiB in an element"),
    "some attributes": (f"<x {ATTRIBUTES[:130_000].rpartition(' ')[0]}/>", "no CANopenObjectList"),
    "text": ("no XML at all", "line 1: this is no XML: Start tag expected"),
    "nothing": ("", "this is no XML"),
    "another": ("<html/>", "there is no CANopenObjectList: is this an XDD or XDC?"),
    "size": (" " * (LARGEST_XML + 1), "the file is larger than 8192 KiB: is it the right one?"),
}


@pytest.mark.parametrize(("text", "sentence"), HOSTILE.values(), ids=HOSTILE)
def test_hostile_files(tmp_path: Path, text: str, sentence: str) -> None:
    path = tmp_path / "hostile.xdd"
    path.write_text(text, encoding="utf-8")
    begin = time.process_time()
    with pytest.raises(FileError) as caught:
        read_file(path, 5)
    assert sentence in str(caught.value)
    assert time.process_time() - begin < 10


def test_a_huge_tree_takes_little_memory(tmp_path: Path) -> None:
    """All bytes that a file may have are elements; 200 MB are what a run may take."""
    path = tmp_path / "hostile.xdd"
    path.write_text(f"<x>{'<y/>' * 2_000_000}", encoding="utf-8")
    program = (
        "import sys; from conformance.__main__ import main; main(['eds', sys.argv[1]]);"
        "print(open('/proc/self/status').read().partition('VmHWM:')[2].split()[0])"
    )
    command = [sys.executable, "-c", program, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603
    assert int(done.stdout.splitlines()[-1]) < 200 * 1024


@given(st.data())
@settings(deadline=None, max_examples=100)
def test_mutated_files(data: st.DataObject) -> None:
    """Parts left out, doubled or replaced: a list of objects, or a sentence."""
    text = TEXT
    for _ in range(data.draw(st.integers(1, 4))):
        first = data.draw(st.integers(0, len(text) - 1))
        last = data.draw(st.integers(first, min(len(text), first + 40)))
        text = (
            text[:first] + data.draw(st.sampled_from(["", text[first:last] * 2, "0"])) + text[last:]
        )
    with suppress(FileError):
        assert "DeviceInfo" in sections_of_xml(Path("x.xdd"), text.encode())
