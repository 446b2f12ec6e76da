"""A socketcand server on the loopback, with a bus of its own: what one client sends, others get.

It speaks what python-can's client needs of the protocol: ``< open NAME >``, ``< rawmode >``,
``< send ID LENGTH BYTES >`` and ``< frame ID TIME DATA >``, all text on a TCP connection.
"""

import re
import socketserver
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from conformance.bus.opening import BusSettings

CHANNEL = "vcan7"
_OF_ANOTHER_NODE = b"< frame 701 1.000000 05 >"
_MESSAGE = re.compile(r"<\s*(.*?)\s*>")


def settings_of(bus: tuple[str, ...]) -> BusSettings:
    """Return the settings of the bus to which options lead: interface, channel, what else."""
    interface, channel, *rest = (option.partition("=")[2] for option in bus)
    pairs = (setting.partition("=") for setting in rest)
    return BusSettings(interface, channel, options=tuple((name, value) for name, _, value in pairs))


class _Client(socketserver.BaseRequestHandler):
    server: "_Bus"

    def handle(self) -> None:
        self.request.sendall(b"< hi >")
        received = ""
        while data := self._receive():
            received += data.decode("ascii")
            end = received.rfind(">") + 1
            for message in _MESSAGE.findall(received[:end]):
                self._take(message.split())
            received = received[end:]
        self.server.leave(self)

    def _receive(self) -> bytes:
        try:
            return bytes(self.request.recv(4096))
        except OSError:
            return b""

    def _take(self, words: list[str]) -> None:
        match words:
            case ["open", name]:
                self.request.sendall(b"< ok >" if name == CHANNEL else b"< error no such bus >")
            case ["rawmode"]:
                self.server.join(self)
            case ["send", can_id, length, *data]:
                assert int(length, 16) == len(data), "a remote frame cannot be sent"
                self.server.publish(self, can_id, bytes(int(byte, 16) for byte in data))
            case _:
                raise AssertionError(f"unknown: {words}")


class _Bus(socketserver.ThreadingTCPServer):
    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, crowded_openings: int) -> None:
        super().__init__(("127.0.0.1", 0), _Client)
        self._crowded_openings = crowded_openings
        self._lock = threading.Lock()
        self._clients: list[_Client] = []

    def join(self, client: _Client) -> None:
        with self._lock:
            crowded = self._crowded_openings > 0
            self._crowded_openings -= crowded
            client.request.sendall(b"< ok >" + _OF_ANOTHER_NODE * crowded)
            self._clients.append(client)

    def leave(self, client: _Client) -> None:
        with self._lock:
            if client in self._clients:
                self._clients.remove(client)

    def publish(self, sender: _Client, can_id: str, data: bytes) -> None:
        line = f"< frame {can_id} {time.time():.6f} {data.hex().upper()} >".encode("ascii")
        with self._lock:
            for client in self._clients:
                if client is not sender:
                    try:
                        client.request.sendall(line)
                    except OSError:
                        continue  # it is leaving


@contextmanager
def socketcand(*, crowded_openings: int = 0) -> Iterator[tuple[str, ...]]:
    """Serve a bus; yields the options that lead to it.

    Behind the answer to the first ``crowded_openings`` clients a frame of the bus comes at once.
    """
    with _Bus(crowded_openings) as bus:
        thread = threading.Thread(target=bus.serve_forever, kwargs={"poll_interval": 0.02})
        thread.start()
        try:
            yield (
                "--can-interface=socketcand",
                f"--can-channel={CHANNEL}",
                "--can-option=host=127.0.0.1",
                f"--can-option=port={bus.server_address[1]}",
                "--can-option=tcp_tune=true",
            )
        finally:
            bus.shutdown()
            thread.join()
