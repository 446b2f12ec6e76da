"""``device.toml``: what it may say, and the sentence for what it may not."""

import os
import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from conformance.device import options as table
from conformance.device.description import Description, read_description
from conformance.device.files import FileError
from conformance.device.known_deviations import KnownDeviation
from conformance.device.known_objects import KnownObject
from conformance.device.named_objects import NamedObject
from conformance.device.protected_objects import PERMISSIONS, PROTECTED
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType

UNHURRIED = settings(
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
EVERYTHING = """\
node-id = 5
eds = "drive.eds"
permissions = ["nmt", "load-defaults"]

[can]
interface = "socketcan"
channel = "can1"
bitrate = 250000
options = {host = "bench7", port = 29536, tcp_tune = true}

[objects]
writable = ["2001", "2010:01", "2030=visible_string,wo"]
large = "2020=domain"
never = ["2100", "2101:02"]

[timing]
response = 0.5
server-timeout = 2
storage = 12

[process]
command = ["./my_server", "vcan0"]
recover = "./power-cycle.sh {node_id}"

[[deviations]]
case = "block-download.crc-mismatch"
reason = "ticket 123"
rule = "block.crc"

[[deviations]]
case = "od.default[1008h:00]"
reason = "ticket 124"
"""


def read(folder: Path, text: str) -> Description:
    path = folder / "device.toml"
    path.write_text(text, encoding="utf-8")
    return read_description(path)


def test_everything(tmp_path: Path) -> None:
    said = read(tmp_path, EVERYTHING)
    assert said.folder == tmp_path
    assert said.values == {
        table.NEVER: said[table.NEVER],
        table.NODE_ID: [5],
        table.EDS: tmp_path / "drive.eds",
        table.INTERFACE: "socketcan",
        table.CHANNEL: "can1",
        table.BIT_RATE: 250000,
        table.CAN_OPTIONS: (("host", "bench7"), ("port", "29536"), ("tcp_tune", "True")),
        table.WRITABLE: (
            NamedObject(KnownObject(Multiplexer(0x2001)), is_whole=True),
            NamedObject(KnownObject(Multiplexer(0x2010, 1)), is_whole=False),
            NamedObject(
                KnownObject(Multiplexer(0x2030), DataType.VISIBLE_STRING, Access.WO),
                is_whole=False,
            ),
        ),
        table.ALL_RW: False,
        table.LARGE: KnownObject(Multiplexer(0x2020), DataType.DOMAIN),
        table.RESPONSE_TIMEOUT: 0.5,
        table.SERVER_TIMEOUT: 2.0,
        table.STORAGE_TIME: 12.0,
        table.PROCESS: ("./my_server", "vcan0"),
        table.RECOVER: ("./power-cycle.sh", "{node_id}"),
        table.ALLOW: ("nmt", "load-defaults"),
        table.KNOWN_DEVIATIONS: (
            KnownDeviation("block-download.crc-mismatch", "ticket 123", "block.crc"),
            KnownDeviation("od.default[1008h:00]", "ticket 124"),
        ),
    }
    assert {mux for mux in said[table.NEVER] if mux.index == 0x2101} == {Multiplexer(0x2101, 2)}
    assert len([mux for mux in said[table.NEVER] if mux.index == 0x2100]) == 256, "the whole object"


def test_nothing(tmp_path: Path) -> None:
    assert read(tmp_path, "") == Description(tmp_path)


@pytest.mark.parametrize("how", ['"all-rw"', '["all-rw"]', '["2001", "all-rw"]'])
def test_all_that_the_eds_calls_rw(tmp_path: Path, how: str) -> None:
    said = read(tmp_path, f"[objects]\nwritable = {how}\n")
    assert said[table.ALL_RW]
    assert len(said[table.WRITABLE]) == how.count("2001")


def test_a_bit_rate_in_words(tmp_path: Path) -> None:
    assert read(tmp_path, "[can]\nbitrate = '500k'\n")[table.BIT_RATE] == 500_000


def test_permissions_as_a_table(tmp_path: Path) -> None:
    text = "[permissions]\nnmt = true\nsdo-parameters = true\npdo-parameters = false\n"
    assert read(tmp_path, text)[table.ALLOW] == ("nmt", "sdo-parameters")


WRONG = {
    "nodeid = 5": "line 1: there is no key 'nodeid'. Did you mean 'node-id'?",
    "node-id = 0": "line 1: node-id = '0': node-IDs go from 1 to 127.",
    "\nnode-id = true": "line 2: node-id = 'True': node-IDs go from 1 to 127.",
    "node-id = 'x'": "line 1: node-id = 'x': node-IDs go from 1 to 127.",
    "eds = 5": "line 1: eds = '5': write the name of a file.",
    "[cam]\nchannel = 'can0'": "line 1: there is no key 'cam'. Did you mean 'can'?",
    "[can]\nchanel = 'can0'": "line 2: there is no key 'chanel' in [can]. Did you mean 'channel'?",
    "[can]\nbitrate = 'fast'": "line 2: bitrate = 'fast': write bit/s, as in 500000, 500k or 1M.",
    "[can]\nbitrate = 500": "line 2: bitrate = '500': write bit/s, as in 500000, 500k or 1M.",
    "can = 1": "line 1: can has to be a table: write [can].",
    "can.channel = 7": "line 1: channel = '7': write a name, as in \"can0\".",
    "[objects]\n\nwritable = 2001": (
        'line 3: writable = \'2001\': write a list, as in ["2001", "2010:01=unsigned16"], or '
        '"all-rw".'
    ),
    "[objects]\nwritable = ['2001', '2002=unsinged8']": (
        "line 2: There is no type in '2002=unsinged8' called 'unsinged8'. Did you mean 'unsigned8'?"
    ),
    "[objects]\nnever = ['x']": (
        "line 2: 'x' does not name an object: write INDEX[:SUB][=TYPE[,ACCESS]] in hexadecimal, "
        "for example 2001, 2010:01, 2010:01=unsigned16 or 2020=visible_string,rw."
    ),
    "[objects]\nlarge = ['2020']": (
        'line 2: large = "[\'2020\']": write an object, as in "2020=domain".'
    ),
    "[timing]\nresponse = 0": "line 2: response = '0': write seconds, as in 0.5.",
    "[timing]\nresponse = nan": "line 2: response = 'nan': write seconds, as in 0.5.",
    "[timing]\nserver-timeout = 'long'": (
        "line 2: server-timeout = 'long': write seconds, as in 0.5."
    ),
    "[can]\noptions = ['port=1']": (
        "line 2: options = \"['port=1']\": write a table, as in {port = 29536}."
    ),
    '[process]\nrecover = "\'"': ('line 2: recover = "\'": write a command, as in "./cycle.sh".'),
    "[process]\ncommand = []": "line 2: command = '[]': write a list, as in [\"./my_server\"].",
    "[permissions]\nload-default = true": (
        "line 2: there is no key 'load-default' in [permissions]. Did you mean 'load-defaults'?"
    ),
    "[permissions]\nnmt = 1": "line 2: nmt = '1': write true or false.",
    "permissions = ['mnt']": "line 1: there is no permission 'mnt'. Did you mean 'nmt'?",
    "[deviations]\ncase = 'x'": "line 1: write [[deviations]], in double brackets.",
    "[[deviations]]\ncase = 'x'": (
        "line 2: a deviation needs a case or a rule, and a reason, which says why it is excused."
    ),
    "[[deviations]]\ncase = 'x'\nreason = 'y'\n[[deviations]]\ncase = 'z'\nreson = 'a'": (
        "line 6: there is no key 'reson' in [deviations]. Did you mean 'reason'?"
    ),
    "node-id = 5\nnode-id = 6": "line 2: no TOML: Cannot overwrite a value.",
    "node-id 5": "line 1: no TOML: Expected '=' after a key in a key/value pair.",
    "[can": "line 1: no TOML: Expected ']' at the end of a table declaration.",
}


@pytest.mark.parametrize(("text", "expected"), WRONG.items(), ids=WRONG)
def test_sentences(tmp_path: Path, text: str, expected: str) -> None:
    with pytest.raises(FileError) as caught:
        read(tmp_path, text)
    assert str(caught.value) == f"{tmp_path / 'device.toml'}, {expected}"


HOSTILE = {
    "deep arrays": "x = " + "[" * 30_000,
    "deep tables": "x = " + "{a=" * 15_000,
    "a long dotted key": "a" + ".a" * 30_000 + " = 1",
    "a long table name": "[a" + ".a" * 30_000 + "]",
    "a huge number": "node-id = " + "9" * 60_000,
    "an endless text": 'eds = """' + "\n" * 60_000,
    "a number too long to be shown": "node-id = 0x" + "F" * 4_000,
    "such a number in a list": "permissions = [0x" + "F" * 4_000 + "]",
    "such a bit rate": "[can]\nbitrate = 0x" + "F" * 4_000,
    "such an option": "[can]\noptions = {port = 0x" + "F" * 4_000 + "}",
    "many long dotted keys": "\n".join(f"a{n}" + ".b" * 2_000 + " = 1" for n in range(200)),
    "many dotted keys": "\n".join(f"a{n}" + ".b" * 40 + " = 1" for n in range(5_000)),
    "a list of everything": "[objects]\nnever = [" + '"2000",\n' * 50_000 + "]",
    "blanks behind brackets": 'eds = """\n'
    + ("[" + " " * 4000 + "\n") * 200
    + '"""\nnode-id = 400',
    "many quotes": "eds = " + '"' * 60_000,
    "many comments": "#\n" * 30_000,
    "many keys": "\n".join(f"k{number} = 1" for number in range(5_000)),
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_hostile_files_end_soon(tmp_path: Path, text: str) -> None:
    begin = time.process_time()
    assert len(outcome(tmp_path, text)) < 600
    assert time.process_time() - begin < 5


def test_a_pipe_is_no_file(tmp_path: Path) -> None:
    """To open it is to wait for a writer."""
    os.mkfifo(tmp_path / "device.toml")
    with pytest.raises(FileError, match="that is a pipe or a device, and no file"):
        read_description(tmp_path / "device.toml")


def test_files_that_are_no_text(tmp_path: Path) -> None:
    path = tmp_path / "device.toml"
    for content, expected in (
        (b"node-id = 5\n# \xff", "line 2: the text is not in UTF-8: save it in UTF-8."),
        (b"n\0o\0", "line 1: a byte of 0: this is no text file, or one in UTF-16."),
        (b"#" * 10_000_000, "the file is larger than 1024 KiB: is it the right one?"),
    ):
        path.write_bytes(content)
        with pytest.raises(FileError) as caught:
            read_description(path)
        assert str(caught.value).endswith(expected)


@UNHURRIED
@given(text=st.text(max_size=200))
def test_any_text(tmp_path: Path, text: str) -> None:
    outcome(tmp_path, text.replace("\ud800", ""))


TEXTS = ["1979-05-27", "'''x", '"\\u0000"', "999999999999999999999999999"]
LISTS = ["[]", "[1]", '["2001"]', "[[]]", "{}", "{a=1}"]
VALUES = st.sampled_from(["1", "-1", "0.5", "true", "inf", '"x"', '""', *TEXTS, *LISTS])


@UNHURRIED
@given(data=st.data())
def test_mutated_files(tmp_path: Path, data: st.DataObject) -> None:
    lines = EVERYTHING.split("\n")
    for _ in range(data.draw(st.integers(1, 5))):
        number = data.draw(st.integers(0, len(lines) - 1))
        key, equals, _ = lines[number].partition(" = ")
        match data.draw(st.sampled_from(["value", "value", "double", "drop", "cut"])):
            case "value" if equals:
                lines[number] = f"{key} = {data.draw(VALUES)}"
            case "double":
                lines.insert(data.draw(st.integers(0, len(lines))), lines[number])
            case "drop" if len(lines) > 1:
                del lines[number]
            case _:
                lines[number] = lines[number][: data.draw(st.integers(0, 12))]
    outcome(tmp_path, "\n".join(lines))


def outcome(folder: Path, text: str) -> str:
    """Return what is said of a text; empty when nothing is wrong."""
    try:
        read(folder, text)
    except FileError as error:
        return str(error)
    return ""


def test_each_group_of_objects_has_a_permission() -> None:
    """What design.md lists, and what is like it."""
    for first, last in (
        (0x1010, 0x1011),
        (0x1014, 0x1017),
        (0x1020, 0x1020),
        (0x1200, 0x12FF),
        (0x1400, 0x1BFF),
        (0x1F50, 0x1F57),
        (0x1F80, 0x1F80),
    ):
        for index in range(first, last + 1):
            (group,) = [group for group in PROTECTED if group.first <= index <= group.last]
            assert group.permission in PERMISSIONS
