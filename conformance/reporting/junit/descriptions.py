"""What was found in the description of a device, as a JUnit suite: a case for each rule."""

from collections.abc import Collection, Sequence

from junit_xml import TestCase

from conformance.eds.findings import FindingRecord, Severity
from conformance.eds.rules import RULES
from conformance.reporting.junit.fitting import shortened
from conformance.reporting.junit.tree import Suite

FAILING = (Severity.ERROR,)
FAILING_IF_STRICT = (Severity.ERROR, Severity.WARNING)
# Of a rule that a file breaks in each line.
MOST_OF_RULE = 20_000


def whole_suite(name: str, found: Sequence[FindingRecord], failing: Collection[Severity]) -> Suite:
    """Return the suite of a file that was checked, with all rules."""
    cases = [_case(rule.id, rule.severity in failing, found) for rule in RULES]
    broken = [case.name for case in cases if case.is_failure()]
    return Suite(f"description {name}", cases, broken)


def suite_of_run(name: str, found: Sequence[FindingRecord]) -> list[Suite]:
    """Return the suite of what was found before a run, of the rules that are broken.

    A run judges the device, so none of them is a failure.
    """
    broken = dict.fromkeys(record["rule"] for record in found)
    cases = [_case(rule_id, fails=False, found=found) for rule_id in broken]
    return [Suite(f"description {name}", cases)] if cases else []


def _case(rule_id: str, fails: bool, found: Sequence[FindingRecord]) -> TestCase:
    lines = [record["text"] for record in found if record["rule"] == rule_id]
    output = shortened("\n".join(lines), MOST_OF_RULE)
    case = TestCase(
        rule_id,
        classname="description",
        stdout=output if lines and not fails else None,
        elapsed_sec=1e-6,
    )
    if lines and fails:
        case.add_failure_info(lines[0], output, rule_id)
    return case
