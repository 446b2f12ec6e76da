"""The XML of a JUnit file, as the schema of Jenkins' xUnit plugin allows it.

The junit-xml package builds the tree. The schema knows less than the package writes: no
``disabled`` attributes, no properties on a case; what has no place there goes into the properties
of the suite or the output of the case.
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from junit_xml import TestCase, TestSuite

from conformance.reporting.junit.fitting import shortened
from conformance.reporting.text import xml_text

TITLE = "CANopen SDO conformance"
# The suite of what befell the run itself.
RUN = "the run"
# Bytes of a property, which stands in every suite: with an EDS all objects may be writable.
MOST_OF_PROPERTY = 8_000
_SUITE_ATTRIBUTES = {"name", "tests", "failures", "errors", "skipped", "time", "timestamp"}
_CASE_ATTRIBUTES = {"name", "classname", "time"}


@dataclass(frozen=True, slots=True)
class Suite:
    """Test cases under one name; ``rules`` are the ids of those that its failures break."""

    name: str
    cases: Sequence[TestCase]
    rules: Sequence[str] = ()


def write_suites(
    path: Path,
    suites: Sequence[Suite],
    properties: Mapping[str, str],
    *,
    timestamp: str,
    troubles: Sequence[str] = (),
) -> None:
    """Write a file; ``properties`` stand in every suite.

    ``troubles`` of the run that no result shows are errors in a suite of their own: a run that was
    broken off must not look like one that has passed.
    """
    root = ElementTree.Element("testsuites", name=TITLE)
    if troubles:
        errors = [_trouble(trouble, number) for number, trouble in enumerate(troubles, start=1)]
        suites = [*suites, Suite(RUN, errors)]
    seconds = 0.0
    for suite in suites:
        own = {**properties, "broken-rules": ", ".join(suite.rules)} if suite.rules else properties
        clean = {
            xml_text(name): shortened(xml_text(value), MOST_OF_PROPERTY)
            for name, value in own.items()
        }
        element = TestSuite(
            xml_text(suite.name), suite.cases, timestamp=timestamp, properties=clean
        ).build_xml_doc()
        _keep(element, _SUITE_ATTRIBUTES)
        own_seconds = sum(case.elapsed_sec or 0.0 for case in suite.cases)
        seconds += own_seconds
        element.set("time", f"{own_seconds:.6f}")
        for case in element.iter("testcase"):
            _keep(case, _CASE_ATTRIBUTES)
        root.append(element)
    for name in ("tests", "failures", "errors"):
        root.set(name, str(sum(int(suite.get(name, "0")) for suite in root)))
    root.set("time", f"{seconds:.6f}")
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _trouble(text: str, number: int) -> TestCase:
    case = TestCase(f"trouble-{number}", classname=RUN, elapsed_sec=1e-6)
    case.add_error_info(xml_text(text), xml_text(text), "bench error")
    return case


def _keep(element: ElementTree.Element, names: set[str]) -> None:
    for name in list(element.keys()):
        if name not in names:
            del element.attrib[name]
