"""Runs of the whole suite on a device that keeps a record of its own of what is written to it.

What the suite believes to have done is not asked.
"""

from collections.abc import Sequence

import pytest
from support.run_bench import NODE_ID, Recording
from support.selected_files import other_files
from support.spared_tests import spare_tests

from conformance.bus.opening import BusSettings, open_bus
from conformance.device.device import LAST_DATA_TYPE
from conformance.device.safety import written_by
from conformance.faults.catalogue import all_deviations
from conformance.reference.built_in_device import reference_entries
from conformance.reference.host import HostedNode, NodeHost
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.run.bench import private_channel
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry

NAMED = ("2001=unsigned8", "2004=unsigned32", "2010=visible_string")
WRITABLE = {Multiplexer(0x2001), Multiplexer(0x2004), Multiplexer(0x2010)}
# The number to which writes of a careless device would go, and what looks like a missing object.
ALSO_WRITABLE = {
    Multiplexer(0x1017): Entry(b"\0\0", DataType.UNSIGNED16),
    Multiplexer(0x1010, 1): Entry(bytes(4), DataType.UNSIGNED32),
    Multiplexer(0x0F00): Entry(b"\1\2\3\4", DataType.UNSIGNED32, Access.WO),
    Multiplexer(0x1018, 0xFE): Entry(b"\1\2\3\4", DataType.UNSIGNED32, Access.WO),
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
    node: HostedNode,
    *arguments: str,
    named: Sequence[str] = NAMED,
) -> pytest.RunResult:
    """Run the suite on the device, with leave to write what is named; it may be interrupted."""
    spare_tests()
    channel = private_channel()
    with NodeHost(open_bus(BusSettings("virtual", channel)), node):
        result = pytester.runpytest_inprocess(
            *("-p", "no:cacheprovider", "-p", "no:hypothesispytest", "-q"),
            f"--sdo-report-dir={pytester.path / 'reports'}",
            f"--node-id={NODE_ID}",
            *("--can-interface=virtual", f"--can-channel={channel}"),
            *(f"--sdo-object={name}" for name in named),
            *arguments,
            *other_files(arguments),
            no_reraise_ctrlc=True,
        )
    assert server.requests, "the run has reached the device"
    return result


def asked_to_write(server: Recording) -> set[Multiplexer]:
    """Return the entries for which a download would have begun, had the device been idle.

    Whatever the length of a frame, and whether or not it was a segment when it was sent. Not those
    that the device had refused to read before, because it lacks them.
    """
    asked: set[Multiplexer] = set()
    lacking: set[Multiplexer] = set()
    for frame in server.requests:
        request = decode_request(frame.ljust(8, b"\0"))
        target = written_by(request)
        if isinstance(request, UploadInitiate) and request.mux not in server.entries:
            lacking.add(request.mux)
        elif target is not None and target not in lacking and target.index > LAST_DATA_TYPE:
            asked.add(target)
    return asked
