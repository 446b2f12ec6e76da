"""The suite beside other plugins of pytest: each sees a failure as one, and does what it is for."""

import json
import os
import subprocess
import sys
from collections import Counter
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import pytest

from conformance.run.case_files import CASES

FAILING = {
    "segmented-upload.toggle-first",
    "segmented-upload.toggle-repeated[segmented-upload-middle]",
    "segmented-upload.toggle-repeated[segmented-upload-last]",
}
FILE = "cases/test_segmented_upload.py"
CHOSEN = ("segmented-upload.toggle", "segmented-upload.restart")
BREACH = "broken rule: segmented-upload.toggle-first"
OUR_FAULT = ("--self-test", "--sdo-simulated", "--sdo-fault=upload-toggle-ignored", *CHOSEN)


def run(folder: Path, plugins: str, *arguments: str, status: int = 1) -> str:
    """Run the suite with the plugins that are named and no others; return what it prints."""
    installed = {each.name for each in entry_points(group="pytest11")}
    wanted = {"conformance", *plugins.split()}
    assert wanted <= installed
    left_out = [part for name in installed - wanted for part in ("-p", f"no:{name}")]
    done = subprocess.run(  # noqa: S603 - these are our own commands
        (sys.executable, "-m", "pytest", "-v", *left_out, *arguments),
        cwd=folder,
        env={name: os.environ[name] for name in os.environ if not name.startswith("PYTEST_")},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode == status, done.stdout
    return done.stdout


def results(folder: Path) -> list[dict[str, Any]]:
    """Return the cases that the suite itself has recorded in the only run in a folder."""
    (path,) = folder.glob("reports/*/results.jsonl")
    lines = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return [line["result"] for line in lines if line["record"] == "case"]


def failed(folder: Path) -> Counter[str]:
    return Counter(case["case_id"] for case in results(folder) if case["verdict"] == "fail")


def order(printed: str) -> list[str]:
    return [line.split()[0] for line in printed.splitlines() if line.startswith("cases/")]


def test_json_report_has_the_line_and_the_evidence(tmp_path: Path) -> None:
    run(tmp_path, "pytest_jsonreport metadata", "--json-report", *OUR_FAULT)
    tests = json.loads((tmp_path / ".report.json").read_text(encoding="utf-8"))["tests"]
    calls = {test["nodeid"]: test["call"] for test in tests if test["outcome"] == "failed"}
    assert set(calls) == {f"{FILE}::{case}" for case in FAILING}
    call = calls[f"{FILE}::segmented-upload.toggle-first"]
    assert BREACH in call["longrepr"]
    assert call["crash"]["path"] == str(CASES / "test_segmented_upload.py")
    lines = Path(call["crash"]["path"]).read_text(encoding="utf-8").splitlines()
    assert "sdo.expect_abort(" in lines[call["crash"]["lineno"] - 1]
    assert call["crash"]["message"].startswith("expected abort with 05030000h")


def test_allure_tells_a_failure_from_a_broken_test(tmp_path: Path) -> None:
    run(tmp_path, "allure_pytest", "--alluredir=allure", *OUR_FAULT)
    told = [
        json.loads(path.read_text(encoding="utf-8"))
        for path in tmp_path.glob("allure/*-result.json")
    ]
    assert {case["name"] for case in told if case["status"] == "failed"} == FAILING
    assert {case["status"] for case in told} == {"passed", "failed"}
    by_name = {case["name"]: case for case in told}
    assert BREACH in by_name["segmented-upload.toggle-first"]["statusDetails"]["message"]
    (parameter,) = by_name["segmented-upload.toggle-repeated[segmented-upload-last]"]["parameters"]
    assert parameter["value"] == "'segmented-upload-last'", "the same in each run"


def test_html_shows_the_evidence(tmp_path: Path) -> None:
    run(tmp_path, "html html_fixtures metadata", "--html=page.html", *OUR_FAULT)
    assert BREACH in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_sugar_shows_the_evidence(tmp_path: Path) -> None:
    assert BREACH in run(tmp_path, "sugar", "--force-sugar", *OUR_FAULT)


def test_of_a_case_that_is_rerun_the_last_try_counts(tmp_path: Path) -> None:
    printed = run(tmp_path, "rerunfailures", "--reruns=2", *OUR_FAULT)
    assert f"{2 * len(FAILING)} rerun" in printed
    assert failed(tmp_path) == Counter(FAILING)
    notes = [case["notes"] for case in results(tmp_path) if case["verdict"] == "fail"]
    again = "run again: before it was fail (segmented-upload.toggle: upload segment response)"
    assert all(each.count(again) == 2 for each in notes)


def test_each_case_is_repeated_as_often_as_wanted(tmp_path: Path) -> None:
    printed = run(tmp_path, "repeat", "--count=2", *OUR_FAULT)
    assert f"{FILE}::segmented-upload.toggle-first[2-2] " in printed
    assert f"{FILE}::segmented-upload.toggle-repeated[segmented-upload-last-2-2] " in printed
    assert failed(tmp_path) == Counter(dict.fromkeys(FAILING, 2))


def test_a_case_that_takes_too_long_is_not_the_fault_of_the_device(tmp_path: Path) -> None:
    slow = ("--self-test", "--sdo-answer-delay=0.005", "segmented-upload.size[4097]")
    printed = run(tmp_path, "timeout", "--timeout=0.5", *slow, status=11)
    assert "Another plugin of pytest ended the case" in printed
    (case,) = results(tmp_path)
    assert case["verdict"] == "bench error"


def test_randomly_shuffles_other_tests_and_keeps_the_order_of_the_cases(tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text(
        "".join(f"def test_{number}(): pass\n" for number in range(40)), encoding="utf-8"
    )
    plain = run(tmp_path, "", ".", *OUR_FAULT)
    shuffled = run(tmp_path, "randomly", ".", "--randomly-seed=1", *OUR_FAULT)
    assert order(plain) == order(shuffled)
    own = [
        [line for line in printed.splitlines() if line.startswith("test_own.py")]
        for printed in (plain, shuffled)
    ]
    assert len(own[0]) == len(own[1]) == 40
    assert own[0] != own[1]


def test_coverage_is_measured(tmp_path: Path) -> None:
    (tmp_path / "measured.py").write_text("def answer():\n    return 42\n", encoding="utf-8")
    (tmp_path / "test_own.py").write_text(
        "import measured\n\n\ndef test_own(sdo):\n    assert measured.answer() == 42\n",
        encoding="utf-8",
    )
    printed = run(tmp_path, "pytest_cov", "--cov=measured", "test_own.py", *OUR_FAULT)
    assert "100%" in printed
    assert failed(tmp_path) == Counter(FAILING)


def test_asynchronous_tests_run_beside_the_cases(tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text(
        "import asyncio\n\n\nasync def test_own(sdo_device):\n    await asyncio.sleep(0)\n"
        "    assert sdo_device.node_id == 5\n",
        encoding="utf-8",
    )
    printed = run(tmp_path, "asyncio", "--asyncio-mode=auto", "test_own.py", *OUR_FAULT)
    assert "test_own.py::test_own PASSED" in printed
    assert failed(tmp_path) == Counter(FAILING)


def test_the_options_of_playwright_are_its_own(tmp_path: Path) -> None:
    options = ("--browser=chromium", "--device=iPhone 13", "--tracing=on", "--video=on")
    run(tmp_path, "playwright", *options, *OUR_FAULT)
    assert failed(tmp_path) == Counter(FAILING)


ALL = (
    "pytest_jsonreport metadata allure_pytest html html_fixtures sugar rerunfailures repeat "
    "timeout randomly xdist pytest_cov asyncio playwright"
)
REPORTS = ("--json-report", "--alluredir=allure", "--html=page.html", "--force-sugar")


@pytest.mark.parametrize("workers", ["-n0", "-n2"])
def test_all_at_once(tmp_path: Path, workers: str) -> None:
    """Between processes too, a failure keeps its line and its evidence."""
    again = ("--reruns=1", "--timeout=60")
    assert BREACH in run(tmp_path, ALL, *REPORTS, workers, *again, *OUR_FAULT)
    assert failed(tmp_path) == Counter(FAILING)
    tests = json.loads((tmp_path / ".report.json").read_text(encoding="utf-8"))["tests"]
    crashes = [test["call"]["crash"] for test in tests if test["outcome"] == "failed"]
    assert [Path(crash["path"]).name for crash in crashes] == 3 * ["test_segmented_upload.py"]
