"""A comparison as lines for a terminal."""

from collections.abc import Iterator, Sequence

from conformance.reporting.cause_counts import CauseCount, cause_lines
from conformance.reporting.comparison.cases import Group
from conformance.reporting.comparison.comparison import Comparison
from conformance.reporting.comparison.differences import Difference
from conformance.reporting.comparison.sides import Side
from conformance.reporting.summary import counted

# Lines under one heading.
MOST_LINES = 10


def comparison_lines(comparison: Comparison) -> Iterator[str]:
    """Yield what has changed, and in the last line whether anything got worse."""
    for name, side in (("old", comparison.old), ("new", comparison.new)):
        yield f"{name}: {side.folder} ({_begun(side)}): {side.counts}"
        if side.broken_off:
            yield f"     {side.broken_off}"
    yield from _told("devices", _differences(comparison.devices))
    yield from _told("suite and options", _differences(comparison.options))
    for title, causes in (
        ("new causes", comparison.new_causes),
        ("causes that are gone", comparison.gone_causes),
        ("causes whose cases were not tested again", comparison.untested_causes),
    ):
        yield from _causes(title, causes, alone=comparison.alone)
    for section in comparison.sections:
        title = f"{section.title} ({counted(section.number)})"
        yield from _told(title, [_group(group) for group in section.groups])
    yield from _told("the device chooses otherwise", _differences(comparison.profile))
    slower = [
        f"{each.kind}: half within {each.new[0]:.1f} ms (before {each.old[0]:.1f}), "
        f"95 % within {each.new[1]:.1f} ms (before {each.old[1]:.1f})"
        for each in comparison.slower
    ]
    yield from _told("answered more slowly", slower)
    yield comparison.sentence


def _begun(side: Side) -> str:
    nodes = ", ".join(map(str, side.node_ids))
    name = "node" if len(side.node_ids) == 1 else "nodes"
    return f"{name} {nodes}, {side.run.about['begun'][:19]}, suite {side.run.about['suite']}"


def _told(title: str, lines: Sequence[str]) -> Iterator[str]:
    if lines:
        yield f"{title}:"
        yield from (f"  {line}" for line in lines[:MOST_LINES])
        if len(lines) > MOST_LINES:
            yield f"  and {len(lines) - MOST_LINES} more, which --page shows"


def _differences(differences: Sequence[Difference]) -> list[str]:
    return [f"{each.what}: {each.old} -> {each.new}" for each in differences]


def _group(group: Group) -> str:
    first = group.cases[0].latest.case_id
    if len(group.cases) == 1:
        return f"{first}: {group.reason}"
    return f"{group.reason} ({counted(len(group.cases))}; first {first})"


def _causes(title: str, causes: Sequence[CauseCount], *, alone: bool) -> Iterator[str]:
    yield from _told(f"{title} ({len(causes)})", cause_lines(causes, alone=alone))
