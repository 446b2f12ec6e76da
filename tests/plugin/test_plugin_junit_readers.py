"""The JUnit files of a run, read by programs that others wrote."""

import subprocess
import sys
from pathlib import Path

import junitparser
import pytest
from plugin_runs import self_test, the_report

pytest_plugins = ["pytester"]

FAULTY = (
    "--sdo-fault=upload-toggle-ignored",
    "-k",
    "test_segmented_upload.py or test_server_timeout.py",
)


@pytest.fixture
def folder(pytester: pytest.Pytester) -> Path:
    """Return what a run with failures, passes and skips has written."""
    self_test(pytester, *FAULTY)
    return the_report(pytester)


def outcomes(path: Path) -> dict[str, list[str]]:
    """Return the names of the cases in a file, as junitparser reads them, by outcome."""
    found: dict[str, list[str]] = {"passed": [], "failed": [], "skipped": []}
    for suite in junitparser.JUnitXml.fromfile(str(path)):
        for case in suite:
            kinds = {junitparser.Failure: "failed", junitparser.Skipped: "skipped"}
            (outcome,) = [kinds[type(each)] for each in case.result] or ["passed"]
            found[outcome].append(str(case.name))
    return found


def test_junitparser_counts_what_the_run_counted(folder: Path) -> None:
    file = junitparser.JUnitXml.fromfile(str(folder / "junit.xml"))
    found = outcomes(folder / "junit.xml")
    assert "segmented-upload.toggle-first" in found["failed"]
    assert found["passed"]
    assert found["skipped"]
    assert (file.failures, file.skipped) == (len(found["failed"]), len(found["skipped"]))
    assert file.tests == sum(map(len, found.values()))


def test_junitparser_finds_each_broken_rule_once(folder: Path) -> None:
    found = outcomes(folder / "causes.xml")
    assert "segmented-upload.toggle" in found["failed"]
    assert len(found["failed"]) == len(set(found["failed"]))


@pytest.mark.parametrize("name", ["junit.xml", "causes.xml"])
def test_junit2html_makes_a_page_that_names_the_failure(folder: Path, name: str) -> None:
    page = folder / "page.html"
    command = [sys.executable, "-m", "junit2htmlreport", str(folder / name), str(page)]
    subprocess.run(command, check=True, timeout=60)  # noqa: S603 - our own
    failed = outcomes(folder / name)["failed"]
    text = page.read_text(encoding="utf-8")
    assert failed
    assert all(case in text for case in failed)
