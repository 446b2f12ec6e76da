"""Which cases catch the most faults at the fewest requests."""

from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from random import Random
from typing import Self

# So many cases for each fault are in the order: a device may lack what the first of them needs.
CATCHERS = 4
# How often a choice within a budget gets another case; for how long one that made room for others
# is barred, and what it is worth then. What is least worth is so about; what is new counts more.
STEPS, BARRED, BACK, ABOUT, NEW = 8_000, (5, 40), 0.02, (0.8, 1.2), 5
# So many requests of a case belong to itself; it does more for all that follow.
ALIKE = 20

Weights = Mapping[str, Mapping[str, float]]
"""The cases that catch each fault, and how much each of these counts."""


def cover(catches: Weights, costs: Mapping[str, int], left_out: Collection[str]) -> Iterator[str]:
    """Yield cases that catch all faults together: next, what catches most per request."""
    caught_by: defaultdict[str, dict[str, float]] = defaultdict(dict)
    for name, found in catches.items():
        for case, weight in found.items():
            if case in costs and case not in left_out:
                caught_by[case][name] = weight
    while caught_by:
        best = max(caught_by, key=lambda case: sum(caught_by[case].values()) / max(costs[case], 1))
        gone = set(caught_by.pop(best))
        yield best
        for case in list(caught_by):
            for name in gone & caught_by[case].keys():
                del caught_by[case][name]
            if not caught_by[case]:
                del caught_by[case]


def by_worth(catches: Weights, costs: Mapping[str, int]) -> list[str]:
    """Return the cases that are worth an early place, the best first."""
    places: dict[str, None] = {}
    for _ in range(CATCHERS):
        places.update(dict.fromkeys(cover(catches, costs, places)))
    return list(places)


def family_of(case: str) -> str:
    """Return what a case shares its preparations with: those of one name.

    >>> family_of("upload.length[1]")
    'upload.length'
    """
    return case.partition("[")[0]


@dataclass(slots=True)
class Costs:
    """The requests of each case, and those of the first of a family for all the others."""

    each: dict[str, int]
    setups: dict[str, int] = field(default_factory=dict)

    @classmethod
    def by(cls, *counted: Mapping[str, int]) -> Self:
        """Return what cases cost that were counted in several orders: in whichever it is more.

        Where one of a family at most is the dear one in each order, and not always the same,
        that is for all of them. A case without requests needs what the device does not declare.
        """
        found = cls({})
        for case in {case: None for each in counted for case in each}:
            sent = [each[case] for each in counted if each.get(case)]
            if sent:
                found.each[case] = min(sent)
        dear = [found.dear(each) for each in counted]
        for family in {family for each in dear for family in each}:
            first = [each[family] for each in dear if family in each]
            if max(map(len, first)) == 1 and len({case for (case,) in first}) > 1:
                found.setups[family] = min(
                    run[case] - found.each[case]
                    for run, each in zip(counted, dear, strict=True)
                    for case in each.get(family, ())
                )
        for each in counted:
            for case, requests in each.items():
                if family_of(case) not in found.setups and requests:
                    found.each[case] = max(found.each[case], requests)
        return found

    def dear(self, counted: Mapping[str, int]) -> dict[str, list[str]]:
        """Return the cases that have sent far more than they should, by their families."""
        found: defaultdict[str, list[str]] = defaultdict(list)
        for case, requests in counted.items():
            if requests > self.each.get(case, requests) + ALIKE:
                found[family_of(case)].append(case)
        return found

    def shared(self) -> dict[str, int]:
        """Return the requests of each case, with its share of what is for its whole family."""
        members = Counter(map(family_of, self.each))
        return {
            case: requests + self.setups.get(family_of(case), 0) // members[family_of(case)]
            for case, requests in self.each.items()
        }

    def of(self, cases: Iterable[str]) -> int:
        """Return the requests of several cases."""
        chosen = list(cases)
        families = {family_of(case) for case in chosen}
        return sum(map(self.each.__getitem__, chosen)) + sum(
            self.setups.get(family, 0) for family in families
        )

    def correct(self, counted: Mapping[str, int]) -> None:
        """Take what cases of a run have sent, but for what was for a whole family."""
        for case, requests in counted.items():
            if case in self.each and family_of(case) not in self.setups:
                self.each[case] = max(requests, 1)


class Choice:
    """A choice of cases within a budget of requests: as many faults as can be had for that."""

    def __init__(
        self, caught: Mapping[str, Collection[str]], costs: Costs, budget: int, chance: Random
    ) -> None:
        """Take what each case catches; nothing is chosen yet."""
        self._caught = {case: sorted(caught[case]) for case in sorted(caught)}
        self._catchers: defaultdict[str, list[str]] = defaultdict(list)
        for case, found in self._caught.items():
            for name in found:
                self._catchers[name].append(case)
        self._costs = costs
        self._budget = budget
        self._chosen: dict[str, None] = {}
        self._times: Counter[str] = Counter()
        self._random = chance

    def best(self, begin: Iterable[str] = ()) -> list[str]:
        """Return the best of many: each is the last, and a case for a fault that it lacks.

        What is least worth makes room, and may not come back at once. ``begin`` is the first.
        """
        barred: dict[str, int] = {}
        best: list[str] = []
        most = (-1, 0)
        new = ""
        for case in begin:
            self._take(case)
        for step in range(STEPS):
            for gone in self._make_room(new):
                barred[gone] = step + self._random.randint(*BARRED)
            rank = sum(count > 0 for count in self._times.values()), -self._costs.of(self._chosen)
            if rank > most:
                most, best = rank, list(self._chosen)
            missing = [name for name in self._catchers if not self._times[name]]
            if not missing:
                break
            cases = self._catchers[self._random.choice(missing)]
            worth = [
                self._gain(case) * (BACK if barred.get(case, 0) > step else 1) for case in cases
            ]
            (new,) = self._random.choices(cases, worth)
            self._take(new)
        return best

    def _alone(self, case: str) -> int:
        """Return how many faults a case catches that no other one does which is chosen."""
        return sum(self._times[name] == 1 for name in self._caught[case])

    def _gain(self, case: str) -> float:
        """Return how much a case is worth that is not chosen."""
        new = sum(not self._times[name] for name in self._caught[case])
        return float((new / self._price(case)) ** 2)

    def _price(self, case: str) -> int:
        """Return what a case costs beside the others that are chosen."""
        family = family_of(case)
        setup = self._costs.setups.get(family, 0)
        if setup and any(other != case and family_of(other) == family for other in self._chosen):
            setup = 0
        return max(self._costs.each[case] + setup, 1)

    def _make_room(self, new: str) -> Iterator[str]:
        """Take out what is least worth, and all that is worth nothing; yields it.

        What is ``new`` counts for more than it catches: others may be worth nothing beside it.
        """
        while self._chosen:
            losses = {
                case: self._alone(case) * (NEW if case == new else 1) / self._price(case)
                for case in self._chosen
            }
            least = min(losses, key=lambda case: losses[case] * self._random.uniform(*ABOUT))
            if losses[least] and self._costs.of(self._chosen) <= self._budget:
                return
            del self._chosen[least]
            self._times.subtract(self._caught[least])
            yield least

    def _take(self, case: str) -> None:
        if case not in self._chosen:
            self._chosen[case] = None
            self._times.update(self._caught[case])
