"""Three EDS files as vendors write them: devices made of them pass, and nothing stays written."""

import re
from pathlib import Path

import pytest
from plugin_runs import NODE_ID, hosted, parsed, run, the_report

from conformance.__main__ import main
from conformance.bus.opening import BusSettings, open_bus
from conformance.device.known_objects import parse_object
from conformance.device.protected_objects import PERMISSIONS
from conformance.eds.reading import read_eds
from conformance.faults.catalogue import build_node
from conformance.reference.described import described_device
from conformance.reference.host import NodeHost
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, ObjectDictionary
from conformance.sdo.storage_commands import COMMANDS

pytest_plugins = ["pytester"]

FILES = Path(__file__).parents[1] / "eds" / "files"
# What shows on the reference server as well, and takes long.
CHOSEN = (
    "not test_matrix and not test_random and not sequence and not vanished and not size[ "
    "and not beyond"
)
DESCRIPTION = """\
node-id = 5
eds = "{eds}"
[objects]
writable = "all-rw"
[permissions]
read-only-probes = true
"""


def test_what_is_to_be_added_is_true_of_the_device(pytester: pytest.Pytester) -> None:
    """A run names what its cases lack, with the type of the EDS; with all of that it lacks less."""
    path = Path(__file__).parents[1] / "fleet" / "servers" / "device.eds"
    listing = read_eds(path, NODE_ID)
    chosen = ("-k", "download. or independence. or upload.", "-rs")
    with hosted(build_node(None, NODE_ID, listing)) as bus:
        device = (f"--node-id={NODE_ID}", *bus, f"--sdo-eds={path}", *chosen)
        lacking = run(pytester, *device)
        added = sorted(set(re.findall(r"add (--sdo-object=\S+) if", lacking.stdout.str())))
        result = run(pytester, *device, "--sdo-allow=read-only-probes", *added)
    assert len(added) >= 5
    for option in added:
        known = parse_object(option.removeprefix("--sdo-object="))
        listed = listing.find(known.mux)
        assert listed is not None
        assert (known.data_type, known.access) == (listed.data_type, listed.access)
    assert result.ret == pytest.ExitCode.OK
    assert "add --sdo-object" not in result.stdout.str()
    assert result.parseoutcomes()["passed"] > 2 * lacking.parseoutcomes()["passed"]


class Audited(Server):
    """Keeps which entries were written, and what they held in the beginning."""

    def __init__(self, objects: ObjectDictionary) -> None:
        super().__init__(objects)
        self.before = [(entry, entry.value) for entry in objects]
        self.written: list[Entry] = []

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data)
        self.written.append(entry)


@pytest.mark.parametrize(
    ("name", "passed"), [("io_module.eds", 450), ("drive.eds", 600), ("encoder.dcf", 200)]
)
def test_a_device_made_of_an_eds_passes(pytester: pytest.Pytester, name: str, passed: int) -> None:
    listing = read_eds(FILES / name, NODE_ID)
    server = Audited(described_device(listing, NODE_ID))
    (pytester.path / "device.toml").write_text(DESCRIPTION.format(eds=FILES / name), "utf-8")
    with hosted(Node(NODE_ID, server)) as bus:
        result = run(pytester, "--sdo-device=device.toml", *bus, "-k", CHOSEN)
    assert result.ret == pytest.ExitCode.OK, result.stdout.str()
    outcomes = result.parseoutcomes()
    assert outcomes["passed"] > passed
    assert server.written
    allowed = [
        server.objects.find(known.mux)
        for known in listing.entries
        if known.mux.index >= 0x2000 and known.access.writable and not known.refuses_download
    ]
    assert all(any(entry is one for one in allowed) for entry in server.written)
    # Some entries are not the listed ones but the node's own.
    there = {id(entry) for entry in server.objects}
    kept = [(entry, value) for entry, value in server.before if id(entry) in there]
    assert all(entry.value == value for entry, value in kept)
    assert len(kept) > 5


KINDS = (
    "access-unknown",
    "fixed-mapping-5-of-8",
    "heartbeat-default-const",
    "mpdo-FE",
    "stored-eds",
)


@pytest.mark.parametrize("name", ["unusual.eds", *(f"faulty/{kind}.eds" for kind in KINDS)])
def test_a_server_made_of_any_file_passes_a_quick_run(pytester: pytest.Pytester, name: str) -> None:
    """It follows CiA 301 for 1000h to 1FFFh, though the first file contradicts it eight times."""
    allowed = "".join(f"{permission} = true\n" for permission in sorted(PERMISSIONS))
    description = DESCRIPTION.format(eds=FILES / name)
    description = description[: description.index("read-only-probes")] + allowed
    (pytester.path / "device.toml").write_text(description, "utf-8")
    with hosted(build_node(None, NODE_ID, read_eds(FILES / name, NODE_ID))) as bus:
        result = run(pytester, "--sdo-device=device.toml", *bus, "--sdo-quick")
    assert result.ret == pytest.ExitCode.OK, result.stdout.str()


def test_the_reports_have_a_part_on_the_description(pytester: pytest.Pytester) -> None:
    path = FILES / "faulty" / "access-unknown.eds"
    with hosted(build_node(None, NODE_ID, read_eds(path, NODE_ID))) as bus:
        device = (f"--node-id={NODE_ID}", f"--sdo-eds={path}")
        result = run(pytester, *device, *bus, "-k", "od.read or od.length")
    assert result.ret == pytest.ExitCode.OK
    folder = the_report(pytester)
    (suite,) = (
        suite
        for suite in parsed(folder / "junit.xml")
        if suite.get("name") == "description access-unknown.eds"
    )
    assert (suite.get("tests"), suite.get("failures")) == ("3", "0")
    names = [case.get("name") for case in suite.iter("testcase")]
    assert names == ["eds.error-control", "eds.bit-rate", "eds.access"]
    page = " ".join((folder / "report.html").read_text(encoding="utf-8").split())
    assert "lists 3 objects with 4 entries; 4 of them had a case that passed or failed." in page
    assert "line 69: [6300] AccessType=UNKNOWN is unknown. No case is about the entry." in page


def test_a_server_made_of_a_file_has_what_is_listed_and_nothing_else() -> None:
    listing = read_eds(FILES / "unusual.eds", NODE_ID)
    objects = build_node(None, NODE_ID, listing).objects
    assert {mux for mux, _ in objects.items()} == {known.mux for known in listing.entries}
    for known in listing.entries:
        entry = objects.find(known.mux)
        assert entry.access is known.access
        assert entry.data_type is known.data_type
        assert known.stated in (None, entry.value) or known.mux.index in (0x1003, *COMMANDS)


def test_a_device_is_held_against_its_file(pytester: pytest.Pytester) -> None:
    """``conformance eds --node-id`` runs the cases on the object dictionary alone."""
    path = FILES / "right.eds"
    node = build_node(None, NODE_ID, read_eds(path, NODE_ID))
    options = ["udp_multicast", "239.74.163.2", "port=43114"]
    bus = [
        f"--can-{name}={value}"
        for name, value in zip(("interface", "channel", "option"), options, strict=True)
    ]
    settings = BusSettings(options[0], options[1], options=(("port", "43114"),))
    with NodeHost(open_bus(settings), node):
        assert main(["eds", str(path), f"--node-id={NODE_ID}", *bus]) == 0
        assert main(["eds", str(FILES / "drive.eds"), f"--node-id={NODE_ID}", *bus]) == 1


@pytest.mark.parametrize(
    ("fault", "case"),
    [
        ("limits-not-checked", "od.above-limit[2000h:02]"),
        ("count-of-entries-instead-of-highest", "od.highest-sub-index[2000h]"),
        ("signed-limits-checked-unsigned", "od.low-limit[6060h:00]"),
        ("short-numbers-read-as-4-bytes", "od.length[6040h:00]"),
    ],
)
def test_faults_show_on_other_devices_too(pytester: pytest.Pytester, fault: str, case: str) -> None:
    eds = FILES / "drive.eds"
    (pytester.path / "device.toml").write_text(DESCRIPTION.format(eds=eds), "utf-8")
    node = build_node(fault, NODE_ID, read_eds(eds, NODE_ID))
    if fault == "count-of-entries-instead-of-highest":
        entry = node.server.objects.find(Multiplexer(0x2000))
        entry.value = b"\x05"  # of sub-indices 1, 2, 3, 5 and 7
    with hosted(node) as bus:
        result = run(pytester, "--sdo-device=device.toml", *bus, "-k", case)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines([f"{case.replace('[', '[[]')}: FAIL *"])
