"""What something costs, beside the least that it can cost, as a row of a table."""

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median

HEADING = f"{'':38} {'s':>8} {'x floor':>8} {'cpu s':>8} {'x floor':>8}  {'at most':14} rate"


@dataclass(frozen=True, slots=True)
class Cost:
    """Seconds by the clock, and seconds that were computed, by all threads and processes."""

    wall: float
    cpu: float


@dataclass(frozen=True, slots=True)
class Row:
    """What it is, what it costs, and the ``floor``, where there is one.

    ``bound`` says how much it may be in words; it is ``kept`` or not. ``rate`` is for the reader.
    """

    name: str
    cost: Cost
    floor: Cost | None = None
    bound: str = ""
    kept: bool = True
    rate: str = ""

    def __str__(self) -> str:
        cost, floor = self.cost, self.floor
        wall = f"{cost.wall / floor.wall:8.2f}" if floor and floor.wall else f"{'':8}"
        cpu = f"{cost.cpu / floor.cpu:8.2f}" if floor and floor.cpu else f"{'':8}"
        bound = self.bound if self.kept else f"{self.bound} !"
        found = f"{self.name:38} {cost.wall:8.3f} {wall} {cost.cpu:8.3f} {cpu}"
        return f"{found}  {bound:14} {self.rate}".rstrip()


def computed() -> float:
    """Return the seconds that this process and those that have ended behind it computed."""
    ended = os.times()
    return time.process_time() + ended.children_user + ended.children_system


def cost(task: Callable[[], object]) -> Cost:
    """Return what a task costs."""
    wall, cpu = time.perf_counter(), computed()
    task()
    return Cost(time.perf_counter() - wall, computed() - cpu)


def typical(costs: Sequence[Cost]) -> Cost:
    """Return the median of each."""
    return Cost(median(each.wall for each in costs), median(each.cpu for each in costs))


def best(costs: Sequence[Cost]) -> Cost:
    """Return the least of each."""
    return Cost(min(each.wall for each in costs), min(each.cpu for each in costs))
