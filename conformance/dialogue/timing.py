"""How long a device takes to answer within one case; times are in seconds."""

import time
from collections.abc import Callable

from conformance.bus.kinds import READING, Kind, Task, Tasks
from conformance.bus.pace import Pace
from conformance.dialogue.slow_device import Allowance


class Timing:
    """The time that answers took on one channel, and the time spent on those that did not come.

    ``latency`` is the longest that an answer took, ``answering`` what all ``answers`` took, and
    ``waited`` what was spent on silence. ``answered_after`` is the time after which an answer came
    that a case had given up to wait for, None if there is none. The ``allowance`` is how long
    answers may take; None without a limit.
    """

    def __init__(self, pace: Pace, now: Callable[[], float] | None = None) -> None:
        """Take the pace of the device, which every answer tells more of, and what the time is."""
        self._now = now or time.monotonic
        self.latency = self.waited = self.answering = 0.0
        self.answers = 0
        self.answered_after: float | None = None
        self.allowance: Allowance | None = None
        self._pace = pace
        self._sent_at = 0.0
        self._awaits = False
        # What was asked and is not answered, and what was asked last.
        self._due = Tasks()
        self._last = Tasks((READING,))
        self._unanswered_at: float | None = None

    def sent(self, task: Task = READING) -> None:
        """Take that something is sent now, which the device has to deal with."""
        self._sent_at = self._now()
        self._awaits = True
        self._due[task] += 1
        if task.kind is not Kind.ENDING:
            self._last = Tasks((task,))

    def left(self, at: float) -> None:
        """Take when the frame was sent: a pause before it is no time that its answer has taken."""
        self._sent_at = at

    def ended(self) -> None:
        """Take that the suite has ended a transfer, which is not answered."""
        self._due[Task(Kind.ENDING)] += 1

    @property
    def due(self) -> Tasks:
        """What the device may be busy with: all that is not answered, or was asked last."""
        return self._due or self._last

    def received(self, arrived: float) -> None:
        """Take a response; what comes behind the first one is no answer of its own.

        Raises NotTestable where the answers have taken too long.
        """
        latency = arrived - self._sent_at
        self.latency = max(self.latency, latency)
        if not self._awaits:
            return
        self._awaits = False
        done, self._due = self._due, Tasks()
        self._pace.answered(latency, done)
        self.answers += 1
        self.answering += latency
        if self.allowance is not None:
            self.allowance.take(latency, done)

    def waited_since(self, begin: float) -> None:
        """Take that nothing has come since."""
        self.waited += self._now() - begin

    def gave_up(self) -> None:
        """Take that the wait for the answer to what was sent last has ended."""
        self._unanswered_at = self._sent_at
        self._due = Tasks()

    def came_late(self) -> None:
        """Take that something came when nothing was asked: the first such is a late answer."""
        if self._unanswered_at is not None and self.answered_after is None:
            self.answered_after = self._now() - self._unanswered_at
            self._pace.late(self.answered_after)

    def include(self, other: "Timing") -> None:
        """Count as well what was waited for on another channel of the same case."""
        self._pace.beside += other.answers
        self.waited += other.waited
        self.latency = max(self.latency, other.latency)
