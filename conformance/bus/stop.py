"""Being asked to stop, by a signal: a flag that is looked at between frames.

An exception that comes at any moment would come within a driver or its queue, which may hang then,
or within what puts a value back. So the first request ends what a case does, at the next frame; the
second also what is being put back. Only code that is not the suite's, and may wait for anything, is
interrupted at once.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager


class RunStopped(KeyboardInterrupt):
    """The run was asked to end; pytest takes it for what Ctrl-C raises."""


class Stop:
    """How often a run was asked to stop, and by what.

    ``requests`` counts; ``by`` names the last. Each request that is not tolerated where it is
    noticed raises RunStopped there.
    """

    def __init__(self) -> None:
        """No stop was asked for yet."""
        self.requests = 0
        self.by = ""
        self._tolerated = 0
        self._at_once = False
        self._busy = False
        self._listeners: list[Callable[[], None]] = []

    def when_requested(self, listener: Callable[[], None]) -> None:
        """Call ``listener`` at each request; it may come at any moment."""
        self._listeners.append(listener)

    @property
    def reason(self) -> str:
        """Why the run ends, as a part of a sentence."""
        return f"the run was stopped ({self.by})" if self.by else "the run was stopped"

    @property
    def gives_up(self) -> bool:
        """Whether what is not put back yet is to be listed instead."""
        return self.requests > 1

    def request(self, by: str) -> None:
        """Ask to stop; raises RunStopped where that may be done at any moment."""
        self.requests += 1
        self.by = by
        for listener in self._listeners:
            listener()
        if self._at_once and not self._busy:
            self.check()

    def check(self) -> None:
        """Raise RunStopped if there is a request that is not tolerated here."""
        if self.requests > self._tolerated:
            raise RunStopped(self.reason)

    def enter(self) -> None:
        """Begin what must not be interrupted: it is short."""
        if self.requests:
            self.check()
        self._busy = True

    def leave(self) -> None:
        """End it."""
        self._busy = False
        if self._at_once:
            self.check()

    @contextmanager
    def putting_back(self) -> Iterator[None]:
        """Within this, one request is tolerated, and none interrupts at once."""
        tolerated, at_once = self._tolerated, self._at_once
        self._tolerated, self._at_once = 1, False
        try:
            yield
        finally:
            self._tolerated, self._at_once = tolerated, at_once

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """Within this, code runs that knows of no requests: each interrupts it at once."""
        before = self._at_once
        self._at_once = True
        try:
            self.check()
            yield
        finally:
            self._at_once = before
