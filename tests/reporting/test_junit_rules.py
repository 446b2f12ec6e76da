"""causes.xml: a test case for each rule that was tested, with each cause in its failure."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path

from junit_schema import XSD, breaches
from reporting_results import TIMESTAMP, result
from test_junit_schema import valid_by_xsd

from conformance.reporting.junit.rules import WITHOUT_RULE, write_causes
from conformance.run.verdict import CaseResult, Verdict

NOT_ANSWERED = "abort.not-answered: an answer"
NO_ANSWER = "response.answered: no answer to upload initiate"
REFUSED = "response.answered: abort 08000000h to upload initiate"
TESTED = ["response.answered"]


def failed(cause: str, case_id: str, **changes: str) -> CaseResult:
    rule = cause.partition(":")[0]
    return result(
        Verdict.FAIL, case_id=case_id, cause=cause, broken_rule=rule, actual="x", **changes
    )


def causes(
    folder: Path, results: Sequence[CaseResult], *, strict: bool = False, trouble: str = ""
) -> ElementTree.Element:
    """Write causes.xml, check it, and return it."""
    path = folder / "causes.xml"
    troubles = [trouble] if trouble else []
    write_causes(
        path, results, {"node-id": "5"}, timestamp=TIMESTAMP, strict=strict, troubles=troubles
    )
    root = ElementTree.parse(path).getroot()  # noqa: S314 - it is our own file
    assert breaches(root) == []
    assert not XSD.exists() or valid_by_xsd(path)
    return root


def outcomes(root: ElementTree.Element) -> dict[str, str]:
    """Return what became of each rule, by its id."""
    return {case.attrib["name"]: case[0].tag for case in root.iter("testcase")}


def test_a_rule_is_one_case(tmp_path: Path) -> None:
    """A rule that no case has shown to be kept or broken is not there."""
    results = [
        result(case_id="upload.identity", rules=TESTED),
        result(case_id="upload.device-type", rules=TESTED),
        result(Verdict.NOT_TESTABLE, case_id="download.number", rules=["size.indicated"]),
        failed(NOT_ANSWERED, "abort.not-answered[silence]"),
        failed(NOT_ANSWERED, "abort.not-answered[generic]"),
    ]
    root = causes(tmp_path, results)
    assert outcomes(root) == {"response.answered": "system-out", "abort.not-answered": "failure"}
    assert (root.get("tests"), root.get("failures")) == ("2", "1")
    (failure,) = root.iter("failure")
    assert failure.attrib == {
        "type": "abort.not-answered",
        "message": f"{NOT_ANSWERED} (2 cases failed; first abort.not-answered[silence])",
    }
    assert "  frames (> sent, < received)" in (failure.text or "")


def test_a_rule_that_is_broken_in_two_ways_is_one_failure(tmp_path: Path) -> None:
    """Many readers show only the first failure of a case."""
    results = [
        result(rules=TESTED),
        failed(REFUSED, "upload.identity"),
        failed(NO_ANSWER, "upload.device-type", requirement="Of the first."),
        failed(NO_ANSWER, "upload.write-only"),
    ]
    root = causes(tmp_path, results)
    assert outcomes(root) == {"response.answered": "failure"}
    (failure,) = root.iter("failure")
    assert failure.attrib["message"] == (
        f"{NO_ANSWER} (2 cases failed; first upload.device-type); "
        f"{REFUSED} (1 case failed; first upload.identity)"
    )
    text = failure.text or ""
    assert 0 < text.index("upload.device-type: FAIL") < text.index("upload.identity: FAIL")
    assert "upload.write-only: FAIL" not in text


def test_the_suite_names_the_broken_rules(tmp_path: Path) -> None:
    root = causes(tmp_path, [failed(NO_ANSWER, "upload.a"), failed(NOT_ANSWERED, "abort.b")])
    found = {
        suite.attrib["name"]: {each.attrib["value"] for each in suite.iter("property")}
        for suite in root
    }
    assert found == {
        "every response": {"5", "response.answered"},
        "idle server": {"5", "abort.not-answered"},
    }


def test_strict(tmp_path: Path) -> None:
    soft = [result(Verdict.NON_STRICT, cause=NO_ANSWER, rules=TESTED)]
    assert outcomes(causes(tmp_path, soft)) == {"response.answered": "system-out"}
    assert outcomes(causes(tmp_path, soft, strict=True)) == {"response.answered": "failure"}


def test_a_known_deviation_is_skipped(tmp_path: Path) -> None:
    known = result(Verdict.KNOWN_DEVIATION, cause=NO_ANSWER, reason="ticket 1")
    (skipped,) = causes(tmp_path, [known]).iter("skipped")
    assert skipped.attrib["message"] == "known deviation in 1 case: ticket 1"
    root = causes(tmp_path, [known, failed(NO_ANSWER, "upload.identity")])
    assert outcomes(root) == {"response.answered": "failure"}


def test_a_run_that_was_red_is_not_green_here(tmp_path: Path) -> None:
    """Nor where no rule is to blame: for errors of the bench, tests of one's own, a broken run."""
    results = [
        result(rules=TESTED),
        *[
            result(Verdict.BENCH_ERROR, actual="no cable", case_id=f"a.{each}", cause=NO_ANSWER)
            for each in range(9)
        ],
        result(Verdict.FAIL, case_id="test_mine", actual="assert 0"),
        result(Verdict.STALE, case_id="upload.b", actual="passes"),
    ]
    root = causes(tmp_path, results, trouble="the run was killed")
    assert (root.get("errors"), root.get("failures")) == ("2", "2")
    (suite,) = (suite for suite in root if suite.get("name") == WITHOUT_RULE)
    assert [case.get("name") for case in suite.iter("testcase")] == ["a.0", "test_mine", "upload.b"]
    (error,) = suite.iter("error")
    assert error.get("message") == "9 cases; no cable"


def test_several_devices(tmp_path: Path) -> None:
    results = [failed(NO_ANSWER, "upload.a"), result(rules=TESTED, node_id=9)]
    (failure,) = causes(tmp_path, results).iter("failure")
    assert failure.attrib["message"].startswith(f"node 5: {NO_ANSWER}")
