"""What failed once and not when it was tried again: a lost, repeated or swapped frame, perhaps.

An adapter that loses one frame in a thousand makes a right device fail a few cases; a device that
is wrong at times does the same. What fails at the same place again is the device's. What does not
fails no case, but such a run is not green either, unless the interface itself tells of frames that
it has lost. What comes more often than adapters lose frames is not excused any more.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import prod

from conformance.device.effort import ALIKE_TRIES
from conformance.sdo.rules import Cause

# Wherever it fails: an adapter that loses more than this share of the frames is of no use, and what
# comes by chance more seldom than that comes of something else.
LOST, CHANCE = 0.001, 0.0001
# How many cases of one cause are excused, and how many more for each thousand frames.
ALWAYS, PER_THOUSAND = 3, 2
MOST_SHOWN = 20


@dataclass(frozen=True, slots=True)
class Stumble:
    """How a try has failed: by which cause, behind how many frames."""

    cause: Cause
    frames: int


@dataclass(slots=True)
class Doubts:
    """The failures of one device that did not come again, in the order in which they were met.

    ``frames`` counts what went over its channel.
    """

    frames: int = 0
    met: list[str] = field(default_factory=list)
    _by_cause: Counter[str] = field(default_factory=Counter)

    def excuses(self, cause: str) -> bool:
        """Say whether a cause is still seldom enough to be that of the bus."""
        return self._by_cause[cause] < ALWAYS + PER_THOUSAND * self.frames / 1000

    def add(self, where: str, cause: str) -> None:
        """Take what failed once and not again."""
        self._by_cause[cause] += 1
        self.met.append(f"{where} ({cause})")

    def lines(self) -> list[str]:
        """Say what was met, all in all and one by one."""
        shown = [*self.met[:MOST_SHOWN]]
        if len(self.met) > MOST_SHOWN:
            shown.append(f"{len(self.met) - MOST_SHOWN} more, in the notes of their cases")
        total = f"{len(self.met)} in {self.frames} frames"
        return [f"failed once, but not when repeated, {total}:", *shown] if shown else []


def is_certain(tries: Sequence[Stumble]) -> bool:
    """Say whether what failed is the device's: it has failed so often that no losses explain it."""
    last = tries[-1]
    alike = [one for one in tries if one.cause == last.cause]
    chance = prod(min(one.frames * LOST, 1) for one in alike)
    return tries.count(last) >= ALIKE_TRIES or (len(alike) > 1 and chance < CHANCE)
