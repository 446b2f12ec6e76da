"""How long the answers of one case may take: what it has to move, at the pace that the device had.

A device that takes its time for each answer may: its cases take long. One that has become slow in
the middle of a run is not wrong for it, as long as each answer comes in time, but a case that waits
for thousands of them would hold up the run for hours.
"""

from conformance.bus.kinds import Tasks
from conformance.bus.pace import Pace
from conformance.device.not_testable import NotTestable

# How many answers it takes to know the pace of a device, and how many that of a kind of request.
KNOWN, KNOWN_OF_KIND = 100, 10
# What the answers of a case may take: a multiple of the pace, and at least these seconds.
FACTOR, LEAST = 20.0, 60.0


class Allowance:
    """The answers of a case that is running, and how long they took; times are in seconds."""

    def __init__(self, pace: Pace) -> None:
        """Take the pace of the device before the case."""
        self._typical = pace.typical if pace.answers >= KNOWN else None
        self._means = pace.means(KNOWN_OF_KIND)
        self._answers = 0
        self._taken = self._usual = 0.0

    def take(self, seconds: float, tasks: Tasks | None = None) -> None:
        """Take an answer that came after some time; raises NotTestable when it is too much.

        The ``tasks`` are what was done in that time. A kind of them that was seldom met before
        takes as long as it takes.
        """
        self._answers += 1
        self._taken += seconds
        if self._typical is None:
            return
        kinds = [(self._means.get(task.kind), number) for task, number in (tasks or {}).items()]
        if any(mean is None for mean, _ in kinds):
            self._usual += max(seconds, self._typical)
        else:
            each = sum(mean * number for mean, number in kinds if mean is not None)
            self._usual += max(each, self._typical)
        limit = LEAST + FACTOR * self._usual
        if self._taken > limit:
            raise NotTestable(
                f"bench: the device has become slow: {self._answers} answers took "
                f"{self._taken:.0f} s, {1000 * self._taken / self._answers:.4g} ms each, where "
                f"they took {1000 * self._typical:.3g} ms before this case"
            )
