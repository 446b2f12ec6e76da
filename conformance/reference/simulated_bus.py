"""A bus without threads, on which time passes as fast as it is waited for, or as it does."""

import time
from collections import deque
from collections.abc import Iterable
from typing import Protocol

import can

from conformance.bus.alarm import Alarm
from conformance.bus.messages import to_frame, to_message
from conformance.reference.host import HostedNode
from conformance.sdo.can_frame import CanFrame


class Clock(Protocol):
    """What time it is on a simulated bus, in seconds, and how it passes."""

    def now(self) -> float:
        """Return the time."""

    def wait_until(self, due: float) -> None:
        """Return when it is ``due``; at once if that is past."""


class SimulatedClock:
    """A wait takes no time: the clock jumps to its end."""

    def __init__(self) -> None:
        """Start at 0."""
        self._now = 0.0

    def now(self) -> float:
        """Return the time up to which was waited."""
        return self._now

    def wait_until(self, due: float) -> None:
        """Let it be that time."""
        self._now = max(self._now, due)


class RealClock:
    """Time passes as it does."""

    def __init__(self) -> None:
        """Look at the clock of the machine."""
        self.now = time.monotonic
        self.wait_until = Alarm().wait_until


class SimulatedBus(can.BusABC):
    """A bus with nodes on it, for running all cases against hundreds of servers.

    What a node sends is on its way when ``send`` returns, and there after the ``delay`` in seconds
    that the nodes take for an answer.
    """

    loses_nothing = True
    filters_nothing = True

    def __init__(
        self, nodes: Iterable[HostedNode], delay: float = 0.0, clock: Clock | None = None
    ) -> None:
        """Start the nodes; the clock is a simulated one if none is given."""
        super().__init__(channel="simulated")
        self._nodes = list(nodes)
        self._delay = delay
        self._clock = clock or SimulatedClock()
        self.now = self._clock.now  # by this the suite measures
        self._incoming: deque[tuple[float, can.Message]] = deque()
        now = self._clock.now()
        for node in self._nodes:
            self._take(node.advance(now), now)
            self._take(node.start(), now)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Hand a frame to every node and keep what they answer."""
        del timeout
        frame = to_frame(msg)
        now = self._clock.now()
        for node in self._nodes:
            self._take(node.advance(now), now)
            self._take(node.receive(frame), now + self._delay)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return what was sent first, or None, whatever filters were set: they only save time."""
        now = self._clock.now()
        end = now + (timeout or 0.0)
        while not self._incoming or self._incoming[0][0] > now:
            due = self._next_due()
            if due is None or due > end:
                self._clock.wait_until(end)
                return None
            self._clock.wait_until(due)
            now = max(due, self._clock.now())
            for node in self._nodes:
                self._take(node.advance(now), now)
        return self._incoming.popleft()[1]

    def _take(self, frames: Iterable[CanFrame], due: float) -> None:
        self._incoming.extend((due, to_message(frame)) for frame in frames)

    def _next_due(self) -> float | None:
        """Return when a frame arrives next, or a node has something to do."""
        times = [node.wake_at for node in self._nodes if node.wake_at is not None]
        if self._incoming:
            times.append(self._incoming[0][0])
        return min(times, default=None)
