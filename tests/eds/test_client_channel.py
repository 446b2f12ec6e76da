"""The channel of a client out of its own EDS or DCF, and what is said of a file without it."""

from pathlib import Path

import pytest

from conformance.device.files import FileError
from conformance.device.option_kinds import ClientRecord, parse_channel
from conformance.eds.client_channel import read_client_channel
from conformance.sdo.cob_id import ChannelError, ChannelIds

PLC = Path(__file__).parent / "files" / "plc.dcf"
TEXT = PLC.read_text(encoding="utf-8")
NODE_ID = 5


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("640:5C0", ChannelIds.parse("640:5C0")),
        ("plc.dcf:1280", ClientRecord(Path("plc.dcf"), 0x1280)),
        ("../line 3/plc.EDS:0x12ff", ClientRecord(Path("../line 3/plc.EDS"), 0x12FF)),
        (r"C:\plc.dcf:1281h", ClientRecord(Path(r"C:\plc.dcf"), 0x1281)),
    ],
)
def test_what_names_a_channel(text: str, found: ChannelIds | ClientRecord) -> None:
    assert parse_channel(text) == found


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("plc.dcf", "'plc.dcf' does not say which record of the file: write plc.dcf:1280"),
        (r"C:\plc.dcf", "does not say which record"),
        ("plc.dcf:", "'' is no SDO client parameter record: write 1280 to 12FF"),
        ("plc.dcf:1200", "'1200' is no SDO client parameter record"),
        ("plc.dcf:640:5C0", "'5C0' is no SDO client parameter record"),
        ("1280", "write REQUEST:RESPONSE in hexadecimal, as in 640:5C0, or FILE:RECORD"),
    ],
)
def test_what_names_none(text: str, reason: str) -> None:
    with pytest.raises(ChannelError) as caught:
        parse_channel(text)
    assert reason in str(caught.value)


@pytest.mark.parametrize(
    ("index", "node_id", "channel"),
    [
        (0x1280, NODE_ID, "640:5C0"),
        (0x1281, 0x20, "681:6A1"),
        (0x1283, NODE_ID, "18FF0B05:18FF0C05"),
        (0x12FF, NODE_ID, "6A1:6C1"),
    ],
    ids=["configured", "default", "29-bit", "formula"],
)
def test_the_channel_of_a_record(index: int, node_id: int, channel: str) -> None:
    """A formula counts from the node-ID of the client, which is not that of the device."""
    assert read_client_channel(PLC, index, node_id) == ChannelIds.parse(channel)


WITHOUT_NODE_ID = ("NodeID=1\n", "")
WRONG = [
    (0x1284, None, None, "there is no SDO client parameter record 1284h; there are 1280h, 1281h"),
    (0x1281, None, "[1281]", "1281h is no channel to node 5: its server is node 32, not node 5."),
    (0x1282, None, "[1282]", "000h has bit 31 set: this SDO channel does not exist."),
    (0x12FF, WITHOUT_NODE_ID, "DefaultValue=$NODEID+0x6A0", "depends on the node-ID of the client"),
    (0x1280, ("0\nParameterValue=5", "0"), "[1280]", "0 is no node-ID"),
    (0x1280, ("ParameterValue=0x5C0", "ParameterValue=0x640"), "[1280]", "both requests and"),
    (0x1280, ("ParameterValue=0x640", "ParameterValue=0x1640"), "[1280]", "1640h has more than"),
    (0x1281, ("DefaultValue=0x681\n", ""), "[1281sub1]", "neither a ParameterValue nor a Default"),
    (0x1281, ("[1281sub3]", "[1281sub4]"), "[1281]", "1281h has no sub-index 3: an SDO client"),
    (0x1280, ("NodeID=1\n", "NodeID=one\n"), "NodeID=one", "NodeID='one' is no number"),
]  # fmt: skip


@pytest.mark.parametrize(("index", "change", "at", "sentence"), WRONG)
def test_a_record_that_is_no_channel(
    tmp_path: Path, index: int, change: tuple[str, str] | None, at: str | None, sentence: str
) -> None:
    text = TEXT.replace(*change, 1) if change else TEXT
    path = tmp_path / "plc.dcf"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FileError) as caught:
        read_client_channel(path, index, NODE_ID)
    line = text.split("\n").index(at) + 1 if at else None
    assert caught.value.line == line
    assert sentence in str(caught.value)


def test_without_a_node_id_what_is_no_formula_is_read(tmp_path: Path) -> None:
    path = tmp_path / "plc.eds"
    path.write_text(TEXT.replace(*WITHOUT_NODE_ID), encoding="utf-8")
    assert read_client_channel(path, 0x1280, NODE_ID) == ChannelIds.parse("640:5C0")


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("gone.dcf", "the file cannot be read: No such file or directory."),
        ("plc.txt", "the name of the file has to end in .eds, .dcf, .xdd or .xdc."),
    ],
)
def test_a_file_that_is_none(tmp_path: Path, name: str, sentence: str) -> None:
    with pytest.raises(FileError) as caught:
        read_client_channel(tmp_path / name, 0x1280, NODE_ID)
    assert sentence in str(caught.value)


def test_a_device_without_records() -> None:
    with pytest.raises(FileError) as caught:
        read_client_channel(PLC.with_name("encoder.dcf"), 0x1280, NODE_ID)
    assert "no SDO client parameter record 1280h; there is none at all." in str(caught.value)
