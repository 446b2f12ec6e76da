"""Two devices with one node-ID, as far as they can be told from one that answers twice."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from support.run_bench import NODE_ID, Workbench

from conformance.beginning.discovery import discover
from conformance.bus.channel import Channel
from conformance.bus.errors import TwoDevices
from conformance.bus.link import Link
from conformance.device.device import Device
from conformance.dialogue.causes import Causes
from conformance.faults.catalogue import build_node
from conformance.faults.faulty.whole_run import FirstAnswersTwice
from conformance.reference.built_in_device import reference_entries
from conformance.reference.host import HostedNode
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.reference.simulated_bus import SimulatedBus
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import ObjectDictionary
from conformance.sdo.rules import ANSWERED, SPECIFIER, UNSOLICITED, Cause, Violation

SERIAL = Multiplexer(0x1018, 4)


class Slow(HostedNode):
    """Takes some seconds for an answer."""

    def __init__(self, node: Node, seconds: float) -> None:
        self.node = node
        self.seconds = seconds
        self.now = 0.0
        self.owed: list[tuple[float, CanFrame]] = []

    def start(self) -> list[CanFrame]:
        return self.node.start()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        self.owed += [(self.now + self.seconds, answer) for answer in self.node.receive(frame)]
        return []

    def advance(self, now: float) -> list[CanFrame]:
        self.now = now
        due = [answer for at, answer in self.owed if at <= now]
        self.owed = [(at, answer) for at, answer in self.owed if at > now]
        return due

    @property
    def wake_at(self) -> float | None:
        return self.owed[0][0] if self.owed else None


def other(serial: bytes = b"\1\2\3\4") -> Node:
    entries = reference_entries(NODE_ID)
    entries[SERIAL].value = serial
    return Node(NODE_ID, Server(ObjectDictionary(entries)))


@contextmanager
def on_one_bus(*nodes: HostedNode) -> Iterator[Workbench]:
    link = Link(SimulatedBus(nodes), "simulated")
    try:
        yield Workbench(Channel(link, NODE_ID, 0.5), Device(NODE_ID), "simulated")
    finally:
        link.close()


@pytest.mark.parametrize("slower", [0.001, 0.0025, 0.004])
def test_two_devices_that_differ(slower: float) -> None:
    nodes = Slow(other(), 0.001), Slow(other(b"\5\6\7\x08"), slower)
    told = r"node-ID 5\? .*1018h:04.*01020304 and .*05060708"
    with (
        on_one_bus(*nodes) as bench,
        pytest.raises(TwoDevices, match=told),
    ):
        discover(bench.channel, bench.device)


@pytest.mark.parametrize("alike", [True, False])
def test_two_that_are_alike_cannot_be_told_from_one_that_answers_twice(alike: bool) -> None:
    nodes = (other(), other()) if alike else (build_node("answers-twice", NODE_ID),)
    with on_one_bus(*nodes) as bench:
        causes = Causes()
        discover(bench.channel, bench.device, causes)
        assert bench.device.learned.answers_twice
        # Whatever else is met comes of that: it is told once.
        violation = Violation(SPECIFIER, expected="one", actual="another")
        cause = causes.of(violation, SPECIFIER, UploadInitiate(Multiplexer(0x1018)))
        assert cause == Cause(UNSOLICITED.id, "every answer comes twice")


@pytest.mark.parametrize("name", [None, "every-abort-answered", "answers-late"])
def test_one_device(name: str | None) -> None:
    with on_one_bus(build_node(name, NODE_ID)) as bench:
        discover(bench.channel, bench.device)
        assert not bench.device.learned.answers_twice


@pytest.mark.parametrize("name", [None, "every-abort-answered", "answers-twice", "answers-late"])
def test_one_that_is_not_behind(name: str | None) -> None:
    with on_one_bus(build_node(name, NODE_ID)) as bench:
        discover(bench.channel, bench.device)
        assert not bench.device.learned.is_behind


def test_one_that_is_one_request_behind() -> None:
    """Whatever else is met comes of that."""
    with on_one_bus(build_node("one-request-behind", NODE_ID)) as bench:
        causes = Causes()
        discover(bench.channel, bench.device, causes)
        assert bench.device.learned.is_behind
        violation = Violation(SPECIFIER, expected="one", actual="another")
        cause = causes.of(violation, SPECIFIER, UploadInitiate(Multiplexer(0x1018)))
        assert cause == Cause(ANSWERED.id, "answers are one request behind")


@pytest.mark.parametrize("times", [1, 2, 3])
def test_the_first_answers_come_twice(times: int) -> None:
    server = FirstAnswersTwice(ObjectDictionary(reference_entries(NODE_ID)))
    server.left = times
    with on_one_bus(Node(NODE_ID, server)) as bench:
        causes = Causes()
        discover(bench.channel, bench.device, causes)
    assert [cause for cause, _ in causes] == [
        Cause(UNSOLICITED.id, "the first answers of a run come twice")
    ]


class LosesTheFirst(Server):
    """Loses the first request, and answers it later all the same."""

    lost: bytes = b""

    def receive(self, frame: bytes) -> list[bytes]:
        if frame[0] == 0x40 and not self.lost:
            self.lost = frame
            return []
        answers = super().receive(frame)
        if frame == self.lost:
            self.lost = b"answered"
            return answers * 2
        return answers


def test_an_answer_to_an_earlier_read_is_no_second_one() -> None:
    server = LosesTheFirst(ObjectDictionary(reference_entries(NODE_ID)))
    with on_one_bus(Node(NODE_ID, server)) as bench:
        causes = Causes()
        discover(bench.channel, bench.device, causes)
    assert not [cause for cause, _ in causes]
