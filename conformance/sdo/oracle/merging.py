"""Several ways by which a server may have come to the same place are one from then on."""

from collections.abc import Iterable
from itertools import chain

from conformance.sdo.oracle.branch import Branch, Freedom, State


def merged(branches: Iterable[Branch]) -> list[Branch]:
    """Merge branches that are the same.

    Of two reasons that lead to the same, the one that comes first is kept; of two choices in one
    matter neither is.
    """
    by_due: dict[int, list[Branch]] = {}
    # Where in the list of its answer each is: those with a state of one kind and the same backlog.
    places: dict[tuple[int, type[State], tuple[bytes, ...]], list[int]] = {}
    for branch in branches:
        kept = by_due.setdefault(id(branch.due), [])
        alike = places.setdefault((id(branch.due), type(branch.state), branch.backlog), [])
        for position in alike:
            other = kept[position]
            if _same(branch, other):
                kept[position] = other.having(_undisputed(other, branch))
                break
        else:
            alike.append(len(kept))
            kept.append(branch)
    return list(chain.from_iterable(by_due.values()))


def _same(one: Branch, other: Branch) -> bool:
    """Say whether two branches with the same answer due differ at most in how they came about."""
    return (
        one.state == other.state
        and one.memory == other.memory
        and one.findings == other.findings
        and one.backlog == other.backlog
    )


def _undisputed(one: Branch, other: Branch) -> frozenset[Freedom]:
    """Return the choices of one branch of which another does not say otherwise."""
    disputed = {freedom.topic for freedom in one.freedoms ^ other.freedoms}
    disputed &= {freedom.topic for freedom in other.freedoms}
    return frozenset(
        freedom
        for freedom in one.freedoms
        if freedom in other.freedoms or freedom.topic not in disputed
    )
