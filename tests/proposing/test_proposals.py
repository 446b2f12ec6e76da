"""What is proposed as writable, and what is not: by an EDS, and by how a value reads."""

import re
import struct
from pathlib import Path

import pytest

from conformance.bus.opening import BusSettings
from conformance.device.description import read_description
from conformance.device.known_objects import KnownObject
from conformance.device.options import CHANNEL, NEVER, WRITABLE
from conformance.proposing.additions import PERMISSIONS
from conformance.proposing.finding import Found
from conformance.proposing.proposals import Proposals, by_eds, by_reading, shown, type_of
from conformance.proposing.text import Draft, draft_text
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType


def listed(index: int, name: str = "Name", **what: object) -> KnownObject:
    return KnownObject(Multiplexer(index), DataType.UNSIGNED16, name=name, **what)  # type: ignore[arg-type]


def notes(proposals: Proposals) -> dict[str, str]:
    return {one.known.named: one.note for one in proposals}


def test_what_an_eds_calls_writable() -> None:
    limited = listed(0x2001, "Ramp", low=10, high=500)
    found = by_eds(
        [
            limited,
            listed(0x2002, "Above", low=1),
            listed(0x2003, "Below", high=9),
            listed(0x2004, "Measured", floats=True, low=0, high=0xFFFF),
            KnownObject(Multiplexer(0x2005), DataType.UNSIGNED8, Access.RO, name="Input"),
            KnownObject(Multiplexer(0x2006, 2), DataType.DOMAIN, Access.WO, name="Trace"),
            KnownObject(Multiplexer(0x2007), None, name="Own type"),
            listed(0x1017, "Heartbeat"),
            listed(0x6040, "Controlword"),
        ],
        {limited.mux: b"\x2a\x00"},
    )
    assert notes(found) == {
        "2001=unsigned16": "Ramp; 10 to 500; reads 42",
        "2002=unsigned16": "Above; 1 or more",
        "2003=unsigned16": "Below; 9 at most",
        "2004=unsigned16": "Measured; the device changes it itself",
        "2006:02=domain,wo": "Trace; cannot be read, so it is not restored",
        "2007": "Own type",
        "6040=unsigned16": "Controlword",
    }
    assert [one.known.mux.index for one in found.profile] == [0x6040]


@pytest.mark.parametrize(
    "name",
    [
        "Node-ID",
        "NodeId",
        "Baudrate",
        "CAN bit rate",
        "COB-ID of PDO 9",
        "Password",
        "Serial Number",
        "Program data",
        "Firmware update",
    ],
)
def test_who_the_device_is_stays(name: str) -> None:
    found = by_eds([listed(0x2100, name)], {})
    assert not [*found]
    assert found.never == [(Multiplexer(0x2100), name)]


def test_what_the_eds_excludes_is_left_out() -> None:
    found = by_eds([listed(0x2100, "Trace", flags=1)], {})
    assert not [*found]
    assert found.left_out == [(Multiplexer(0x2100), "Trace: the EDS excludes it (ObjFlags)")]


VALUES = {
    Multiplexer(0x1017): b"\0\0",
    Multiplexer(0x2000): b"\x2c\x01",
    Multiplexer(0x2001): b"\x05",
    Multiplexer(0x2002): struct.pack("<I", 125_000),
    Multiplexer(0x2003): b"\x07\0\0\0",
    Multiplexer(0x2010): b"\x02",
    Multiplexer(0x2010, 1): b"on",
    Multiplexer(0x2010, 2): b"off\0",
    Multiplexer(0x2020): bytes(5000),
    Multiplexer(0x2021): b"",
    Multiplexer(0x6200): b"\xff",
}


def test_what_was_read_without_an_eds() -> None:
    read = Found(VALUES, write_only=[Multiplexer(0x2030)], moving={Multiplexer(0x2003)})
    found = by_reading(read, node_id=5)
    assert notes(found) == {
        "2000=unsigned16": "reads 300",
        "2010:01=unsigned16": "reads 28271",
        "2010:02=visible_string": "reads 'off'",
        "2020=domain": "reads 5000 bytes",
        "2021=domain": "reads nothing",
        "6200=unsigned8": "reads 255",
    }
    assert [one.known.mux.index for one in found.profile] == [0x6200]
    assert found.never == [
        (Multiplexer(0x2001), "reads 5: is it the node-ID?"),
        (Multiplexer(0x2002), "reads 125000: is it the bit rate?"),
    ]
    reasons = dict(found.left_out)
    assert "changes by itself" in reasons[Multiplexer(0x2003)]
    assert '"2030=unsigned32,wo"' in reasons[Multiplexer(0x2030)]
    assert found.long_ones[0].known.named == "2020=domain"


@pytest.mark.parametrize(
    ("value", "data_type"),
    [
        (b"\1", DataType.UNSIGNED8),
        (b"ab", DataType.UNSIGNED16),
        (b"abc", DataType.VISIBLE_STRING),
        (b"3333", DataType.UNSIGNED32),
        (b"\1\2\3", DataType.UNSIGNED24),
        (b"a\nbc", DataType.UNSIGNED32),
        (b"\xe4bcd", DataType.UNSIGNED32),
        (bytes(8), DataType.UNSIGNED64),
        (b"firmware", DataType.VISIBLE_STRING),
        (bytes(5), DataType.DOMAIN),
        (b"", DataType.DOMAIN),
    ],
)
def test_a_type_is_guessed(value: bytes, data_type: DataType) -> None:
    assert type_of(value) is data_type


@pytest.mark.parametrize(
    ("data_type", "value", "text"),
    [
        (DataType.INTEGER16, b"\xfe\xff", "-2"),
        (DataType.INTEGER16, b"\xfe", "1 bytes"),
        (DataType.UNICODE_STRING, b"o\0k\0", "'ok'"),
        (DataType.VISIBLE_STRING, b"x" * 100, "100 bytes"),
        (None, b"abcd", "4 bytes"),
    ],
)
def test_a_value_in_few_words(data_type: DataType | None, value: bytes, text: str) -> None:
    assert shown(data_type, value) == text


HOSTILE = 'a\nb = 1 \x1b[31m\x7f\u2028 """ \''


def test_nothing_that_a_device_says_becomes_a_setting(tmp_path: Path) -> None:
    """Names and texts of a device stand in comments, whatever they hold."""
    mux = Multiplexer(0x2001)
    draft = Draft(
        output=tmp_path / "device.toml",
        source=HOSTILE,
        node_id=5,
        bus=BusSettings("socketcand", HOSTILE, 500_000, (("host", HOSTILE),)),
        eds=f"{HOSTILE}.eds",
        proposals=by_eds([listed(0x2001, HOSTILE), listed(0x2002, f"boot{HOSTILE}")], {}),
        indices={0x1F50},
        about=[HOSTILE],
        remarks=[HOSTILE],
    )
    text = draft_text(draft)
    assert not re.search(r"(?m)^b = 1", text)
    draft.output.write_text(text, encoding="utf-8")
    said = read_description(draft.output)
    assert said[CHANNEL] == HOSTILE
    assert said[WRITABLE] == ()
    assert Multiplexer(0x2002, 7) in said[NEVER]
    draft.output.write_text(re.sub(r"(?m)^#(?=\S)", "", text), encoding="utf-8")
    assert [one.known.mux for one in read_description(draft.output)[WRITABLE]] == [mux]


def drafted(found: Proposals, indices: set[int]) -> str:
    return draft_text(Draft(Path("device.toml"), "node 5", 5, None, None, found, indices))


def test_the_first_choice_for_long_transfers() -> None:
    long_one = by_reading(Found({Multiplexer(0x2020): bytes(5000)}), 5)
    assert '#large = "2020=domain"           # reads 5000 bytes' in drafted(long_one, set())
    short = drafted(by_reading(Found({Multiplexer(0x2020): bytes(50)}), 5), set())
    assert "Nothing was seen to be so long" in short
    assert '#large = "2020=domain"           # reads 50 bytes' in short
    assert "No string or domain was found" in drafted(Proposals(), set())
    unread = drafted(by_eds([KnownObject(Multiplexer(0x2020), DataType.DOMAIN)], {}), set())
    assert '\n#large = "2020=domain"\n' in unread


def test_only_permissions_that_concern_the_device() -> None:
    text = drafted(Proposals(), {0x1018, 0x1400, 0x1F51})
    proposed = set(re.findall(r"(?m)^#(\S+) = true", text))
    assert proposed == {"nmt", "other-nodes", "read-only-probes", "pdo-parameters"}
    assert "Not proposed: programs-and-network" in text
    all_of_them = {index for one in PERMISSIONS for part in one.indices for index in part}
    found = set(re.findall(r"(?m)^#(\S+) = true", drafted(Proposals(), all_of_them)))
    assert found == {one.name for one in PERMISSIONS if one.proposed}
