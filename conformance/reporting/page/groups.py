"""The cases of a run in groups: by state and stimulus, rule, clause, and official step."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

from conformance.model_cases.server_states import STATES
from conformance.reporting.official_steps import OFFICIAL_STEPS
from conformance.reporting.page.cases import Case
from conformance.run.verdict import FAILED, Verdict
from conformance.sdo.rules import RULES_BY_ID, Rule

PASSED = (Verdict.PASS, Verdict.INFO)


@dataclass
class Group:
    """Cases that belong together: to a rule, a clause or a step of the official test."""

    name: str
    what: str
    cases: list[Case] = field(default_factory=list)
    # A rule is broken where a cause is about it; else a group fails where a case of it does.
    rule: Rule | None = None

    @cached_property
    def verdicts(self) -> Counter[Verdict]:
        """How many cases have each verdict."""
        return Counter(case.result.verdict for case in self.cases)

    @property
    def passed(self) -> int:
        """How many passed."""
        return sum(self.verdicts[each] for each in PASSED)

    @property
    def failed(self) -> int:
        """How many failed; of a rule, how many have broken it."""
        if self.rule is None:
            return sum(self.verdicts[each] for each in FAILED)
        failed = (case.result for case in self.cases if case.result.verdict in FAILED)
        return sum(self.rule.id in result.broken_rules for result in failed)

    @property
    def others(self) -> int:
        """How many did neither."""
        return len(self.cases) - self.passed - self.failed


@dataclass(frozen=True, slots=True)
class Map:
    """The cases of the matrix: a column for each state, a row for each stimulus."""

    states: list[str]
    rows: list[tuple[str, list[Case | None]]]


def matrix_map(cases: Iterable[Case]) -> Map | None:
    """The map of states and stimuli; None where no case of the matrix was selected."""
    fields: dict[tuple[str, str], Case] = {}
    for case in cases:
        if case.result.state:
            fields.setdefault((case.result.state, case.result.stimulus), case)
    states = sorted({state for state, _ in fields}, key=_in_a_transfer)
    stimuli = sorted({stimulus for _, stimulus in fields})
    rows = [(each, [fields.get((state, each)) for state in states]) for each in stimuli]
    return Map(states, rows) if fields else None


def by_rule(cases: Iterable[Case]) -> list[Group]:
    """The cases of each rule that was tested."""
    groups: dict[str, Group] = {}
    for case in cases:
        tested = case.result.tested_rules | case.result.broken_rules
        for name in tested & RULES_BY_ID.keys():
            rule = RULES_BY_ID[name]
            group = groups.setdefault(name, Group(name, rule.sentence, rule=rule))
            group.cases.append(case)
    return [groups[name] for name in RULES_BY_ID if name in groups]


def by_clause(cases: Iterable[Case]) -> list[Group]:
    """The cases of each clause."""
    groups: dict[str, Group] = {}
    for case in cases:
        clause = case.result.clause
        groups.setdefault(clause, Group(clause, "")).cases.append(case)
    return [groups[clause] for clause in sorted(groups, key=_in_numbers)]


def by_step(cases: Iterable[Case]) -> list[Group]:
    """The cases that do what a step of the official test does, and more."""
    groups = [Group(step.name, step.what) for step in OFFICIAL_STEPS]
    of_case: dict[str, list[Group]] = {}  # that of each device has the same id
    for case in cases:
        case_id = case.result.case_id
        if case_id not in of_case:
            of_case[case_id] = [
                group
                for group, step in zip(groups, OFFICIAL_STEPS, strict=True)
                if case_id.startswith(step.stems)
            ]
        for group in of_case[case_id]:
            group.cases.append(case)
    return groups


def _in_a_transfer(state: str) -> tuple[int, str]:
    """Return a key that puts states into the order in which transfers pass through them."""
    known = list(STATES)
    return (known.index(state) if state in known else len(known), state)


def _in_numbers(clause: str) -> list[tuple[bool, int, str]]:
    """Return a key that puts 7.2.4.3.10 behind 7.2.4.3.9."""
    parts = clause.split(".")
    return [(not part.isdigit(), int(part) if part.isdigit() else 0, part) for part in parts]
