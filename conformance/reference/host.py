"""A node of the reference server on a python-can bus, answering in a thread of its own."""

import math
import threading
import time
from types import TracebackType
from typing import Protocol, Self

import can

from conformance.bus.alarm import Alarm
from conformance.bus.arrivals import arrivals, shortest_look
from conformance.bus.errors import buffer_is_full
from conformance.bus.messages import to_frame, to_message
from conformance.sdo.can_frame import CanFrame

# How long a stop may go unseen: nothing but a frame interrupts python-can's waiting.
POLL = 0.05
# A frame that waited longer than this, in seconds, was delayed by the machine.
LONG = 0.005
# Seconds until it is tried again to send where the transmit buffer was full.
RETRY_PAUSE = 0.002


class HostedNode(Protocol):
    """What can be hosted: a node without I/O, and without a clock of its own."""

    def start(self) -> list[CanFrame]:
        """Return the frames that the node sends when it starts."""
        return []

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Take a frame from the bus; return the answers."""
        ...

    def advance(self, now: float) -> list[CanFrame]:
        """Take the time in seconds, before every frame and when it is due; return what is due."""
        return []

    @property
    def wake_at(self) -> float | None:
        """The time at which ``advance`` is due though no frame came; None for never."""
        return None


class NodeClock:
    """The time of a node, in seconds: it stands still while frames wait to be taken, or to go out.

    Where a busy machine lets them wait, the client has not been silent for so long, nor the node.
    """

    def __init__(self, bus: can.BusABC) -> None:
        """Take the bus that tells when frames arrived."""
        self._arrival = arrivals(bus)
        self._held = 0.0
        self._last = -math.inf

    def at(self, message: can.Message | None, now: float) -> float:
        """Return the node's time when it takes a frame, or none, at a time of the machine."""
        taken = now - self._held
        if message is not None:
            arrived = max(self._last, self._arrival(message) - self._held)
            if taken - arrived > LONG:
                self._held, taken = now - arrived, arrived
        self._last = taken
        return taken

    def hold(self, now: float) -> None:
        """Take that the node was answering up to now: the client is silent from now on."""
        answering = now - self._held - self._last
        if answering > LONG:
            self._held += answering


class NodeHost:
    """Runs a node until it is stopped; a context manager."""

    def __init__(self, bus: can.BusABC, node: HostedNode, delay: float = 0.0) -> None:
        """Take an open bus, which the host closes when it stops.

        ``delay`` is the time in seconds from a request to its answer, of one frame or more.
        """
        self._bus = bus
        self._node = node
        self._delay = delay
        self._shortest_look = shortest_look(bus)
        self._clock = NodeClock(bus)
        self._stopping = threading.Event()
        self._alarm = Alarm(self._stopping.wait)
        self._thread = threading.Thread(target=self.run, name="node", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.stop()
        self._thread.join()

    def stop(self) -> None:
        """Ask the node to end; safe from a signal handler."""
        self._stopping.set()

    def run(self) -> None:
        """Serve until stopped, then close the bus."""
        try:
            self._send(self._node.advance(self._clock.at(None, time.monotonic())))
            self._send(self._node.start())
            while not self._stopping.is_set():
                message, now = self._next()
                if due := self._node.advance(self._clock.at(message, now)):
                    self._send(due)
                if message is not None and not message.is_error_frame:
                    answers = self._node.receive(to_frame(message))
                    if answers:
                        self._answer(answers, now + self._delay)
                        self._clock.hold(time.monotonic())
        finally:
            self._bus.shutdown()

    def _next(self) -> tuple[can.Message | None, float]:
        """Wait for a frame; return it, or None, and the time up to which there was no other."""
        message = self._bus.recv(self._patience())
        now = time.monotonic()
        if message is None:
            message = self._bus.recv(self._shortest_look)  # what came before ``now``
        return message, now

    def _patience(self) -> float:
        """Return for how many seconds to wait for a frame."""
        due = self._node.wake_at
        if due is None:
            return POLL
        return min(POLL, max(0.0, due - self._clock.at(None, time.monotonic())))

    def _answer(self, frames: list[CanFrame], due: float) -> None:
        if self._delay:
            self._alarm.wait_until(due)
        self._send(frames)

    def _send(self, frames: list[CanFrame]) -> None:
        for frame in frames:
            message = to_message(frame)
            while not self._has_sent(message):
                # The kernel has no event for room in the queue of the network device.
                if self._stopping.wait(RETRY_PAUSE):
                    return

    def _has_sent(self, message: can.Message) -> bool:
        """Send a frame; say whether there was room for it, as there may be later."""
        try:
            self._bus.send(message)
        except (can.CanError, OSError) as error:
            if not buffer_is_full(error):
                raise
            return False
        return True
