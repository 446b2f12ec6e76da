"""A bus that is followed while it runs, until Ctrl-C: nothing is sent there."""

import signal
from collections.abc import Iterator
from contextlib import ExitStack
from types import FrameType, TracebackType
from typing import Self

import can

from conformance.bus.link import Link
from conformance.bus.stop import RunStopped, Stop
from conformance.logs.reading import Seen
from conformance.sdo.printable_text import inert

# Seconds of one wait for a frame; a request to stop ends it at once.
WAIT = 60.0
SIGNALS = (signal.SIGINT, signal.SIGTERM)


class LiveLog:
    """The frames of a bus as they come, the first at time 0; a context manager."""

    unit = "frame"

    def __init__(self, bus: can.BusABC, name: str) -> None:
        """Take an open bus, which is closed at the end; each frame has its name."""
        self._stop = Stop()
        self._link = Link(bus, name, self._stop)
        self._bus = inert(name)
        self._stack = ExitStack()

    def __enter__(self) -> Self:
        """Take the signals that end a program, from now on they end the frames."""
        self._stack.callback(self._link.close)
        for number in SIGNALS:
            self._stack.callback(signal.signal, number, signal.signal(number, self._ask))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._stack.close()

    def __iter__(self) -> Iterator[Seen]:
        """Yield frame by frame until a signal; raises BenchError."""
        number, begin = 0, 0.0
        while True:
            try:
                frame = self._link.receive(WAIT)
            except RunStopped:
                return
            if frame is None or frame.fd:
                continue
            number += 1
            begin = begin or self._link.arrived
            yield Seen(number, self._link.arrived - begin, self._bus, frame)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        del frame
        self._stop.request(signal.Signals(number).name)
