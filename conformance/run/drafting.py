"""A draft of known deviations from the results of a run: an entry for each cause."""

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field

from conformance.device.known_deviations import NO_REASON, KnownDeviation
from conformance.run.verdict import CaseResult, Verdict
from conformance.sdo.rules import Cause

# The parts of an id, each with its separator.
_PARTS = re.compile(r"[^.\-\[]+[.\-\[]?|[.\-\[]")


@dataclass(slots=True)
class _Group:
    """The cases of one cause: those that failed, and all that have met it.

    ``rule`` is that of the cause, ``broken`` the one that the first case puts in its own words.
    """

    rule: str | None
    broken: str | None
    failed: set[str] = field(default_factory=set)
    met: set[str] = field(default_factory=set)


def draft(
    results: Sequence[CaseResult],
    known: Iterable[KnownDeviation] = (),
    *,
    strict: bool,
    beside: Collection[str] = (),
) -> list[KnownDeviation]:
    """Return the list that would excuse each failure of a run; what is ``known`` and met is kept.

    A cause that one case has met is listed with that case, one of several cases by a glob with the
    rule or, where their ids have nothing in common, by the rule alone. A case that broke different
    rules on different devices is listed with each. ``beside`` are rules that the device broke
    outside of all cases. Cases that were not judged are not drafted.
    """
    failing = {Verdict.FAIL} | ({Verdict.NON_STRICT} if strict else set())
    kept = [entry for entry in known if _is_met(entry, results, beside)]
    groups: dict[Cause | str, _Group] = {}
    for result in results:
        if result.verdict in failing:
            broken = result.broken_rule or None
            rule = result.rule_of_cause or broken
            # A test of the user's own that raised has no cause.
            group = groups.setdefault(result.cause or result.case_id, _Group(rule, broken))
            group.failed.add(result.case_id)
    for result in results:
        kept_away = [result.cause] if result.verdict is Verdict.NOT_TESTABLE else []
        for cause in [*kept_away, *result.met]:
            if cause is not None and cause in groups:
                groups[cause].met.add(result.case_id)
    drafted = [KnownDeviation(None, NO_REASON, rule) for rule in beside]
    drafted += [_entry(group) for group in groups.values()]
    return _without_doubles(kept, drafted)


def _is_met(entry: KnownDeviation, results: Iterable[CaseResult], beside: Collection[str]) -> bool:
    if entry.case is None and entry.rule in beside:
        return True
    return any(
        result.verdict is Verdict.KNOWN_DEVIATION
        and entry.excuses(result.case_id, result.broken_rules, result.tested_rules)
        for result in results
    )


def _entry(group: _Group) -> KnownDeviation:
    cases = sorted(group.failed | group.met)
    if len(cases) == 1:
        return KnownDeviation(cases[0], NO_REASON, group.broken)
    common = _in_common(cases)
    return KnownDeviation(f"{common}*" if common else None, NO_REASON, group.rule)


def _in_common(cases: Sequence[str]) -> str:
    """Return the common beginning of all ids, in whole words."""
    first, last = _PARTS.findall(cases[0]), _PARTS.findall(cases[-1])
    same = 0
    while same < min(len(first), len(last)) and first[same] == last[same]:
        same += 1
    return "".join(first[:same])


def _without_doubles(
    kept: Iterable[KnownDeviation], drafted: Sequence[KnownDeviation]
) -> list[KnownDeviation]:
    """Leave out failures that a rule alone excuses, and listed ones."""
    found = {entry.key: entry for entry in kept}
    alone = {entry.rule for entry in (*found.values(), *drafted) if entry.case is None}
    for entry in drafted:
        if entry.case is not None and entry.rule in alone:
            continue
        found.setdefault(entry.key, entry)
    return list(found.values())
