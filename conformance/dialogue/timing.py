"""How long a device takes to answer within one case; times are in seconds."""

import time

from conformance.bus.pace import Pace
from conformance.dialogue.allowance import Allowance


class Timing:
    """The time that answers took on one channel, and the time spent on those that did not come.

    ``latency`` is the longest that an answer took, ``answering`` what all ``answers`` took, and
    ``waited`` what was spent on silence. ``answered_after`` is the time after which an answer came
    that a case had given up to wait for, None if there is none. The ``allowance`` is how long
    answers may take; None without a limit.
    """

    def __init__(self, pace: Pace) -> None:
        """Take the pace of the device, which every answer tells more of."""
        self.latency = self.waited = self.answering = 0.0
        self.answers = 0
        self.answered_after: float | None = None
        self.allowance: Allowance | None = None
        self._pace = pace
        self._sent_at = self._answered = 0.0
        self._unanswered_at: float | None = None

    def sent(self) -> None:
        """Take that something is sent now."""
        self._sent_at = time.monotonic()

    def received(self, arrived: float) -> None:
        """Take a response; what comes behind the first one is no answer of its own.

        Raises NotTestable where the answers have taken too long.
        """
        latency = arrived - self._sent_at
        self.latency = max(self.latency, latency)
        if self._sent_at == self._answered:
            return
        self._answered = self._sent_at
        self._pace.answered(latency)
        self.answers += 1
        self.answering += latency
        if self.allowance is not None:
            self.allowance.take(latency)

    def waited_since(self, begin: float) -> None:
        """Take that nothing has come since."""
        self.waited += time.monotonic() - begin

    def gave_up(self) -> None:
        """Take that the wait for the answer to what was sent last has ended."""
        self._unanswered_at = self._sent_at

    def came_late(self) -> None:
        """Take that something came when nothing was asked: the first such is a late answer."""
        if self._unanswered_at is not None and self.answered_after is None:
            self.answered_after = time.monotonic() - self._unanswered_at
            self._pace.late(self.answered_after)

    def include(self, other: "Timing") -> None:
        """Count as well what was waited for on another channel of the same case."""
        self._pace.beside += other.answers
        self.waited += other.waited
        self.latency = max(self.latency, other.latency)
