"""Link, channel and hosted server together on python-can's virtual bus, in this process."""

import errno
import threading
import time
from collections.abc import Iterator

import can
import pytest

from conformance.bus.channel import Channel
from conformance.bus.link import Captured, Direction, Link
from conformance.bus.opening import BusSettings, open_bus
from conformance.reference.host import NodeHost
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry, ObjectDictionary

READ = bytes.fromhex("4000100000000000")
ANSWER = bytes.fromhex("4300100091010F00")
ENTRY = Entry(bytes.fromhex("91010F00"), DataType.UNSIGNED32)


def bus(name: str) -> can.BusABC:
    return open_bus(BusSettings("virtual", name))


@pytest.fixture
def name(request: pytest.FixtureRequest) -> str:
    """Return a channel of the test's own."""
    return f"test {request.node.name}"


@pytest.fixture
def link(name: str) -> Iterator[Link]:
    opened = Link(bus(name), name)
    opened.watch([5])
    yield opened
    opened.close()


@pytest.fixture
def host(name: str) -> Iterator[Node]:
    node = Node(5, Server(ObjectDictionary({Multiplexer(0x1000): ENTRY})))
    with NodeHost(bus(name), node):
        yield node


@pytest.fixture
def channel(link: Link, host: Node) -> Channel:
    """Return a channel to the hosted node, its boot-up message received or still to come."""
    return Channel(link, host.node_id, response_timeout=5.0)


def test_request_and_response(channel: Channel) -> None:
    captured: list[Captured] = []
    channel.link.listen(captured.append)
    channel.send(READ)
    assert channel.receive() == CanFrame(0x585, ANSWER)
    assert [
        (one.direction, one.frame) for one in captured if one.frame.can_id in (0x585, 0x605)
    ] == [
        (Direction.SENT, CanFrame(0x605, READ)),
        (Direction.RECEIVED, CanFrame(0x585, ANSWER)),
    ]


def test_hosted_node_ignores_what_is_not_addressed_to_it(channel: Channel) -> None:
    channel.send_frame(CanFrame(0x606, READ))
    channel.send_frame(CanFrame(0x605, READ, extended=True))
    channel.send_frame(CanFrame(0x605, remote=True, length=8))
    channel.send(READ)
    assert channel.receive() == CanFrame(0x585, ANSWER)
    assert channel.receive(0) is None


def test_hosted_node_boots_up(channel: Channel) -> None:
    """The boot-up message comes before any answer."""
    channel.send(READ)
    assert channel.receive() == CanFrame(0x585, ANSWER)
    assert channel.boot_ups == 1


def test_the_host_wakes_its_node(name: str, link: Link) -> None:
    """A heartbeat and a time-out come though no frame is sent any more."""
    objects = ObjectDictionary({Multiplexer(0x1008): Entry(b"long enough")})
    node = Node(5, Server(objects), server_timeout=0.15)
    with NodeHost(bus(name), node):
        channel = Channel(link, 5, response_timeout=5.0)
        begin = time.monotonic()
        channel.send(bytes.fromhex("2B17100005000000"))
        assert channel.receive() == CanFrame(0x585, bytes.fromhex("6017100000000000"))
        channel.send(bytes.fromhex("4008100000000000"))
        assert channel.receive() is not None
        assert channel.receive() == CanFrame(0x585, bytes.fromhex("8008100000000405"))
        assert time.monotonic() - begin >= 0.15
        assert channel.receive_error_control() == CanFrame(0x705, b"\x00")
        assert channel.receive_error_control() == CanFrame(0x705, b"\x7f")


def test_the_host_closes_its_bus(name: str) -> None:
    hosted = bus(name)
    node = Node(5, Server(ObjectDictionary({})))
    with NodeHost(hosted, node):
        pass
    with pytest.raises(can.CanOperationError, match="closed"):
        hosted.recv(0)


def test_the_host_waits_for_room_in_the_transmit_buffer(
    name: str, link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    hosted = bus(name)
    send = hosted.send
    refused: list[can.Message] = []

    def send_later(msg: can.Message, timeout: float | None = None) -> None:
        if len(refused) < 5:
            refused.append(msg)
            raise can.CanOperationError("Transmit buffer full", errno.ENOBUFS)
        send(msg, timeout)

    monkeypatch.setattr(hosted, "send", send_later)
    with NodeHost(hosted, Node(5, Server(ObjectDictionary({})))):
        assert link.receive(5.0) == CanFrame(0x705, b"\x00")
    assert len(refused) == 5


def test_a_host_that_waits_for_room_can_be_stopped(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    hosted = bus(name)
    tried = threading.Event()

    def never(msg: can.Message, timeout: float | None = None) -> None:
        tried.set()
        raise OSError(errno.ENOBUFS, "No buffer space available")

    monkeypatch.setattr(hosted, "send", never)
    with NodeHost(hosted, Node(5, Server(ObjectDictionary({})))):
        assert tried.wait(5.0)


def test_a_frame_from_another_node(name: str, link: Link) -> None:
    with bus(name) as other:
        other.send(can.Message(arbitration_id=0x185, data=b"\x01", is_extended_id=False))
        assert link.receive(5.0) == CanFrame(0x185, b"\x01")
