"""Mutants of a small class."""

import example_source
import pytest
from example_source import Counter
from source_mutants import Mutant, mutants_of

NAMES = [
    "Counter.limit: super().limit() + 2 -> super().limit() - 2",
    "Counter.limit: 2 -> 3",
    "Counter.limit: 2 -> 1",
    "Counter.add: if number > 0 and (not self.count): -> if True:",
    "Counter.add: if number > 0 and (not self.count): -> if False:",
    "Counter.add: return [self.count] -> return []",
    "Counter.add: number > 0 and (not self.count) -> number > 0 or not self.count",
    "Counter.add: self.count = number -> pass",
    "Counter.add: number > 0 -> number >= 0",
    "Counter.add: number > 0 -> number <= 0",
    "Counter.add: not self.count -> self.count",
    "Counter.add: 0 -> 1",
    "Counter.add: 0 -> -1",
]
FOUND = {mutant.name: mutant for mutant in mutants_of([example_source], "__init__".__eq__)}


def seen() -> list[object]:
    """Return what a counter does."""
    counter = Counter()
    counts = [counter.add(number) for number in (0, 2, 1, -1)]
    return [counter.limit(), counts, Counter().add(-1), Counter().add(1)]


def test_each_place_is_changed() -> None:
    assert [name for name in FOUND if name.startswith("Counter.")] == NAMES


def test_constants_of_truth() -> None:
    assert "Base.limit: 1 -> 2" in FOUND


@pytest.mark.parametrize("name", NAMES)
def test_a_mutant_lasts_as_long_as_it_is_installed(name: str) -> None:
    right = seen()
    with FOUND[name].installed():
        changed = seen()
    assert seen() == right
    assert (changed != right) is (name not in HIDDEN)


# A counter that is 0 cannot be told from one that was set to 0.
HIDDEN = ("Counter.add: number > 0 -> number >= 0", "Counter.add: 0 -> -1")


def test_names_are_told_apart() -> None:
    assert all(isinstance(mutant, Mutant) for mutant in FOUND.values())
    assert len(FOUND) == len(mutants_of([example_source], "__init__".__eq__))
