"""junit.xml stays within what those who read it take, whatever the EDS and however many devices."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from junit_schema import breaches
from reporting_results import found, result, written

from conformance.reporting.junit.fitting import LEFT_OUT, MOST_CASES, rows_that_fit, shortened
from conformance.run.trace import TraceLine
from conformance.run.verdict import CaseResult, Verdict

BUILDKITE_RESULTS = 5_000
GITLAB_BYTES = 30_000_000
KINDS = ("read", "block-read", "write-back", "too-long")


def cases(objects: int, verdict: Verdict = Verdict.PASS, node_id: int = 5) -> Iterator[CaseResult]:
    """Yield the results of an EDS with so many objects."""
    for kind in KINDS:
        for index in range(0x2000, 0x2000 + objects):
            yield result(
                verdict,
                service="object-dictionary",
                case_id=f"od.{kind}[{index:04X}h:00]",
                node_id=node_id,
                actual="" if verdict is Verdict.PASS else f"{kind} fails",
                cause=f"dictionary.{kind}: other data" if verdict is Verdict.FAIL else "",
            )


def names(results: list[CaseResult], most: int = MOST_CASES, *, strict: bool = False) -> list[str]:
    return [row.name for row in rows_that_fit(results, most, strict=strict)]


def test_what_fits_is_told_case_by_case() -> None:
    results = list(cases(3))
    assert names(results, 12) == [each.case_id for each in results]


def test_failures_are_told_one_by_one_while_passes_are_told_together(tmp_path: Path) -> None:
    """An EDS with 20,000 objects."""
    failed = result(Verdict.FAIL, service="object-dictionary", case_id="od.read[9FFFh:00]")
    alone = result(case_id="upload.identity")
    root = written(tmp_path / "junit.xml", [*cases(20_000), failed, alone])
    assert {case.get("name") for case in root.iter("testcase")} == {
        *(f"od.{kind}[…]: pass" for kind in KINDS),
        "od.read[9FFFh:00]",
        "upload.identity",
    }
    text = found(root, "testsuite/testcase/system-out").text or ""
    assert text.startswith("20000 cases, from od.read[2000h:00] to od.read[6E1Fh:00]\n")
    told = found(root, "testsuite/properties/property")
    assert told.get("value") == "80002 cases, told in 6; results.jsonl has each"
    assert (root.get("tests"), root.get("failures"), root.get("time")) == ("6", "1", "20000.500000")


def test_reasons_are_counted(tmp_path: Path) -> None:
    root = written(tmp_path / "junit.xml", list(cases(2_000, Verdict.NOT_TESTABLE)))
    skipped = found(root, "testsuite/testcase/skipped")
    assert skipped.get("message") == "not testable: 2000 cases; read fails"
    assert "2000 of them: read fails" in (found(root, "testsuite/testcase/system-out").text or "")


def test_what_does_not_fit_by_name_is_told_by_service() -> None:
    results = [*cases(3), *cases(3, Verdict.UNIMPLEMENTED), *cases(1, Verdict.FAIL)]
    failed = [f"od.{kind}[2000h:00]" for kind in KINDS]
    assert names(results, 12)[-4:] == failed
    assert names(results, 6) == ["pass", "unimplemented", *failed]


def test_failures_that_do_not_fit_are_told_by_cause_then_by_verdict() -> None:
    results = [*cases(3), *cases(3, Verdict.FAIL), *cases(3, Verdict.FAIL, node_id=9)]
    by_cause = [f"dictionary.{kind}: other data: fail" for kind in KINDS]
    assert names(results, 9) == ["pass", *by_cause, *by_cause]
    assert names(results, 8) == ["pass", "fail", "fail"]


def test_strict_failures_are_failures() -> None:
    results = list(cases(3, Verdict.NON_STRICT))
    assert names(results, 4) == [f"od.{kind}[…]: non-strict" for kind in KINDS]
    assert names(results, 4, strict=True) == [f"od.{kind}[…]: non-strict" for kind in KINDS]
    assert names([*results, *cases(1)], 12, strict=True)[-1] == "pass"


LINES = ['"&<>' * 20, "\u202e" * 30]


@pytest.mark.parametrize("line", LINES)
def test_the_worst_run_fits(tmp_path: Path, line: str) -> None:
    """As many failures as fit, each with the longest evidence, full of what XML has to quote."""
    failed = [
        result(
            Verdict.FAIL,
            case_id=f"od.read[{number}]",
            service=f"service-{number % 20}",
            actual=line,
            trace=[TraceLine(line)] * 200,
            reproduce=[line] * 100,
            cause="dictionary.structure: other data",
        )
        for number in range(MOST_CASES)
    ]
    path = tmp_path / "junit.xml"
    root = written(path, failed, {"writable-objects": "2001h:00, " * 20_000})
    assert len(list(root.iter("testcase"))) == BUILDKITE_RESULTS
    assert GITLAB_BYTES / 3 < path.stat().st_size < GITLAB_BYTES, "it is not cut too short either"
    assert breaches(root) == []


def test_a_text_is_shortened_at_the_end_of_a_line() -> None:
    text = "a" * 40 + "\n" + "b" * 40 + "\n" + "c" * 40
    assert shortened(text, 132) == text
    assert shortened(text, 120) == "a" * 40 + "\n" + LEFT_OUT
    assert shortened("&" * 1_000, 600) == "&" * 100 + "\n" + LEFT_OUT
