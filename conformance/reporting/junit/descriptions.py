"""What was found in the description of a device, as a JUnit suite: a case for each rule."""

from collections.abc import Collection

from junit_xml import TestCase

from conformance.eds.findings import Severity
from conformance.eds.reading import DeviceFile
from conformance.eds.rules import RULES
from conformance.reporting.junit.tree import Suite

FAILING = (Severity.ERROR,)
FAILING_IF_STRICT = (Severity.ERROR, Severity.WARNING)
# In a run the device is judged: its description fails nothing.
NONE_FAILING: tuple[Severity, ...] = ()


def description_suite(file: DeviceFile, failing: Collection[Severity]) -> Suite:
    """Return the suite of a file; findings that fail nothing are the output of passed cases."""
    cases = []
    broken = []
    for rule in RULES:
        lines = [str(finding) for finding in file.findings if finding.rule is rule]
        fails = bool(lines) and rule.severity in failing
        output = "\n".join(lines)
        case = TestCase(
            rule.id,
            classname="description",
            stdout=None if fails or not lines else output,
            elapsed_sec=1e-6,
        )
        if fails:
            case.add_failure_info(lines[0], output, rule.id)
            broken.append(rule.id)
        cases.append(case)
    return Suite(f"description {file.path.name}", cases, broken)
