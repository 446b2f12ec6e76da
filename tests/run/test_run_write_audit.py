"""Nothing is written but what the user named, and every value is put back: in a whole run.

The device keeps a record of its own; what the suite believes to have done is not asked.
"""

from collections.abc import Sequence

import pytest
from run_bench import NODE_ID, Recording

from conformance.bus.host import NodeHost
from conformance.bus.opening import BusSettings, open_bus
from conformance.device.safety import IDENTITY, written_by
from conformance.faults.catalogue import all_deviations
from conformance.faults.device import reference_entries
from conformance.run.bench import private_channel
from conformance.running import ExitCode
from conformance.sdo.frames import decode_request
from conformance.sdo.layout import Multiplexer
from conformance.sdo.node import Node
from conformance.sdo.objects import Access, DataType, Entry
from conformance.sdo.server import Server

pytest_plugins = ["pytester"]

NAMED = ("2001=unsigned8", "2004=unsigned32", "2010=visible_string")
NAME = Multiplexer(0x1008)
TEXT = Multiplexer(0x2010)
WRITABLE = {Multiplexer(0x2001), Multiplexer(0x2004), Multiplexer(0x2010)}
# The number to which writes of a careless device would go, and what looks like a missing object.
ALSO_WRITABLE = {
    Multiplexer(0x1017): Entry(b"\0\0", DataType.UNSIGNED16),
    Multiplexer(0x1010, 1): Entry(bytes(4), DataType.UNSIGNED32),
    Multiplexer(0x0F00): Entry(b"\1\2\3\4", DataType.UNSIGNED32, Access.WO),
    Multiplexer(0x2004, 0xFE): Entry(b"\1\2\3\4", DataType.UNSIGNED32, Access.WO),
}


def server_like(name: str | None) -> Recording:
    """Return a recording server that is also the faulty or unusual one of that name."""
    deviations = {deviation.name: deviation.kind for deviation in all_deviations()}
    kind = deviations.get(name or "", Server)
    bases = (Recording, kind) if issubclass(kind, Server) else (Recording,)
    audited: type[Recording] = type("Audited", bases, {})
    return audited(reference_entries(NODE_ID) | ALSO_WRITABLE)


def node_like(name: str | None, server: Recording) -> Node:
    deviations = {deviation.name: deviation.kind for deviation in all_deviations()}
    kind = deviations.get(name or "", Node)
    return kind(NODE_ID, server) if issubclass(kind, Node) else Node(NODE_ID, server)


def run(
    pytester: pytest.Pytester,
    server: Recording,
    node: Node,
    *arguments: str,
    named: Sequence[str] = NAMED,
) -> int:
    """Run the suite on the device, with leave to write what is named."""
    channel = private_channel()
    with NodeHost(open_bus(BusSettings("virtual", channel)), node):
        result = pytester.runpytest_inprocess(
            *("-p", "no:cacheprovider", "-p", "no:hypothesispytest", "-q"),
            f"--report-dir={pytester.path / 'reports'}",
            f"--node-id={NODE_ID}",
            *("--can-interface=virtual", f"--can-channel={channel}"),
            *(f"--object={name}" for name in named),
            *arguments,
        )
    assert server.requests, "the run has reached the device"
    return int(result.ret)


def asked_to_write(server: Recording) -> set[Multiplexer]:
    """Return the entries of the device for which a download was begun, whatever its length."""
    requests = (decode_request(frame.ljust(8, b"\0")) for frame in server.requests)
    return {mux for mux in map(written_by, requests) if mux in server.entries}


# Of the matrix two states, where most of its frames can be taken for a download.
ONCE = "not test_matrix or matrix.idle or matrix.block-download-between"


def test_a_whole_run(pytester: pytest.Pytester) -> None:
    server = server_like(None)
    begin = server.values()
    assert run(pytester, server, node_like(None, server), "-k", ONCE) == pytest.ExitCode.OK
    assert {mux for mux, _ in server.writes} == WRITABLE
    probed = asked_to_write(server) - WRITABLE
    assert probed
    assert {mux.index for mux in probed} <= set(IDENTITY), "the identity is read-only"
    assert server.values() == begin


UNUSUAL = (
    "short-frames-served",
    "text-ends-in-zero",
    "strings-of-20-bytes",
)
# What these have to show does not need the matrix, nor transfers of 600 frames and more.
SHORT = "not test_matrix and not 409 and not 177 and not 88 and not 89 and not wraps"


@pytest.mark.parametrize("name", UNUSUAL)
def test_a_whole_run_on_an_unusual_device(pytester: pytest.Pytester, name: str) -> None:
    server = server_like(name)
    begin = server.values()
    assert run(pytester, server, node_like(name, server), "-k", SHORT) == pytest.ExitCode.OK
    assert {mux for mux, _ in server.writes} <= WRITABLE
    assert {mux.index for mux in asked_to_write(server) - WRITABLE} <= set(IDENTITY)
    if name == "text-ends-in-zero":
        server.entries[TEXT].value = server.entries[TEXT].value.rstrip(b"\0")
    assert server.values() == begin


CARELESS = {
    "short-request-padded": "frame.short",
    "short-frames-served": "frame.short",
    "answers-extended": "frame.extended",
    "read-only-written-expedited": "download.read-only",
    "read-only-written-segmented": "segmented-download.read-only",
    "abort-commits-download": "segmented-download.client-abort",
    "download-too-few-refused-and-stored": "segmented-download.too-few",
    "new-download-commits-old": "segmented-download.new",
}


@pytest.mark.parametrize(("name", "chosen"), CARELESS.items(), ids=CARELESS)
def test_a_device_that_writes_what_it_should_not(
    pytester: pytest.Pytester, name: str, chosen: str
) -> None:
    """Its values are put back all the same, and no other object is touched."""
    server = server_like(name)
    begin = server.values()
    status = run(pytester, server, node_like(name, server), "-k", chosen)
    assert status in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
    assert {mux.index for mux in asked_to_write(server) - WRITABLE} <= set(IDENTITY)
    assert server.values() == begin


SENSELESS = (
    "upload-multiplexer-missing",
    "abort-answered-when-idle",
    "upload-n-is-count",
    "upload-always-four-bytes",
)


@pytest.mark.parametrize("name", SENSELESS)
def test_a_device_that_makes_no_sense(pytester: pytest.Pytester, name: str) -> None:
    """Cases fail one after another; what they wrote is put back, as the type of the object is.

    A value that reads too long for its type is either cut or never written.
    """
    server = server_like(name)
    begin = server.values()
    chosen = ("--response-timeout=0.1", "-k", "abort. or test_expedited_download or frame.short")
    status = run(pytester, server, node_like(name, server), *chosen)
    assert status in (pytest.ExitCode.TESTS_FAILED, ExitCode.DEVICE_LOST)
    assert server.values() == begin


def test_without_leave_no_value_is_changed(pytester: pytest.Pytester) -> None:
    """What a device has to refuse is tried with the value that it has, in case it does not."""
    server = server_like(None)
    server.entries[NAME].access = Access.RW  # unusual, and not forbidden
    begin = server.values()
    status = run(pytester, server, node_like(None, server), "-k", ONCE, named=())
    assert status == pytest.ExitCode.TESTS_FAILED
    assert {mux.index for mux in asked_to_write(server)} <= set(IDENTITY)
    assert [(mux, value) for mux, value in server.writes if value != begin[mux]] == []


def test_without_leave_a_device_that_is_right_passes(pytester: pytest.Pytester) -> None:
    server = server_like(None)
    right = node_like(None, server)
    assert run(pytester, server, right, "-k", ONCE, named=()) == pytest.ExitCode.OK
    assert server.writes == []
