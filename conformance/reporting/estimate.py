"""How long a run will take yet, by what its cases have to do and how long others have taken.

What a case has to do is known of the built-in device: how many answers it waits for, and how long
it takes where these come at once. How long an answer takes, and how fast the machine is, the cases
tell that are done. Where those of a kind take more or less than that, the others of the kind will.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from conformance.device.effort import SEARCH_SECONDS
from conformance.reporting.workload import RANDOM, Work, work_of
from conformance.run.verdict import NOT_TESTED, CaseResult

# The weight of an answer, where a second of work weighs 1: cases count by what they have to do.
ANSWER = 0.001
# How many segments go out in bursts for each answer of a whole run.
SEGMENTS = 0.7
# So many cases like on the built-in device speak against those of a kind that were done, or this
# share of the kind: the first ones prepare what all others of it need.
DOUBT, DOUBT_SHARE = 3.0, 0.2
# What is left of a case where the same was not testable for another service: for want of room, say.
LACKING = 0.05


@dataclass(slots=True)
class _Kind:
    """How long the cases of a kind took, and how long they should have, in seconds."""

    taken: float = 0.0
    due: float = 0.0
    done: int = 0
    left: int = 0

    def ratio(self, before: float) -> float:
        """Return how much longer than due a case takes; ``before`` where none was done."""
        cases = max(DOUBT, DOUBT_SHARE * (self.done + self.left))
        doubt = cases * self.due / self.done if self.done else 0.0
        return (self.taken + before * doubt) / (self.due + doubt) if self.due else before


@dataclass(frozen=True, slots=True)
class Taken:
    """How long a case has taken, in seconds: all in all, ``answering`` and for silences ``waited``.

    One that was not ``tried`` says nothing of the pace.
    """

    seconds: float
    answers: int = 0
    answering: float = 0.0
    waited: float = 0.0
    tried: bool = True

    @classmethod
    def by(cls, result: CaseResult | None, seconds: float) -> Self:
        """Return how long a test has taken, as far as it is known; not each has a result.

        ``seconds`` are those since the one before: a case may have run beside others for longer.
        """
        if result is None:
            return cls(seconds, tried=False)
        tried = result.verdict not in NOT_TESTED
        seconds = max(seconds, result.duration)
        return cls(seconds, result.answers, result.answering, result.waited, tried)


@dataclass(slots=True)
class Pace:
    """What a second of the built-in device's work takes here, and what an answer takes."""

    answers: int = 0
    answering: float = 0.0
    work: float = 0.0
    working: float = 0.0

    def add(self, work: Work, taken: Taken) -> None:
        """Take how long a case has taken."""
        self.answers += taken.answers
        self.answering += taken.answering
        self.work += work.seconds
        self.working += max(taken.seconds - taken.answering - taken.waited, 0.0)

    def fit(self) -> tuple[float, float]:
        """Return the seconds for a second of work, and for an answer."""
        answer = self.answering / self.answers if self.answers else 0.0
        return (self.working / self.work if self.work else 1.0), answer


@dataclass(slots=True)
class _Finished:
    """Cases that had the same to do: how many, how long they took, and whether any was tried."""

    cases: int = 0
    seconds: float = 0.0
    tried: bool = False


@dataclass(slots=True)
class Estimate:
    """The cases of a run, by the process that runs them, as pytest names them.

    ``silence`` is its length in seconds. Random cases try ``times`` the usual examples, but
    no longer than ``search_seconds``. Cases that have the same to do, as those of many devices, are
    counted together.
    """

    silence: float = 0.0
    times: float = 1.0
    search_seconds: float = SEARCH_SECONDS
    pace: Pace = field(default_factory=Pace)
    selected: int = 0
    done: int = 0
    _due: dict[str, dict[str, Work]] = field(default_factory=dict)
    _left: dict[str, Counter[Work]] = field(default_factory=dict)
    _finished: defaultdict[Work, _Finished] = field(default_factory=lambda: defaultdict(_Finished))
    _whole_weight: float = 0.0
    _done_weight: float = 0.0

    def work(self, name: str) -> Work:
        """Return what a case has to do in this run."""
        work = work_of(name)
        if work.service != RANDOM:
            return work
        return replace(
            work,
            answers=work.answers * self.times,
            silences=work.silences * self.times,
            seconds=work.seconds * self.times,
            at_most=self.search_seconds,
        )

    def due(self, name: str) -> float:
        """Return how many seconds a case will take at the pace of those that are done."""
        return self.work(name).due(*self.pace.fit(), self.silence)

    def before(self, answer: float) -> float:
        """Return how many seconds the run will take where an answer takes ``answer`` seconds.

        So long does each segment of a burst, as far as is known: none was sent yet.
        """
        each = answer * (1 + SEGMENTS)
        return max(
            (
                sum(work.due(1.0, each, self.silence) * cases for work, cases in works.items())
                for works in self._left.values()
            ),
            default=0.0,
        )

    def select(self, names: Iterable[str], worker: str = "") -> None:
        """Take the cases that a process is going to run."""
        self._due[worker] = {name: self.work(name) for name in names}
        self._left[worker] = works = Counter(self._due[worker].values())
        self.selected += works.total()
        self._whole_weight += sum(_weight(work) * cases for work, cases in works.items())

    def finish(self, name: str, taken: Taken, worker: str = "") -> None:
        """Take a case that is done."""
        work = self._due.get(worker, {}).pop(name, None)
        if work is None:
            return
        self._left[worker][work] -= 1
        self._done_weight += _weight(work)
        self.done += 1
        finished = self._finished[work]
        finished.cases += 1
        finished.seconds += taken.seconds
        finished.tried |= taken.tried
        if taken.tried:
            self.pace.add(work, taken)

    @property
    def part(self) -> float:
        """How much of the work is done, from 0 to 1, if an answer takes what it usually does."""
        return self._done_weight / self._whole_weight if self._done_weight else 0.0

    def left(self) -> float:
        """Return how many seconds the run will take yet."""
        fit = (*self.pace.fit(), self.silence)
        kinds: defaultdict[str, _Kind] = defaultdict(_Kind)
        tried: defaultdict[str, bool] = defaultdict(bool)
        for work, finished in self._finished.items():
            tried[work.point] |= finished.tried
            for name in (work.service, work.family):
                kind = kinds[name]
                kind.taken += finished.seconds
                kind.due += work.due(*fit) * finished.cases
                kind.done += finished.cases
        for works in self._left.values():
            for work, cases in works.items():
                kinds[work.service].left += cases
                kinds[work.family].left += cases
        return max(
            (_seconds(works, fit, kinds, tried) for works in self._left.values()), default=0.0
        )


def _weight(work: Work) -> float:
    return work.seconds + work.answers * ANSWER


def _seconds(
    works: Mapping[Work, int],
    fit: tuple[float, float, float],
    kinds: dict[str, _Kind],
    tried: dict[str, bool],
) -> float:
    total = 0.0
    for work, cases in works.items():
        lacking = work.point in tried and not tried[work.point]
        before = LACKING if lacking else kinds[work.service].ratio(1.0)
        total += work.due(*fit) * kinds[work.family].ratio(before) * cases
    return total
