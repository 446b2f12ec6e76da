"""conformance init: a draft that a run takes, as it is and with every proposal."""

import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from plugin_runs import NODE_ID, Watched, hosted, run

from conformance.__main__ import main
from conformance.commands.status import WRONG_USE
from conformance.device import options as table
from conformance.device.description import read_description
from conformance.eds.reading import read_eds
from conformance.faults.catalogue import build_node
from conformance.reference.built_in_eds import eds_of
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType

pytest_plugins = ["pytester"]

# Abort, upload initiate and segment, and the frames of a block upload.
READS = re.compile(r"80|4[0-9a-f]|[67]0|a[0-3]")
LAST = 0x22FF


@pytest.fixture(autouse=True)
def _short_search(monkeypatch: pytest.MonkeyPatch, pytester: pytest.Pytester) -> None:
    monkeypatch.setattr("conformance.proposing.reading.LAST_SEARCHED", LAST)


def init(bus: Sequence[str], *arguments: str) -> int:
    words = [word for option in bus for word in option.split("=", 1)]
    return main(["init", *words, *arguments])


def with_all_proposals(path: Path) -> None:
    """Delete each # behind which there is no blank, as the head of the file says."""
    text = path.read_text("utf-8")
    assert "A line that begins with # and no blank is a proposal" in text
    path.write_text(re.sub(r"(?m)^#(?=\S)", "", text), encoding="utf-8")


@pytest.fixture
def device() -> Iterator[tuple[Watched, tuple[str, ...]]]:
    """Host the reference server; yields it, and the options of its bus."""
    watched = Watched(build_node(None, NODE_ID))
    with hosted(watched) as bus:
        yield watched, bus


Hosted = tuple[Watched, tuple[str, ...]]


def test_a_device_is_read_and_no_more(
    device: Hosted, pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    watched, bus = device
    before = {mux: entry.value for mux, entry in watched.node.objects.items()}
    assert init(bus, "--node-id=5") == 0
    assert len(watched.frames) > LAST - 0x1000
    assert {frame.can_id for frame in watched.frames} == {0x605}
    assert not [frame for frame in watched.frames if not READS.match(frame.data.hex())]
    assert {mux: entry.value for mux, entry in watched.node.objects.items()} == before
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("Identity (1018h): vendor-id 0x5D0C0000, product-code 0x5D0C0F0E")
    assert lines[-2:] == ["written: device.toml", "next: pytest --sdo-device=device.toml"]


def test_the_draft_as_it_is(device: Hosted, pytester: pytest.Pytester) -> None:
    """The run reads, and no case writes."""
    watched, bus = device
    assert init(bus, "--node-id", "5") == 0
    description = read_description(pytester.path / "device.toml")
    assert description[table.NODE_ID] == [NODE_ID]
    assert description[table.INTERFACE] == "virtual"
    assert f"--can-channel={description[table.CHANNEL]}" == bus[1]
    assert description[table.WRITABLE] == ()
    assert description[table.ALLOW] == ()
    result = run(pytester, "--sdo-device=device.toml", "-k", "upload. or download.")
    counts = result.parseoutcomes()
    assert result.ret == pytest.ExitCode.OK
    assert counts["passed"] > 10
    assert counts["skipped"] > 50
    downloads = [one for one in watched.frames if one.can_id == 0x605 and one.data[:1] in b"\x23"]
    assert downloads == []


def test_the_draft_with_every_proposal(device: Hosted, pytester: pytest.Pytester) -> None:
    """Types that were guessed of lengths are right for the numbers, and any permission is known."""
    _, bus = device
    assert init(bus, "--node-id", "5", "-o", "all.toml") == 0
    with_all_proposals(pytester.path / "all.toml")
    description = read_description(pytester.path / "all.toml")
    types = {one.known.mux.index: one.known.data_type for one in description[table.WRITABLE]}
    assert types[0x2001] is DataType.UNSIGNED8
    assert types[0x2003] is DataType.UNSIGNED24
    assert types[0x2008] is DataType.UNSIGNED64
    assert types[0x2010] is DataType.VISIBLE_STRING
    assert min(types) == 0x2001
    assert description[table.LARGE] is not None
    assert description[table.RESPONSE_TIMEOUT] == 1.0
    allowed = {*description[table.ALLOW]}
    assert {"nmt", "read-only-probes", "sdo-parameters", "load-defaults"} <= allowed
    assert "programs-and-network" not in allowed
    result = run(pytester, "--sdo-device=all.toml", "-k", "download.same or unused-bytes-ignored")
    assert result.ret == pytest.ExitCode.OK
    assert "skipped" not in result.parseoutcomes()


def test_a_device_and_its_eds(
    device: Hosted, pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    watched, bus = device
    (pytester.path / "eds").mkdir()
    eds = pytester.path / "eds" / "drive.eds"
    eds.write_text(eds_of(build_node(None, NODE_ID)), encoding="utf-8")
    (pytester.path / "bench").mkdir()
    assert init(bus, "--node-id", "5", "--eds", str(eds), "-o", "bench/drive.toml") == 0
    assert len(watched.frames) < 500, "only what the EDS lists is read"
    path = pytester.path / "bench" / "drive.toml"
    assert "could not be read" not in capsys.readouterr().out
    assert read_description(path)[table.WRITABLE] == ()
    with_all_proposals(path)
    description = read_description(path)
    named = description[table.EDS]
    assert named == pytester.path / "bench" / ".." / "eds" / "drive.eds"
    listing = read_eds(named, NODE_ID)
    assert len(description[table.WRITABLE]) > 10
    for known in (one.known for one in description[table.WRITABLE]):
        listed = listing.find(known.mux)
        assert listed is not None
        assert (known.data_type, known.access) == (listed.data_type, listed.access)
    writable = {one.known.mux for one in description[table.WRITABLE]}
    assert Multiplexer(0x2020) in writable, "write-only"
    result = run(pytester, "--sdo-device=bench/drive.toml", "-k", "download.text or od.write-back")
    assert result.ret == pytest.ExitCode.OK
    assert result.parseoutcomes()["passed"] > 20


def test_where_a_device_and_its_eds_differ(
    device: Hosted, pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    watched, bus = device
    eds = pytester.path / "drive.eds"
    eds.write_text(
        re.sub(
            "0x5d0c0f0e|1561071374", "7", eds_of(build_node(None, NODE_ID)), flags=re.IGNORECASE
        ),
        encoding="utf-8",
    )
    watched.node.objects.remove(0x2003)
    assert init(bus, "--node-id", "5", "--eds", str(eds)) == 0
    printed = capsys.readouterr().out
    text = (pytester.path / "device.toml").read_text("utf-8")
    for said in (printed, text):
        assert "1018h:02 reads 5D0C0F0Eh, the EDS says 00000007h" in said
        assert "2003h:00 (Entry 2003h:00) is in the EDS, but could not be read: " in said


def test_an_eds_alone(pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]) -> None:
    eds = pytester.path / "drive.eds"
    eds.write_text(eds_of(build_node(None, NODE_ID)), encoding="utf-8")
    assert init((), "--eds", "drive.eds") == 0
    assert capsys.readouterr().out.splitlines()[-1] == (
        "next: pytest --sdo-device=device.toml --node-id=N"
    )
    path = pytester.path / "device.toml"
    assert read_description(path)[table.NODE_ID] is None
    with_all_proposals(path)
    assert read_description(path)[table.NODE_ID] == [NODE_ID]
    assert len(read_description(path)[table.WRITABLE]) > 10


def test_the_standard_output_has_the_file_alone(
    device: Hosted, pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    _, bus = device
    assert init(bus, "--node-id", "5", "-o", "-") == 0
    printed = capsys.readouterr()
    (pytester.path / "device.toml").write_text(printed.out, encoding="utf-8")
    assert read_description(pytester.path / "device.toml")[table.NODE_ID] == [NODE_ID]
    assert "conformance: proposed as writable: " in printed.err


def test_a_file_is_not_overwritten(
    device: Hosted, pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    watched, bus = device
    path = pytester.path / "device.toml"
    path.write_text("node-id = 7\n", encoding="utf-8")
    assert init(bus, "--node-id", "5") == 2
    assert "device.toml exists: overwrite it with --force" in capsys.readouterr().err
    assert path.read_text("utf-8") == "node-id = 7\n"
    assert watched.frames == []
    assert init(bus, "--node-id", "5", "--force") == 0
    assert read_description(path)[table.NODE_ID] == [NODE_ID]


def test_a_silent_device(
    device: Hosted, pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    _, bus = device
    assert init(bus, "--node-id", "9", "--response-timeout", "0.05") == 10
    said = capsys.readouterr().err
    assert said.startswith("conformance: Node 9 does not answer.\n")
    assert "check: " in said
    assert not (pytester.path / "device.toml").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((), "say what to read: a device with --node-id=N, an EDS with --eds=FILE, or both"),
        (("--eds", "none.eds"), "none.eds: the file cannot be read: No such file or directory."),
    ],
)
def test_wrong_use(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], sentence: str
) -> None:
    assert init((), *arguments) == 2
    assert capsys.readouterr().err == f"conformance: {sentence}\n"


def test_a_file_that_cannot_be_written_is_noticed_before_the_device_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bus = ("--can-interface", "no-such-interface", "--node-id", "5")
    missing = tmp_path / "missing" / "drive.toml"
    assert main(["init", *bus, "-o", str(missing)]) == WRONG_USE
    assert f"there is no folder {missing.parent}" in capsys.readouterr().err
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert main(["init", *bus, "-o", str(tmp_path / "drive.toml")]) == WRONG_USE
    assert "drive.toml cannot be written: name another file" in capsys.readouterr().err
