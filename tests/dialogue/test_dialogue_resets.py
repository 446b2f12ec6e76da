"""What cases have left in strings and domains is not written for a reset, and not forgotten."""

from collections.abc import Iterable

import pytest
from storage_bench import Watched, configured
from support.run_bench import DOMAIN, NODE_ID, RULE, TEXT, Recording, discovered

from conformance.device.effort import LONG_VALUE
from conformance.dialogue.storage import write_signature
from conformance.dialogue.value_access import ValueAccess
from conformance.faults.registry import assemble
from conformance.reference.built_in_device import reference_entries
from conformance.reference.dictionary import reference_device
from conformance.reference.node import Node
from conformance.reference.server import BlockDownload, Server
from conformance.run.case_run import CaseRun, begin_case
from conformance.run.session import DeviceSession
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    DownloadInitiate,
    DownloadSegment,
    Request,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.objects import Entry
from conformance.sdo.storage_commands import SAVE_ALL

LONG = bytes(n % 250 for n in range(LONG_VALUE + 500))
LEFT = b"left"
COMMANDS = (NmtCommand.RESET_COMMUNICATION, NmtCommand.RESET_NODE)


class Forgetless(Node):
    """Holds after a reset what it held before."""

    def restore(self, *, communication_only: bool) -> None:
        """Restore nothing."""


def begin(session: DeviceSession) -> CaseRun:
    """Begin a case of the suite's own, which may leave values."""
    return begin_case(session, "a.case", "a service", RULE, own=True)


def leave(session: DeviceSession) -> None:
    """Let a case leave a string and a domain changed."""
    run = begin(session)
    for known in (TEXT, DOMAIN):
        run.sdo.download(known, LEFT)
    run.conclude(None)


def reset(session: DeviceSession, command: NmtCommand) -> None:
    """Let a case reset the device."""
    run = begin(session)
    run.tools.network.reset(command)
    run.conclude(None)


def held(watched: Watched) -> tuple[bytes, bytes]:
    """Return what the string and the domain hold."""
    objects = watched.node.objects
    return objects.find(TEXT.mux).value, objects.find(DOMAIN.mux).value


def asked(watched: Watched) -> list[Request]:
    """Return the requests that came since this was asked last."""
    requests = [decode_request(data) for data in watched.requests]
    watched.requests.clear()
    return requests


def writes(requests: Iterable[Request]) -> list[Request]:
    """Return what begins to write, or goes on with it."""
    kinds = (DownloadInitiate, DownloadSegment, BlockDownloadInitiate)
    return [request for request in requests if isinstance(request, kinds)]


def target(request: Request) -> Multiplexer | None:
    """Return the object that a request is for, if it names one."""
    return getattr(request, "mux", None)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("name", ["parameters-stored", "configured-and-not-stored"])
def test_what_was_left_is_not_written_for_a_reset(name: str, command: NmtCommand) -> None:
    """Whether or not the device brings it back, and whatever it brings back."""
    with configured(name) as (bench, watched):
        reset(session := bench.session(), command)  # numbers are put back behind the first
        before = held(watched)
        leave(session)
        asked(watched)
        reset(session, command)
        targets = {target(request) for request in writes(asked(watched))}
        assert targets.isdisjoint((TEXT.mux, DOMAIN.mux))
        if held(watched) != before:
            assert session.restorer.unrestored.keys() & {TEXT.mux, DOMAIN.mux}, "in the journal"
        session.restore_pending()
        assert held(watched) == before
        assert session.restorer.unrestored == {}


def very_long(kind: type[Node] = Node) -> Node:
    """Return a node that has stored a very long domain, and its parameters."""
    node = assemble(kind, Server, NODE_ID, reference_device(NODE_ID), None)
    node.objects.find(DOMAIN.mux).value = LONG
    node.save()
    return node


def segments(watched: Watched) -> int:
    """Return how many segments were asked for since anything was."""
    return sum(isinstance(request, UploadSegment) for request in asked(watched))


def test_what_is_very_long_is_read_once_behind_all_resets() -> None:
    with configured(node=very_long()) as (bench, watched):
        session = bench.session()
        bench.device.learned.reads_alike = False
        asked(watched)
        for command in COMMANDS:
            reset(session, command)
        assert segments(watched) < len(LONG) / 7
        assert session.restorer.unrestored.keys() == {DOMAIN.mux}, "nobody has looked"
        assert bench.device.contents.value(DOMAIN.mux) is None
        session.restore_pending()
        assert segments(watched) >= len(LONG) / 7
        assert session.restorer.unrestored == {}


def test_what_is_very_long_and_lost_in_a_reset_is_put_back() -> None:
    """At the end, or before a case needs it."""
    node = very_long()
    node.objects.find(DOMAIN.mux).value = in_use = LONG[::-1]
    with configured(node=node) as (bench, watched):
        session = bench.session()
        reset(session, NmtCommand.RESET_NODE)
        assert held(watched)[1] == LONG
        run = begin(session)
        ValueAccess(run.sdo).write_own(DOMAIN.mux)
        assert held(watched)[1] == in_use
        run.conclude(None)
        reset(session, NmtCommand.RESET_NODE)
        assert held(watched)[1] == LONG
        session.restore_pending()
        assert held(watched)[1] == in_use
        assert session.restorer.unrestored == {}


@pytest.mark.parametrize("kind", [Node, Forgetless])
def test_what_was_left_is_not_stored(kind: type[Node]) -> None:
    """Nor is what was in use and not stored: the device holds what it has stored, or ever had."""
    with configured(node=very_long(kind)) as (bench, watched):
        session = bench.session()
        before = held(watched)
        leave(session)
        for _ in range(2):
            run = begin(session)
            run.tools.network.reset_to_stored()
            assert held(watched) == before
            asked(watched)
            write_signature(run.sdo, SAVE_ALL)
            assert len(writes(asked(watched))) == 1, "the signature alone"
            run.conclude(None)
        assert LONG in [value for _, _, value in watched.node.power_on]
        leave(session)
        run = begin(session)
        write_signature(run.sdo, SAVE_ALL)
        assert held(watched) == before
        run.conclude(None)


class _WrongInBlocks(Recording):
    """Confirms block downloads, and stores nothing but 00h."""

    def store(self, entry: Entry, data: bytes) -> None:
        in_blocks = isinstance(self.transfer, BlockDownload)
        super().store(entry, bytes(len(data)) if in_blocks else data)


@pytest.mark.parametrize("kind", [Recording, _WrongInBlocks])
def test_a_long_value_is_written_in_blocks_before_it_is_stored(kind: type[Recording]) -> None:
    """Where a case has seen blocks to serve; what reads otherwise then is written in segments."""
    entries = reference_entries(NODE_ID)
    entries[DOMAIN.mux].value = LONG
    server = kind(entries)
    with discovered(server) as bench:
        session = bench.session()
        bench.device.learned.stores_in_blocks = True
        wrong = kind is _WrongInBlocks
        in_blocks, in_segments = BlockDownloadInitiate, DownloadInitiate
        for ways in [{in_blocks, in_segments}, {in_segments}] if wrong else [{in_blocks}] * 2:
            leave(session)
            run = begin(session)
            server.requests.clear()
            ValueAccess(run.sdo).write_all_own()
            assert server.entries[DOMAIN.mux].value == LONG
            requests = map(decode_request, server.requests)
            assert {type(one) for one in writes(requests) if target(one) == DOMAIN.mux} == ways
            run.conclude(None)
