"""How fast a device answers, and how often it does not: what one may expect of it from then on.

Each kind of request has a pace of its own, and so has each object that is written: a device may
read at once, and take its time for what goes into an EEPROM.
"""

from collections import Counter, defaultdict, deque
from math import ceil

from conformance.bus.kinds import READING, Kind, Task, Tasks
from conformance.sdo.nmt import NmtState

# Requests that were left unanswered for the whole time-out, before it is cut short.
PROVEN = 10
# How much longer than nearly all of its answers took a device is waited for then.
MARGIN = 10.0
# The same where nothing is concluded from a silence.
MARGIN_OF_LOOK = 3.0
# The shortest wait in seconds, the shortest where an answer need not come, and the shortest where
# nothing is concluded from a silence. On a busy machine a device that is a program may take longer.
SHORTEST, SHORTEST_OF_OPEN, SHORTEST_OF_LOOK = 0.25, 0.1, 0.02
# How much longer than the longest time so far it may take a device to enter the same NMT state.
SLOWER = 2.0
# How much longer a request may take than nearly all of its kind, where others wait behind it.
SLOWEST = 2.0
# The seconds that each segment of a burst may take as long as no burst was acknowledged.
SEGMENT_TIME = 0.02
# The seconds that a device takes at least for a frame that it does not answer.
SHORTEST_OF_ROOM = 0.002
# Of this number of answers, the machine may have delayed one.
NEARLY_ALL = 100
# What is likely to have taken the time where several tasks were done, the most likely last.
BY_SLOWNESS = (
    Kind.READ,
    Kind.SEGMENT,
    Kind.ENDING,
    Kind.WRITE,
    Kind.BURST,
    Kind.BLOCK_END,
    Kind.STORE,
)
# Plain reads that are looked at, each behind an answer, and how many unanswered ones are too many:
# a sound device leaves none unanswered.
LOOKED_AT, TOO_MANY = 60, 12


class Pace:
    """The answers of one device within one run; times are in seconds.

    ``total`` is the time to all of them, ``silences`` the number of those that did not come.
    ``beside`` are the answers on further channels.
    """

    def __init__(self, like: "Pace | None" = None) -> None:
        """Nothing was asked yet; a further channel of a device is as fast ``like`` the others."""
        self._like = like
        self.answers = 0
        self.total = 0.0
        self.silences = 0
        self.beside = 0
        # By the power of two in milliseconds within which they came.
        self._within: Counter[int] = Counter()
        self._of: defaultdict[Task, Counter[int]] = defaultdict(Counter)
        # How many tasks of a kind were done, and how long they took.
        self._done: Counter[Kind] = Counter()
        self._taken: defaultdict[Kind, float] = defaultdict(float)
        self._latest = 0.0
        self._lates = 0
        # The longest time that it took to enter each NMT state.
        self._entering: dict[NmtState | None, float] = {}
        self._reads: deque[bool] = deque(maxlen=LOOKED_AT)

    def answered(self, seconds: float, tasks: Tasks | None = None) -> None:
        """Take an answer that came after some time, in which the ``tasks`` were done."""
        self.answers += 1
        self.total += seconds
        self._within[_power(seconds)] += 1
        if tasks:
            task = max(tasks, key=_slowness)
            self._done[task.kind] += tasks[task]
            self._taken[task.kind] += seconds
            each = _power(seconds / tasks[task])
            self._of[Task(task.kind)][each] += 1
            if task.about:
                self._of[task][each] += 1

    def unanswered(self) -> None:
        """Take that a request, which had to be answered, was not, within the time for it."""
        self.silences += 1

    def late(self, seconds: float) -> None:
        """Take that an answer came after the wait for it had ended."""
        self._latest = max(self._latest, seconds)
        self._lates += 1

    def read(self, *, answered: bool) -> None:
        """Take a plain read right behind an answer, with no transfer open: it has to be served."""
        self._reads.append(answered)

    def entered(self, state: NmtState | None, seconds: float) -> None:
        """Take that the device has told a new NMT state some time after the command."""
        self._entering[state] = max(self._entering.get(state, 0.0), seconds)

    def entering(self, state: NmtState | None, limit: float) -> float:
        """Return how long to wait until a state is entered that the device does not tell."""
        if state not in self._entering:
            return limit
        return min(limit, max(self._entering[state] * SLOWER, SHORTEST_OF_LOOK))

    def patience(self, timeout: float, tasks: Tasks | None = None) -> float:
        """Return how long to wait for an answer that has to come within ``timeout``.

        That is the time for one request: where more ``tasks`` are not done yet it grows with them.
        A device that was seen again and again to leave a request unanswered is waited for only
        as long as makes sure: far longer than nearly all of its answers took, and any late one.
        """
        limit = self._limit(timeout, tasks)
        return limit if self.silences < PROVEN else self._sure(limit, SHORTEST, tasks)

    def soon(self, timeout: float, tasks: Tasks | None = None) -> float:
        """Return how long to wait for what comes as soon as this device answers, if it does."""
        return self._sure(self._limit(timeout, tasks), SHORTEST_OF_OPEN, tasks)

    def look(self, timeout: float, tasks: Tasks | None = None) -> float:
        """Return how long to look for what comes so soon, where it may come later as well."""
        return self._sure(self._limit(timeout, tasks), SHORTEST_OF_LOOK, tasks, MARGIN_OF_LOOK)

    def room(self, timeout: float) -> float:
        """Return after how long a device has room for a request behind a frame without an answer.

        That is as long as a read takes, and no longer: in a sub-block a silence has a meaning. As
        long as nothing is known of a device it may be any slow.
        """
        usual = self._usual(READING)
        return min(timeout, max(usual * SLOWEST, SHORTEST_OF_ROOM) if usual else SHORTEST_OF_OPEN)

    def _limit(self, timeout: float, tasks: Tasks | None) -> float:
        """Return how long the tasks may take at the most, where one of them has ``timeout``."""
        if not tasks or tasks.total() == 1:
            return timeout
        return max(timeout, sum(self._slowest(task) * tasks[task] for task in tasks))

    def _slowest(self, task: Task) -> float:
        known = self._known(task)
        unknown = SEGMENT_TIME if task.kind is Kind.BURST else self.nearly_all
        return unknown if known is None else known * SLOWEST

    def _sure(
        self, limit: float, shortest: float, tasks: Tasks | None, margin: float = MARGIN
    ) -> float:
        if not tasks:
            usual = self.nearly_all
        elif any(task.kind is Kind.STORE and self._known(task) is None for task in tasks):
            return limit  # which may take seconds
        else:
            usual = sum(self._usual(task) * tasks[task] for task in tasks)
        return min(limit, max(usual * margin, self._latest * margin, shortest))

    def _usual(self, task: Task) -> float:
        known = self._known(task)
        return self.nearly_all if known is None else known

    def _known(self, task: Task) -> float | None:
        """Return within which time nearly all of a kind were done, or nearly all of its object."""
        found = [self._of[each] for each in {task, Task(task.kind)} if each in self._of]
        if found:
            return max(map(_nearly_all, found))
        return None if self._like is None else self._like._known(task)

    @property
    def nearly_all(self) -> float:
        """Within which time nearly all answers have come."""
        if not self._within and self._like is not None:
            return self._like.nearly_all
        return _nearly_all(self._within)

    @property
    def typical(self) -> float:
        """The mean time to an answer; 0 as long as there was none."""
        return self.total / self.answers if self.answers else 0.0

    def means(self, least: int) -> dict[Kind, float]:
        """Return the mean time of each kind of task of which ``least`` were done."""
        return {
            kind: self._taken[kind] / done for kind, done in self._done.items() if done >= least
        }

    @property
    def unsound(self) -> str:
        """Say that the device leaves whatever it is asked unanswered now and then; empty if not."""
        missing = len(self._reads) - sum(self._reads)
        if missing < TOO_MANY:
            return ""
        if self._lates >= missing / 2:
            enough = ceil(2 * self._latest)
            return (
                f"it answered {missing} of the last {len(self._reads)} reads of 1000h too late, "
                f"up to {self._latest:.3g} s after them: if it may take so long, give it that time "
                f"with --sdo-response-timeout={enough}"
            )
        return (
            f"it did not answer {missing} of the last {len(self._reads)} reads of 1000h that "
            "were sent right after an answer, but answered them when repeated: it drops requests "
            "of every kind, or the bus loses frames; or it needs more time for an answer than "
            "--sdo-response-timeout gives it"
        )


def _power(seconds: float) -> int:
    return int(seconds * 1000).bit_length()


def _nearly_all(within: Counter[int]) -> float:
    late = within.total() // NEARLY_ALL
    for power in sorted(within, reverse=True):
        late -= within[power]
        if late < 0:
            return float(1 << power) / 1000
    return 0.0


def _slowness(task: Task) -> int:
    """Order tasks by what is more likely to have taken the time of them all."""
    return BY_SLOWNESS.index(task.kind)
