"""How many requests a run takes at most, whatever the objects of a device are.

Of very many objects the further ones are left out for it, and of long values those that a case
would come to last. Where that does not do, the last cases of the run are left out as well. A
thorough run leaves out nothing.
"""

from collections import Counter
from math import inf

from conformance.plugin.items import CaseFunction, judges_run
from conformance.plugin.options import Options
from conformance.reporting.workload import work_of

# A request counts when it is answered.
MOST = 60_000
# What the cases need at most that come behind those on further objects: see ``items.ordered``.
BEHIND = 7_000
# By how much the last cases may exceed what they take on the built-in device.
END = 400
# What a case may take on all objects together, if these are not further ones.
MOST_OF_CASE = 1_200
WHY = f"a run takes {MOST:,} requests at most: --sdo-thorough runs what takes more"
WHY_CASE = (
    f"a case takes {MOST_OF_CASE:,} requests at most on all objects, and they have long values: "
    "--sdo-thorough runs it on all of them"
)
WHYS = WHY, WHY_CASE


def allowed(options: Options) -> float:
    """Return how many requests a device has to answer in a process at most."""
    return inf if options.thorough else MOST / options.share.parts


class RequestsOfRun:
    """Which cases of a process are left out for what they take, and for what others took."""

    def __init__(self, options: Options) -> None:
        """Take how many processes share a device."""
        self._most = allowed(options)
        self._part = self._most / MOST
        self._taken: Counter[tuple[int, str]] = Counter()

    def take(self, item: CaseFunction, answers: int) -> None:
        """Count what a case on a listed object has taken."""
        if item.case.is_of_listed and not item.further:
            self._taken[_family(item)] += answers

    def why_not(self, item: CaseFunction, answers: int) -> str:
        """Say why a case is not to be run behind so many answers of its device; empty if it is.

        What is due to put values back counts as answered.
        """
        if item.further:
            return WHY if answers > self._most - BEHIND * self._part else ""
        if self._taken[_family(item)] > MOST_OF_CASE * self._part:
            return WHY_CASE
        last = self._most - END * self._part
        return WHY if answers + work_of(item.nodeid).answers > last and not judges_run(item) else ""


def _family(item: CaseFunction) -> tuple[int, str]:
    return item.node_id, item.case.rule.id
