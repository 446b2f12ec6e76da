"""The order of cases where several devices are tested at once.

Each device has the same order, and all of them begin together: they would come to their longest
case at the same time, wait for 9,000 answers each while nothing is computed, and then compute at
the same time again.
"""

from collections import defaultdict
from collections.abc import Callable, Sequence
from itertools import groupby
from operator import itemgetter

import pytest

from conformance.plugin.items import CaseFunction, judges_run
from conformance.plugin.state import case_of
from conformance.plugin.worth import table
from conformance.run.risks import Kind

# A case of more requests than this may come later.
LONG = 1000


def spread(items: Sequence[pytest.Item], node_ids: Sequence[int]) -> list[pytest.Item]:
    """Put the long cases behind more ordinary ones, the farther back a device is among all.

    ``items`` are in order, device by device.
    """
    found: list[pytest.Item] = []
    for node_id, own in groupby(items, key=_node_id):
        part = node_ids.index(node_id) / len(node_ids) if node_id in node_ids else 0.0
        found += _behind(list(own), part)
    return found


def mixed(items: Sequence[pytest.Item], seconds: Callable[[str], float]) -> list[pytest.Item]:
    """Mix the cases of devices as they come where all go on at the same pace.

    The cases of each keep their order. ``seconds`` says how long one takes, by its name.
    """
    taken: defaultdict[int, float] = defaultdict(float)
    ends: list[float] = []
    for item in items:
        taken[_node_id(item)] += seconds(item.nodeid)
        ends.append(taken[_node_id(item)])
    return [item for _, item in sorted(zip(ends, items, strict=True), key=itemgetter(0))]


def _node_id(item: pytest.Item) -> int:
    return item.node_id if isinstance(item, CaseFunction) else 0


def _behind(items: list[pytest.Item], part: float) -> list[pytest.Item]:
    """Put the long ones behind a part of the ordinary cases that follow them."""
    long = [item for item in items if _is_ordinary(item) and _is_long(item)]
    if not long:
        return items
    first = items.index(long[0])
    rest = [item for item in items if item not in long]
    following = sum(map(_is_ordinary, rest[first:]))
    place = first + int(part * following)
    return [*rest[:place], *long, *rest[place:]]


def _is_ordinary(item: pytest.Item) -> bool:
    """Say whether a case is none of those that have to be the last."""
    if not isinstance(item, CaseFunction) or judges_run(item):
        return False
    return item.risk is None or item.risk.kind is Kind.ORDINARY


def _is_long(item: pytest.Item) -> bool:
    worth = table().get(case_of(item).case_id)
    return worth is not None and worth.requests > LONG
