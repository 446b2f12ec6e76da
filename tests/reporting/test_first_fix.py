"""Which cause a run says to begin with, and why."""

from pathlib import Path

from reporting_results import result

from conformance.reporting.cause_counts import counted_causes
from conformance.reporting.first_fix import first_fix
from conformance.reporting.reproduction import FOLDER
from conformance.run.verdict import CaseResult, Verdict

ECHO = "abort.not-answered: an answer"
TOGGLE = "segmented-upload.toggle: upload segment response"


def failed(cause: str, case_id: str, node_id: int = 5) -> CaseResult:
    return result(Verdict.FAIL, case_id=case_id, cause=cause, node_id=node_id)


def prevented(cause: str, case_id: str) -> CaseResult:
    return result(Verdict.NOT_TESTABLE, case_id=case_id, cause=cause)


def test_the_one_with_most_cases_behind_it_and_in_its_way(tmp_path: Path) -> None:
    results = [
        failed(TOGGLE, "upload.a"),
        failed(TOGGLE, "upload.b"),
        failed(ECHO, "abort.a"),
        prevented(ECHO, "abort.b"),
        prevented(ECHO, "abort.c"),
    ]
    fix = first_fix(counted_causes(results, strict=False), tmp_path)
    assert (fix.cause, fix.case_id, fix.replay) == (ECHO, "abort.a", "")
    share, rule = fix.why
    assert share == "1 of 3 failures, and 2 cases cannot be tested before it is gone"
    assert rule.startswith("MUST, CiA 301 clause 7.2.4.3")


def test_one_that_only_prevents_cases(tmp_path: Path) -> None:
    fix = first_fix(counted_causes([prevented(ECHO, "abort.b")], strict=False), tmp_path)
    assert fix.why[0] == "1 case cannot be tested before it is gone"


def test_devices_of_one_kind_share_their_cause(tmp_path: Path) -> None:
    several = [failed(ECHO, "abort.a", node_id) for node_id in (5, 6, 7)]
    alone = [failed(TOGGLE, name, 8) for name in ("upload.a", "upload.b")]
    fix = first_fix(counted_causes([*alone, *several], strict=False), tmp_path)
    assert fix.cause == ECHO
    assert fix.why[:2] == ["3 of 5 failures", "on 3 devices: nodes 5, 6, 7"]


def test_the_log_that_shows_it_has_the_number_of_the_cause(tmp_path: Path) -> None:
    folder = tmp_path / "a run"
    (folder / FOLDER).mkdir(parents=True)
    (folder / FOLDER / "01-abort.not-answered.log").touch()
    fix = first_fix(counted_causes([failed(ECHO, "abort.a")], strict=False), folder)
    log = folder / FOLDER / "01-abort.not-answered.log"
    assert fix.replay == f"conformance replay '{log}'"
    assert fix.why[0] == "the only failure"
