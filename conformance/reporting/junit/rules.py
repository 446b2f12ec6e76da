"""causes.xml: a test case for each rule that was tested, in one suite per chapter of rules.

A defect is one failure here, however many cases meet it: GitHub shows 50 annotations. A rule that
is broken in several ways is still one failure, because many readers show only the first of a case.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

from junit_xml import TestCase

from conformance.reporting.cause_counts import CauseCount, cause_lines, counted_causes
from conformance.reporting.junit.cases import case_element
from conformance.reporting.junit.fitting import MOST_BYTES, Row, is_failure, shortened
from conformance.reporting.junit.tree import Suite, write_suites
from conformance.reporting.summary import counted
from conformance.run.evidence import evidence_text
from conformance.run.verdict import BREACHES, CaseResult, Verdict
from conformance.sdo.rules import CHAPTERS, RULES, RULES_BY_ID, Rule, cited

# The suite of failures that name no rule: errors of the bench, tests of the user's own.
WITHOUT_RULE = "failures that name no rule"
MOST_WITHOUT_RULE = 100
MOST_OF_RULE = MOST_BYTES // len(RULES) // 2
MOST_OF_MESSAGE = 1_000
# What shows that a device keeps a rule.
KEPT = (Verdict.PASS, Verdict.INFO, Verdict.NON_STRICT)


def write_causes(
    path: Path,
    results: Sequence[CaseResult],
    properties: Mapping[str, str],
    *,
    timestamp: str,
    strict: bool = False,
    troubles: Sequence[str] = (),
) -> None:
    """Write the rules that were tested; the arguments are those of junit.xml."""
    kept: dict[str, int] = {}
    broken: dict[str, list[CaseResult]] = {}
    excused: dict[str, list[CaseResult]] = {}
    others: list[CaseResult] = []
    for result in results:
        name = result.rule_of_cause
        if is_failure(result, strict=strict):
            named = result.verdict in BREACHES and name in RULES_BY_ID
            (broken.setdefault(name, []) if named else others).append(result)
        elif result.verdict is Verdict.KNOWN_DEVIATION:
            excused.setdefault(name, []).append(result)
        elif result.verdict in KEPT:
            for tested in result.tested_rules:
                kept[tested] = kept.get(tested, 0) + 1
    alone = len({result.node_id for result in results}) == 1
    suites = []
    for chapter in CHAPTERS:
        cases = []
        for rule in chapter.rules:
            if rule.id in broken:
                cases.append(
                    _broken(rule, counted_causes(broken[rule.id], strict=strict), alone=alone)
                )
            elif rule.id in excused:
                cases.append(_excused(rule, excused[rule.id]))
            elif rule.id in kept:
                cases.append(_element(rule, f"{rule.sentence}\n{counted(kept[rule.id])} passed"))
        if cases:
            own = [rule.id for rule in chapter.rules if rule.id in broken]
            suites.append(Suite(chapter.title, cases, own))
    if others:
        suites.append(Suite(WITHOUT_RULE, _without_rule(others, strict=strict)))
    write_suites(path, suites, properties, timestamp=timestamp, troubles=troubles)


def _element(rule: Rule, output: str = "") -> TestCase:
    return TestCase(rule.id, classname=rule.id.partition(".")[0], stdout=output or None)


def _broken(rule: Rule, causes: Sequence[CauseCount], *, alone: bool) -> TestCase:
    """Return a rule that was broken: each cause, then the evidence of its first case."""
    told = cause_lines(causes, alone=alone)
    lines = [f"{rule.level}, {cited(rule.clause)}: {rule.sentence}", *told]
    for count in causes:
        lines += ["", evidence_text(count.failed[0])]
    case = _element(rule)
    message = shortened("; ".join(told), MOST_OF_MESSAGE)
    case.add_failure_info(message, shortened("\n".join(lines), MOST_OF_RULE), rule.id)
    return case


def _excused(rule: Rule, results: Sequence[CaseResult]) -> TestCase:
    reasons = ", ".join(dict.fromkeys(result.reason for result in results))
    case = _element(rule)
    told = f"{Verdict.KNOWN_DEVIATION.value} in {counted(len(results))}: {reasons}"
    case.add_skipped_info(shortened(told, MOST_OF_MESSAGE))
    return case


def _without_rule(results: Sequence[CaseResult], *, strict: bool) -> list[TestCase]:
    """Return a test case for each way of failing."""
    alike: dict[tuple[Verdict, str], list[CaseResult]] = {}
    for result in results:
        alike.setdefault((result.verdict, result.actual), []).append(result)
    return [
        case_element(Row(own[0].service, own[0].case_id, own), MOST_OF_RULE, strict=strict)
        for own in list(alike.values())[:MOST_WITHOUT_RULE]
    ]
