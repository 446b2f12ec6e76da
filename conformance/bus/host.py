"""A node of the reference server on a python-can bus, answering in a thread of its own."""

import threading
import time
from types import TracebackType
from typing import Protocol, Self

import can

from conformance.bus.alarm import Alarm
from conformance.bus.messages import to_frame, to_message
from conformance.sdo.can_frame import CanFrame

# How long a stop may go unseen: nothing but a frame interrupts python-can's waiting.
POLL = 0.05


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


class NodeHost:
    """Runs a node until it is stopped; a context manager."""

    def __init__(self, bus: can.BusABC, node: HostedNode, delay: float = 0.0) -> None:
        """Take an open bus, which the host closes when it stops.

        ``delay`` is the time in seconds from a request to its answer, of one frame or more.
        """
        self._bus = bus
        self._node = node
        self._delay = delay
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
            self._send(self._node.advance(time.monotonic()))
            self._send(self._node.start())
            while not self._stopping.is_set():
                message = self._bus.recv(self._patience())
                now = time.monotonic()
                if due := self._node.advance(now):
                    self._send(due)
                if message is not None and not message.is_error_frame:
                    answers = self._node.receive(to_frame(message))
                    if answers:
                        self._answer(answers, now + self._delay)
        finally:
            self._bus.shutdown()

    def _patience(self) -> float:
        """Return for how many seconds to wait for a frame."""
        due = self._node.wake_at
        return POLL if due is None else min(POLL, max(0.0, due - time.monotonic()))

    def _answer(self, frames: list[CanFrame], due: float) -> None:
        if self._delay:
            self._alarm.wait_until(due)
        self._send(frames)

    def _send(self, frames: list[CanFrame]) -> None:
        for frame in frames:
            self._bus.send(to_message(frame))
