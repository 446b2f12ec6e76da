"""How long a silence has lasted: it counts only while the suite was listening.

A busy machine may keep this process from running, in the middle of a wait as anywhere else. The
wait is made of short looks; what a look took longer than it should was not spent listening, so it
does not count, and what has arrived meanwhile is looked at before the wait is over.
"""

import time
from collections.abc import Callable

# Seconds of one look: shorter than any response time-out that is in use.
LOOK = 0.05
# A look that ends later than it should by this time was interrupted: timers alone never are.
LATE = 0.02
# Where looks never end in time, waiting has to end nevertheless.
MOST_LATE = 40
# For how many seconds past its end a wait looks at frames that have arrived already.
DRAIN_LIMIT = 0.25
# A silence is in doubt when this much of the wait was missed: in seconds, and as a share of it.
DOUBT, DOUBTFUL_PART = 0.05, 0.25


class Patience:
    """One wait for frames: how long to look next, and whether it is over.

    ``missed`` are the seconds during which this process was not running. A ``plain`` wait counts
    them: it ends by the clock, even if the suite was not listening.
    """

    __slots__ = (
        "_asked",
        "_late",
        "_now",
        "_over",
        "_plain",
        "_seconds",
        "_since",
        "left",
        "missed",
    )

    def __init__(
        self, seconds: float, *, plain: bool = False, now: Callable[[], float] | None = None
    ) -> None:
        """Begin a wait; ``seconds`` is its length by the clock ``now``: if none, the machine's."""
        self.left = seconds
        self.missed = 0.0
        self._seconds = seconds
        self._plain = plain
        self._over = False
        self._late = 0
        self._asked = 0.0
        self._now = now or time.monotonic
        self._since = self._now()

    @property
    def over(self) -> bool:
        """Whether the time is up, and nothing is left that came in time."""
        return self._over or self.left < -DRAIN_LIMIT

    @property
    def in_doubt(self) -> bool:
        """Whether enough of the wait was missed to explain a silence."""
        return self.missed > max(DOUBT, DOUBTFUL_PART * self._seconds)

    def look(self, shortest: float) -> float:
        """Begin a look; return how many seconds it lasts unless a frame ends it."""
        asked = self.left if self.left < LOOK else LOOK
        self._asked = asked if asked > shortest else shortest
        return self._asked

    def looked(self, *, silent: bool) -> None:
        """End a look: nothing came, or something that was not awaited."""
        now = self._now()
        took, self._since = now - self._since, now
        late = took - self._asked
        if self._plain:
            self.left -= max(took, self._asked) if silent else took
        else:
            # On a simulated bus a silence takes no time, and has lasted all the same.
            self.left -= self._asked if silent else min(took, max(self._asked, LATE))
        if late > LATE:
            self.missed += late
            self._late += 1
            if self._late <= MOST_LATE and not self._plain:
                # The device, on the same machine perhaps, has to have its turn as well.
                self.left = max(self.left, LOOK)
        self._over = silent and self.left <= 0
