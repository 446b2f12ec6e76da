"""The XML of a JUnit file, as the schema of Jenkins' xUnit plugin allows it.

The junit-xml package builds the tree. It asks for a ``disabled`` attribute, exponents in times and
characters that XML does not have to be put right behind it. Cases have no properties in the schema:
what these would say stands in those of the suite or in the output of the case.
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
        short = {name: shortened(value, MOST_OF_PROPERTY) for name, value in own.items()}
        element = TestSuite(
            suite.name, suite.cases, timestamp=timestamp, properties=short
        ).build_xml_doc()
        del element.attrib["disabled"]
        own_seconds = sum(case.elapsed_sec or 0.0 for case in suite.cases)
        seconds += own_seconds
        element.set("time", f"{own_seconds:.6f}")
        root.append(element)
    for name in ("tests", "failures", "errors"):
        root.set(name, str(sum(int(suite.get(name, "0")) for suite in root)))
    root.set("time", f"{seconds:.6f}")
    for element in root.iter():
        element.text = xml_text(element.text or "")
        element.attrib = {xml_text(name): xml_text(text) for name, text in element.items()}
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _trouble(text: str, number: int) -> TestCase:
    case = TestCase(f"trouble-{number}", classname=RUN, elapsed_sec=1e-6)
    case.add_error_info(text, text, "bench error")
    return case
