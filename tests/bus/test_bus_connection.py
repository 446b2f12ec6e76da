"""A bus behind a network: is it still reached?"""

import socket
import threading
from collections.abc import Iterator
from contextlib import closing

import pytest
from bus_fakes import READ, Bench

from conformance.bus.connection import Connection
from conformance.bus.errors import BusNotOpened, InterfaceLost
from conformance.bus.opening import BusSettings, connection_of, open_bus

PATIENCE = 0.05


@pytest.fixture
def daemon() -> Iterator[socket.socket]:
    """A daemon that listens; what it says is up to the test."""
    with closing(socket.create_server(("127.0.0.1", 0))) as listening:
        yield listening


def test_a_daemon_that_greets(daemon: socket.socket) -> None:
    def greet() -> None:
        accepted, _ = daemon.accept()
        with accepted:
            accepted.sendall(b"< hi >")

    thread = threading.Thread(target=greet)
    thread.start()
    Connection("127.0.0.1", daemon.getsockname()[1]).check()
    thread.join()


def test_a_daemon_that_is_frozen(daemon: socket.socket) -> None:
    """The machine takes the connection, and no program speaks."""
    port = daemon.getsockname()[1]
    with pytest.raises(InterfaceLost, match=f"127.0.0.1, port {port}, is not reached: timed out"):
        Connection("127.0.0.1", port, PATIENCE).check()


def test_a_daemon_that_is_gone(daemon: socket.socket) -> None:
    port = daemon.getsockname()[1]
    daemon.close()
    with pytest.raises(InterfaceLost, match=r"is not reached: .*refused"):
        Connection("127.0.0.1", port, PATIENCE).check()


def test_a_daemon_that_is_frozen_cannot_be_opened(
    daemon: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    """python-can would wait for it for ever."""
    monkeypatch.setattr("conformance.bus.connection.PATIENCE", PATIENCE)
    options = (("host", "127.0.0.1"), ("port", str(daemon.getsockname()[1])))
    with pytest.raises(BusNotOpened, match=r"socketcand can0, .* is not reached: timed out"):
        open_bus(BusSettings("socketcand", "can0", options=options))


@pytest.mark.parametrize(
    ("settings", "known"),
    [
        (BusSettings("socketcand", "can0", options=(("host", "bench7"), ("port", "29536"))), True),
        (BusSettings("socketcand", "can0", options=(("host", "bench7"),)), False),
        (BusSettings("socketcan", "can0"), False),
    ],
)
def test_what_can_be_looked_at(settings: BusSettings, known: bool) -> None:
    assert (connection_of(settings) is not None) is known


def test_it_is_looked_at_in_a_silence_only(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(monkeypatch)
    looks: list[float] = []
    bench.link.check = lambda: looks.append(bench.clock.now)
    bench.channel.send(READ)
    assert bench.channel.receive(0) is None
    assert looks == []
    assert bench.channel.receive() is None
    assert len(looks) == 1
    bench.link.close()
