"""Which cause a run says to begin with, and why."""

from pathlib import Path

from reporting_results import result

from conformance.bus.opening import BusSettings
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
    assert (str(fix.cause), fix.case_id, fix.replay) == (ECHO, "abort.a", "")
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
    assert str(fix.cause) == ECHO
    assert fix.why[:2] == ["3 of 5 failures", "on 3 devices: nodes 5, 6, 7"]


def logged(folder: Path, *lines: str) -> Path:
    """Write the log that shows the first cause."""
    log = folder / FOLDER / "01-abort.not-answered.log"
    log.parent.mkdir(parents=True)
    log.write_text("".join(f"(0.000000) can0 {line} T\n" for line in lines), encoding="utf-8")
    return log


def test_the_log_that_shows_it_has_the_number_of_the_cause(tmp_path: Path) -> None:
    folder = tmp_path / "a run"
    log = logged(folder, "605#4000100000000000")
    fix = first_fix(counted_causes([failed(ECHO, "abort.a")], strict=False), folder)
    assert fix.replay == f"conformance replay '{log}'"
    assert fix.why[0] == "the only failure"


def test_the_command_names_the_bus_and_allows_what_the_log_writes(tmp_path: Path) -> None:
    log = logged(tmp_path, "605#2F01200001000000")
    causes = counted_causes([failed(ECHO, "abort.a")], strict=False)
    bus = BusSettings("pcan", "PCAN_USBBUS1", 500_000).arguments
    assert first_fix(causes, tmp_path, bus).replay == (
        f"conformance replay {log} --can-interface=pcan --can-channel=PCAN_USBBUS1 "
        "--can-bitrate=500000 --writes"
    )


def test_a_log_of_which_nothing_can_be_sent_gives_no_command(tmp_path: Path) -> None:
    logged(tmp_path, "7E5#0000000000000000")
    causes = counted_causes([failed(ECHO, "abort.a")], strict=False)
    assert first_fix(causes, tmp_path).replay == ""
