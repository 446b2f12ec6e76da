"""The rules as a text, each with the cases that test it or the reason why none does."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence

from conformance.eds.rules import RULES as EDS_RULES
from conformance.reporting.official_steps import OFFICIAL_STEPS, OfficialStep
from conformance.run.case import CaseInfo
from conformance.run.case_files import case_files, cases_in
from conformance.sdo.abort_codes import AbortCode, describe_code
from conformance.sdo.rules import CHAPTERS, RULES, RULES_BY_ID, Rule, UnknownRule, rule_of
from conformance.sdo.rules.accepted import ANY, GENERAL

_STEP = re.compile(r"([A-Za-z]+) +0*(\d+)")


def scripted_cases() -> list[CaseInfo]:
    """Return what the decorators of the suite's own cases say, file by file."""
    return [info for path in case_files() for info in cases_in(path)]


def cases_of_rules(cases: Iterable[CaseInfo]) -> dict[str, list[str]]:
    """Return for each rule, by its id, the ids of the cases that test it."""
    found: dict[str, list[str]] = {rule.id: [] for rule in RULES}
    for case in cases:
        for rule in case.cites:
            found[rule.id].append(case.rule.id)
    return found


def rule_lines(names: Sequence[str] = ()) -> Iterator[str]:
    """Yield the lines of ``conformance rules``: all rules, or those of these ids, cases and steps.

    A step is one of the official conformance test, such as "SDO 17". Raises UnknownRule.
    """
    cases = scripted_cases()
    tested = cases_of_rules(cases)
    of_files = [rule for rule in EDS_RULES if rule.id in names or not names]
    named = [name for name in names if not any(name == rule.id for rule in of_files)]
    chosen = [rule for name in named for rule in _named(name, cases)]
    chosen = chosen if names else list(RULES)
    for chapter in CHAPTERS:
        rules = [rule for rule in chapter.rules if rule in chosen]
        if rules:
            yield f"{chapter.title}:"
        for rule in rules:
            yield from _lines(rule, tested[rule.id])
    if of_files:
        yield "descriptions of devices:"
    for of_file in of_files:
        yield f"  {of_file.id}  {of_file.severity}  {of_file.clause}"
        yield f"      {of_file.sentence}"
        yield "      checked by: conformance eds"
    if not names:
        yield _totals(tested)


def _named(name: str, cases: Iterable[CaseInfo]) -> Iterable[Rule]:
    """Return the rule of an id, or those that a case, or the cases of an official step, test.

    A cause is named by the rule that is broken, or by a case.
    """
    step = next((step for step in OFFICIAL_STEPS if _is_step(step, name)), None)
    if step is None and _STEP.fullmatch(name):
        known = ", ".join(step.name for step in OFFICIAL_STEPS)
        raise UnknownRule(f"no case covers a step {name!r}; the steps are {known}")
    if step is None:
        stem = name.partition("[")[0]
        case = next((case for case in cases if case.rule.id == stem), None)
        return [rule_of(name)] if case is None or name in RULES_BY_ID else case.cites
    return [rule for case in cases if case.rule.id in step.cases for rule in case.cites]


def _is_step(step: OfficialStep, name: str) -> bool:
    """Say whether a name is that of a step, with or without leading zeros."""
    written = _STEP.fullmatch(name)
    return written is not None and step.name == f"{written[1].upper()} {int(written[2]):02}"


def _lines(rule: Rule, cases: Sequence[str]) -> Iterator[str]:
    yield f"  {rule.id}  {rule.level}  {rule.clause}"
    yield f"      {rule.sentence}"
    for name, text in answers(rule):
        yield f"      {name}: {text}"
    if cases:
        yield f"      tested by: {', '.join(cases)}"
        if steps := official_steps(cases):
            yield f"      official test: {', '.join(steps)}"
    else:
        yield f"      not tested: {untested(rule)}"


def answers(rule: Rule) -> list[tuple[str, str]]:
    """Return what a rule says of answers, each with its name."""
    told = {
        "accepted": rule.reaction,
        "abort codes": _words(rule.codes) if rule.codes else "",
        "tolerated": _tolerated(rule),
        "open": rule.open,
    }
    return [(name, text) for name, text in told.items() if text]


def official_steps(cases: Sequence[str]) -> list[str]:
    """Return the names of the steps of the official test that these cases cover."""
    return [step.name for step in OFFICIAL_STEPS if not {*step.cases}.isdisjoint(cases)]


def untested(rule: Rule) -> str:
    """Say why no case tests a rule."""
    return rule.untestable or "there is no case yet"


def _words(codes: Sequence[AbortCode]) -> str:
    if codes == ANY:
        return "any"
    others = [code for code in AbortCode if code not in codes]
    if len(others) < len(codes):
        return f"any but {', '.join(map(describe_code, others))}"
    return ", ".join(map(describe_code, codes))


def _tolerated(rule: Rule) -> str:
    """Say which other codes are accepted; of a rule without aborts none are."""
    if rule.tolerated == ANY:
        return "any other"
    aborts = rule.codes or rule.tolerated != GENERAL
    return _words([code for code in rule.tolerated if aborts and code not in rule.codes])


def _totals(tested: Mapping[str, Sequence[str]]) -> str:
    with_cases = sum(bool(cases) for cases in tested.values())
    cases = len({case for cases in tested.values() for case in cases})
    reasons = sum(bool(rule.untestable) for rule in RULES)
    return (
        f"{len(RULES)} rules: {with_cases} tested by {cases} cases, "
        f"{reasons} not testable, {len(RULES) - with_cases - reasons} without a case; "
        f"{len(EDS_RULES)} rules for descriptions of devices"
    )
