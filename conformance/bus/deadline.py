"""An end of waiting that no frame moves: what never stops talking must not hold up a run."""

from collections.abc import Callable


class Deadline:
    """An end some seconds from now, by a clock; ``left`` are the seconds up to it."""

    __slots__ = ("_end", "_now")

    def __init__(self, seconds: float, now: Callable[[], float]) -> None:
        """``now`` tells the time in seconds."""
        self._now = now
        self._end = now() + seconds

    @property
    def left(self) -> float:
        """How many seconds are left; 0 when it has passed."""
        return max(self._end - self._now(), 0.0)

    @property
    def has_passed(self) -> bool:
        """Whether no time is left."""
        return self._now() >= self._end
