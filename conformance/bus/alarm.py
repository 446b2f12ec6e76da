"""Waiting for a point in time, as exactly as an operating system allows without spinning."""

import time
from collections.abc import Callable

# How fast it is learned how late timers fire, and what a busy machine may make of it at most.
LEARNING = 0.1
MOST_LATE = 0.0002


class Alarm:
    """Waits until a time. A timer fires late, by about as much each time: so it is set earlier."""

    def __init__(self, wait: Callable[[float], object] = time.sleep) -> None:
        """``wait`` takes seconds."""
        self._wait = wait
        self._lateness = 0.0

    def wait_until(self, due: float) -> None:
        """Wait for a time of the monotonic clock, in seconds; return at once when it is past."""
        left = due - time.monotonic() - self._lateness
        if left <= 0:
            return
        self._wait(left)
        late = time.monotonic() - due
        self._lateness = min(MOST_LATE, max(0.0, self._lateness + LEARNING * late))
