"""junit.xml in the strict form that Jenkins reads: one suite per service of the protocol.

The junit-xml package builds the tree. The schema of Jenkins' xUnit plugin knows less than the
package writes: no ``disabled`` attributes, no properties on a case; what has no place there goes
into the properties of the suite or the output of the case.
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from pathlib import Path

from junit_xml import TestCase, TestSuite

from conformance.reporting.text import xml_text
from conformance.run.evidence import evidence_text
from conformance.run.verdict import CaseResult, Verdict

# The suite of what befell the run itself.
RUN = "the run"
_SUITE_ATTRIBUTES = {"name", "tests", "failures", "errors", "skipped", "time", "timestamp"}
_CASE_ATTRIBUTES = {"name", "classname", "time"}


def write_junit(
    path: Path,
    results: Sequence[CaseResult],
    properties: Mapping[str, str],
    *,
    timestamp: str,
    strict: bool = False,
    troubles: Sequence[str] = (),
) -> None:
    """Write the results; ``properties`` describe device and run and stand in every suite.

    ``strict`` counts what is not strictly conformant as failed, as the run did. ``troubles`` of the
    run that no result shows are errors in a suite of their own: a run that was broken off must not
    look like one that has passed.
    """
    root = ElementTree.Element("testsuites", name="CANopen SDO conformance")
    clean = {xml_text(name): xml_text(value) for name, value in properties.items()}
    suites = {
        service: [result for result in results if result.service == service]
        for service in dict.fromkeys(result.service for result in results)
    }
    cases = {name: [_case(result, strict) for result in own] for name, own in suites.items()}
    if troubles:
        cases[RUN] = [_trouble(trouble, number) for number, trouble in enumerate(troubles, start=1)]
    for name, own in cases.items():
        suite = TestSuite(xml_text(name), own, timestamp=timestamp, properties=clean)
        element = suite.build_xml_doc()
        _keep(element, _SUITE_ATTRIBUTES)
        seconds = sum(result.duration for result in suites.get(name, []))
        element.set("time", f"{seconds:.6f}")
        for case in element.iter("testcase"):
            _keep(case, _CASE_ATTRIBUTES)
        root.append(element)
    for name in ("tests", "failures", "errors"):
        root.set(name, str(sum(int(suite.get(name, "0")) for suite in root)))
    root.set("time", f"{sum(result.duration for result in results):.6f}")
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _trouble(text: str, number: int) -> TestCase:
    case = TestCase(f"trouble-{number}", classname=RUN, elapsed_sec=1e-6)
    case.add_error_info(xml_text(text), xml_text(text), "bench error")
    return case


def _case(result: CaseResult, strict: bool) -> TestCase:
    text = "" if result.verdict is Verdict.NOT_RUN else xml_text(evidence_text(result))
    case = TestCase(
        xml_text(result.case_id),
        classname=xml_text(f"node-{result.node_id}.{result.service}"),
        elapsed_sec=max(result.duration, 1e-6),
        stdout=text or None,
    )
    message = xml_text(result.actual) or result.verdict.value
    match result.verdict:
        case Verdict.FAIL | Verdict.STALE:
            case.add_failure_info(message, text, result.verdict.value)
        case Verdict.NON_STRICT if strict:
            case.add_failure_info(message, text, result.verdict.value)
        case Verdict.KNOWN_DEVIATION:
            case.add_skipped_info(f"{result.verdict.value}: {xml_text(result.reason)}")
        case Verdict.BENCH_ERROR:
            case.add_error_info(message, text, result.verdict.value)
        case Verdict.UNIMPLEMENTED | Verdict.NOT_TESTABLE | Verdict.NOT_RUN:
            case.add_skipped_info(f"{result.verdict.value}: {message}")
    return case


def _keep(element: ElementTree.Element, names: set[str]) -> None:
    for name in list(element.keys()):
        if name not in names:
            del element.attrib[name]
