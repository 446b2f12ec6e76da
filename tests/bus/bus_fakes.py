"""A python-can bus that plays what a test wrote down, and a clock that runs ahead."""

from collections import deque
from collections.abc import Callable

import can
import pytest

from conformance.bus.channel import Channel
from conformance.bus.link import Captured, Link

READ = bytes.fromhex("4000100000000000")
ANSWER = bytes.fromhex("4300100091010F00")


class FakeClock:
    """Stands in for the module ``time``; a wait moves it on at once."""

    def __init__(self) -> None:
        self.now = 1000.0

    def monotonic(self) -> float:
        return self.now

    def time(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


class FakeBus(can.BusABC):
    """Plays ``incoming``, and calls ``source`` when that is empty; keeps what is sent.

    An exception among them is raised. What python-can does in software, as filtering, is its own.
    """

    def __init__(self, clock: FakeClock) -> None:
        super().__init__(channel="fake")
        self.clock = clock
        self.sent: list[can.Message] = []
        self.send_errors: deque[Exception] = deque()
        self.incoming: deque[can.Message | Exception] = deque()
        self.source: Callable[[], can.Message | None] = lambda: None
        self.receipt_takes = 0.0

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        if self.send_errors:
            raise self.send_errors.popleft()
        self.sent.append(msg)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        self.clock.now += self.receipt_takes
        item = self.incoming.popleft() if self.incoming else self.source()
        if isinstance(item, Exception):
            raise item
        if item is None:
            assert timeout is not None
            self.clock.now += max(timeout, 1e-6)
        return item, False


class Bench:
    """A link and a channel to node 5 on a fake bus, and all that was captured."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, response_timeout: float = 0.5) -> None:
        self.clock = FakeClock()
        monkeypatch.setattr("conformance.bus.link.time", self.clock)
        monkeypatch.setattr("conformance.bus.patience.time", self.clock)
        monkeypatch.setattr("conformance.bus.arrivals.time", self.clock)
        monkeypatch.setattr("can.bus.time", self.clock.time)
        self.bus = FakeBus(self.clock)
        self.link = Link(self.bus, "fake0")
        self.channel = Channel(self.link, 5, response_timeout)
        self.captured: list[Captured] = []
        self.link.listen(self.captured.append)


def message(
    can_id: int, data: bytes = b"", *, extended: bool = False, remote: bool = False
) -> can.Message:
    return can.Message(
        arbitration_id=can_id,
        data=None if remote else data,
        dlc=8 if remote else len(data),
        is_extended_id=extended,
        is_remote_frame=remote,
    )


def error_frame(kind: int, data: bytes = bytes(8)) -> can.Message:
    """Build an error frame as SocketCAN passes it on (linux/can/error.h)."""
    return can.Message(arbitration_id=kind, data=data, is_error_frame=True)
