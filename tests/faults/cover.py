"""Which cases catch the most faults at the fewest requests."""

from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from random import Random
from typing import Self

# So many cases for each fault are in the order: a device may lack what the first of them needs.
CATCHERS = 4
# How often a choice within a budget is taken apart and made anew, and of how many cases it loses.
ROUNDS, MOST_TAKEN_OUT = 600, 12
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

        Where another one of a family is the dear one in each order, that is for all of them. A case
        without requests needs what the device does not declare.
        """
        found = cls({})
        for case in {case: None for each in counted for case in each}:
            sent = [each[case] for each in counted if each.get(case)]
            if sent:
                found.each[case] = min(sent)
        dear = [found.dear(each) for each in counted]
        for family in set.intersection(*map(set, dear)):
            first = {case for each in dear for case in each[family]}
            if len(first) == len(counted) == sum(len(each[family]) for each in dear):
                found.setups[family] = min(
                    each[case] - found.each[case]
                    for each in counted
                    for case in first
                    if each[case] > found.each[case]
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

    def __init__(self, caught: Mapping[str, Collection[str]], costs: Costs, budget: int) -> None:
        """Take what each case catches; nothing is chosen yet."""
        names = sorted({name for found in caught.values() for name in found})
        bits = {name: 1 << number for number, name in enumerate(names)}
        self._caught = {case: sum(bits[name] for name in caught[case]) for case in sorted(caught)}
        self._costs = costs
        self._budget = budget

    def best(self, begin: Iterable[str] = ()) -> list[str]:
        """Return the best of many: each is the last, less some cases and with another, filled up.

        ``begin`` is the first of them.
        """
        random = Random(1)
        best = self._filled_up(self._within(begin))
        cases = list(self._caught)
        for _ in range(ROUNDS):
            out = set(random.sample(best, random.randint(0, min(MOST_TAKEN_OUT, len(best)))))
            kept = [case for case in best if case not in out]
            other = self._filled_up(self._within([*kept, random.choice(cases)]), out)
            if self._rank(other) >= self._rank(best):
                best = other
        return best

    def _within(self, chosen: Iterable[str]) -> list[str]:
        """Leave out cases that catch least alone per request, until there is room for the rest."""
        kept = self._needed(chosen)
        while kept and self._costs.of(kept) > self._budget:

            def loss(case: str, kept: list[str] = kept) -> float:
                others = [each for each in kept if each != case]
                saved = self._costs.of(kept) - self._costs.of(others)
                return (self._caught[case] & ~self._found(others)).bit_count() / max(saved, 1)

            kept.remove(min(kept, key=loss))
        return kept

    def _rank(self, chosen: Collection[str]) -> tuple[int, int]:
        return self._found(chosen).bit_count(), -self._costs.of(chosen)

    def _found(self, chosen: Iterable[str]) -> int:
        found = 0
        for case in chosen:
            found |= self._caught[case]
        return found

    def _filled_up(self, chosen: list[str], without: Collection[str] = ()) -> list[str]:
        """Add what catches most that is not caught yet per request, as long as there is room."""
        found, left = self._found(chosen), self._budget - self._costs.of(chosen)
        families = {family_of(case) for case in chosen}
        rest = [case for case in self._caught if self._caught[case] & ~found]
        while rest:
            best, most, price = "", 0.0, 0
            kept = []
            for case in rest:
                new = (self._caught[case] & ~found).bit_count()
                if not new:
                    continue
                family = family_of(case)
                setup = 0 if family in families else self._costs.setups.get(family, 0)
                cost = self._costs.each[case] + setup
                if cost > left:
                    continue
                kept.append(case)
                worth = new / max(cost, 1) * (0.5 if case in without else 1)
                if worth > most:
                    best, most, price = case, worth, cost
            if not best:
                break
            rest = [case for case in kept if case != best]
            chosen.append(best)
            families.add(family_of(best))
            found |= self._caught[best]
            left -= price
        return chosen

    def _needed(self, chosen: Iterable[str]) -> list[str]:
        """Leave out cases whose faults the others catch as well, the dearest first."""
        kept = sorted(chosen, key=lambda case: self._costs.each[case], reverse=True)
        for case in list(kept):
            others = [each for each in kept if each != case]
            if not self._caught[case] & ~self._found(others):
                kept = others
        return kept
