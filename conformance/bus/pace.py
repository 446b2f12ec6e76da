"""How fast a device answers, and how often it does not: what one may expect of it from then on."""

from collections import Counter, deque

from conformance.sdo.nmt import NmtState

# Requests that were left unanswered for the whole time-out, before it is cut short.
PROVEN = 10
# How much longer than nearly all of its answers took a device is waited for then.
MARGIN = 10.0
# The shortest wait in seconds, the shortest where an answer need not come, and the shortest where
# nothing is concluded from a silence. On a busy machine a device that is a program may take longer.
SHORTEST, SHORTEST_OF_OPEN, SHORTEST_OF_LOOK = 0.25, 0.1, 0.02
# How much longer than the longest time so far it may take a device to enter the same NMT state.
SLOWER = 2.0
# Of this number of answers, the machine may have delayed one.
NEARLY_ALL = 100
# Plain reads that are looked at, each behind an answer, and how many unanswered ones are too many:
# a sound device leaves none unanswered.
LOOKED_AT, TOO_MANY = 60, 12


class Pace:
    """The answers of one device within one run; times are in seconds.

    ``total`` is the time to all of them, ``silences`` the number of those that did not come.
    ``beside`` are the answers on further channels.
    """

    def __init__(self) -> None:
        """Nothing was asked yet."""
        self.answers = 0
        self.total = 0.0
        self.silences = 0
        self.beside = 0
        # By the power of two in milliseconds within which they came.
        self._within: Counter[int] = Counter()
        self._latest = 0.0
        # The longest time that it took to enter each NMT state.
        self._entering: dict[NmtState | None, float] = {}
        self._reads: deque[bool] = deque(maxlen=LOOKED_AT)

    def answered(self, seconds: float) -> None:
        """Take an answer that came after some time."""
        self.answers += 1
        self.total += seconds
        self._within[int(seconds * 1000).bit_length()] += 1

    def unanswered(self) -> None:
        """Take that a request, which had to be answered, was not, within the time for it."""
        self.silences += 1

    def late(self, seconds: float) -> None:
        """Take that an answer came after the wait for it had ended."""
        self._latest = max(self._latest, seconds)

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

    def patience(self, timeout: float) -> float:
        """Return how long to wait for an answer that has to come within ``timeout``.

        A device that was seen again and again to leave a request unanswered is waited for only
        as long as makes sure: far longer than nearly all of its answers took, and any late one.
        """
        return timeout if self.silences < PROVEN else self._sure(timeout, SHORTEST)

    def soon(self, timeout: float) -> float:
        """Return how long to wait for what comes as soon as this device answers, if it does."""
        return self._sure(timeout, SHORTEST_OF_OPEN)

    def look(self, timeout: float) -> float:
        """Return how long to look for what comes so soon, where it may come later as well."""
        return self._sure(timeout, SHORTEST_OF_LOOK)

    def _sure(self, timeout: float, shortest: float) -> float:
        return min(timeout, max(self.nearly_all * MARGIN, self._latest * MARGIN, shortest))

    @property
    def nearly_all(self) -> float:
        """Within which time nearly all answers have come."""
        late = self.answers // NEARLY_ALL
        for power in sorted(self._within, reverse=True):
            late -= self._within[power]
            if late < 0:
                return float(1 << power) / 1000
        return 0.0

    @property
    def typical(self) -> float:
        """The mean time to an answer; 0 as long as there was none."""
        return self.total / self.answers if self.answers else 0.0

    @property
    def unsound(self) -> str:
        """Say that the device leaves whatever it is asked unanswered now and then; empty if not."""
        missing = len(self._reads) - sum(self._reads)
        if missing < TOO_MANY:
            return ""
        return (
            f"it did not answer {missing} of the last {len(self._reads)} reads of 1000h that "
            "were sent right after an answer, but answered them when repeated: it drops requests "
            "of every kind, or the bus loses frames"
        )
