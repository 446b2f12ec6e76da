"""The signals that end a run: taken in when it begins, put back when it is over.

Ctrl-C, ``timeout``, a cancelled job and a terminal that goes away all end a run in good order:
values are put back, programs stopped, reports written. The handlers are the suite's own because
Python has none where SIGINT was ignored at its start, and none for SIGTERM anywhere.

A worker of pytest-xdist takes signals from its controller alone: a signal of the terminal reaches
both of them, and would count twice.
"""

import os
import signal
from collections.abc import Generator
from contextlib import AbstractContextManager, nullcontext
from types import FrameType

import pytest

from conformance.bus.stop import Stop
from conformance.plugin.items import CaseFunction
from conformance.plugin.workers import TELLS_WORKER, Share, leave_number

# The request at which nothing is waited for any more.
LAST = 3
_HANGUP = getattr(signal, "SIGHUP", None)


class Stopping:
    """The hooks that let signals be noticed where they may be."""

    def __init__(self, stop: Stop, share: Share) -> None:
        """Signals go to ``stop``; ``share`` says whether this process is a worker."""
        self._stop = stop
        self._share = share
        self._is_worker = bool(share.worker)
        self._parent = os.getppid()
        self._before: dict[int, object] = {}
        self._at_once: AbstractContextManager[None] = nullcontext()

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionstart(self) -> None:
        """Take the signals; until the first case any of them ends the run at once."""
        for number in (signal.SIGINT, signal.SIGTERM, _HANGUP, TELLS_WORKER):
            if number is None or (number == TELLS_WORKER and not self._is_worker):
                continue
            before = signal.getsignal(number)
            if number == _HANGUP and before == signal.SIG_IGN:
                continue  # as nohup wants it
            try:
                signal.signal(number, self._handle)
            except ValueError:
                return  # only the main thread may
            self._before[number] = before
        if self._is_worker:
            # Its controller waits until it says that it has ended, which a session does that has
            # begun: it begins, and ends with its first test.
            leave_number(self._share)
            return
        self._at_once = self._stop.interruptible()
        self._at_once.__enter__()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtestloop(self) -> Generator[None, object, object]:
        """From here on, notice them between frames."""
        self._at_once.__exit__(None, None, None)
        return (yield)

    @pytest.hookimpl(trylast=True)
    def pytest_unconfigure(self) -> None:
        """Put the earlier handlers back."""
        for number, handler in self._before.items():
            # None stands for a handler that was not installed by Python.
            signal.signal(number, signal.SIG_DFL if handler is None else handler)  # type: ignore[arg-type]
        self._before.clear()

    def _handle(self, number: int, frame: FrameType | None) -> None:
        del frame
        told = number == TELLS_WORKER
        if self._is_worker and not told and os.getppid() == self._parent:
            return
        try:
            self._stop.request("" if told else signal.Signals(number).name)
        finally:
            if self._stop.requests >= LAST:
                signal.signal(number, signal.SIG_DFL)
                os.kill(os.getpid(), number)

    # Tests of the user's own may wait for anything

    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Generator[None, object, object]:
        """Let the fixtures of an own test be interrupted at once."""
        return (yield from self._interruptible(item))

    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Generator[None, object, object]:
        """Let an own test be interrupted at once."""
        return (yield from self._interruptible(item))

    def _interruptible(self, item: pytest.Item) -> Generator[None, object, object]:
        if isinstance(item, CaseFunction) and item.is_own:
            return (yield)
        with self._stop.interruptible():
            return (yield)
