"""results.jsonl of a run: written case by case, kept when that is killed, reported from again."""

import signal
import sys
from pathlib import Path

import pytest
from plugin_runs import QUICK, parsed, reports, run, self_test, the_report

from conformance.__main__ import main
from conformance.commands.status import DONE, WRONG_USE
from conformance.plugin.exit_code import ExitCode
from conformance.reporting.recorded import RecordedRun, read_run
from conformance.run.case_files import CASES
from conformance.run.verdict import Verdict

pytest_plugins = ["pytester"]

CHOSEN = ("--sdo-simulated", "-k", "abort.frame or upload.identity")


def lines_of(folder: Path, run: RecordedRun, position: int) -> list[str]:
    """Return the lines of bus.log that are those of a case."""
    place = run.places[position]
    assert place is not None
    log = (folder / place.log).read_text(encoding="utf-8").splitlines()
    return log[place.first - 1 : place.last]


def test_a_complete_run(pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]) -> None:
    self_test(pytester, *CHOSEN)
    folder = the_report(pytester)
    recorded = read_run(folder)
    assert recorded.end is not None
    assert (recorded.end["how"], recorded.end["exit_status"]) == ("complete", 0)
    assert recorded.selected == len(recorded.results) == 2
    assert recorded.about["self_test"]
    assert recorded.about["begun"].rpartition("T")[2][12:13] in ("+", "-", "Z")
    (device,) = recorded.devices
    assert device["identity"]["vendor-id"] == "0x5D0C0000"
    assert device["texts"]["1008h:00"]
    for position, result in enumerate(recorded.results):
        lines = lines_of(folder, recorded, position)
        assert lines[0].endswith("T")
        assert lines[-1].endswith("R"), result.case_id
    written = (folder / "junit.xml").read_bytes()
    (folder / "junit.xml").unlink()
    assert main(["report", str(folder)]) == DONE
    assert (folder / "junit.xml").read_bytes() == written
    assert "2 pass" in capsys.readouterr().out


def test_several_workers(pytester: pytest.Pytester) -> None:
    """The controller writes what they send; their logs have become one."""
    folder = f"--sdo-report-dir={reports(pytester)}"
    options = ("--self-test", "--node-id=5,9", *CHOSEN, "-n", "2")
    assert pytester.runpytest_subprocess(*QUICK, folder, *options).ret == 0
    recorded = read_run(the_report(pytester))
    assert recorded.end is not None
    assert recorded.selected == len(recorded.results) == 4
    assert {device["node_id"] for device in recorded.devices} == {5, 9}
    for position, result in enumerate(recorded.results):
        lines = lines_of(the_report(pytester), recorded, position)
        for line in (lines[0], lines[-1]):
            assert f"{result.node_id}#" in line


KILLED = """
    import os, signal

    def test_first(sdo):
        sdo.fence()

    def test_second(sdo):
        sdo.fence()
        assert False

    def test_third(sdo):
        sdo.fence()
        os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_run_that_is_killed(
    pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each case that was finished is there, with its frames, and its report says what happened."""
    pytester.makepyfile(test_mine=KILLED)
    folder = f"--sdo-report-dir={reports(pytester)}"
    result = pytester.runpytest_subprocess(*QUICK, folder, "--self-test", "test_mine.py")
    assert result.ret == -signal.SIGKILL
    recorded = read_run(the_report(pytester))
    assert [case.verdict for case in recorded.results] == [Verdict.PASS, Verdict.FAIL]
    assert recorded.selected == 3
    for position in (0, 1):
        assert "605#4000100000000000 T" in lines_of(the_report(pytester), recorded, position)[-2]
    assert main(["report", str(the_report(pytester))]) == DONE
    assert "the run was killed" in capsys.readouterr().out
    suites = {suite.attrib["name"]: suite for suite in parsed(the_report(pytester) / "junit.xml")}
    assert suites["the run"].attrib["errors"] == "1"
    assert suites["test_mine"].attrib["failures"] == "1"


def test_a_folder_that_is_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(tmp_path)]) == WRONG_USE
    assert "no record of a run" in capsys.readouterr().err


def test_a_bus_that_cannot_be_opened_is_an_error_in_junit_xml(pytester: pytest.Pytester) -> None:
    bus = ("--can-interface=socketcan", "--can-channel=no-such-can0")
    assert run(pytester, "--node-id=5", *bus, "-k", "abort.frame").ret == ExitCode.BENCH_ERROR
    errors = list(parsed(the_report(pytester) / "junit.xml").iter("error"))
    assert len(errors) == 1
    assert "no-such-can0 cannot be opened" in errors[0].attrib["message"]


def test_a_full_disk(pytester: pytest.Pytester) -> None:
    """No file may grow beyond 2 KiB: no case fails, and each result that has room is there."""
    cases = [str(CASES / "test_abort.py")]
    folder = f"--sdo-report-dir={reports(pytester)}"
    run = [sys.executable, "-m", "pytest", *QUICK, folder, "--self-test", "--sdo-simulated", *cases]
    result = pytester.run("sh", "-c", 'ulimit -f 4; exec "$@"', "sh", *run)
    assert result.ret == ExitCode.BENCH_ERROR
    assert not {"failed", "errors"} & set(result.parseoutcomes())
    result.stdout.fnmatch_lines(["*bus.log could not be written: *File too large*"])
    assert (the_report(pytester) / "results.jsonl").read_bytes().startswith(b'{"record": "run"')


GOES_AWAY = """
    import shutil

    def test_first(sdo):
        sdo.fence()

    def test_second(sdo, request):
        shutil.rmtree(request.config.getoption("sdo_report_dir"))
        sdo.fence()
"""


def test_a_report_folder_that_goes_away(pytester: pytest.Pytester) -> None:
    """It is never the device's failure; what is in memory is written, and the run says so."""
    pytester.makepyfile(test_mine=GOES_AWAY)
    result = self_test(pytester, "test_mine.py")
    result.assert_outcomes(passed=2)
    assert result.ret == ExitCode.BENCH_ERROR
    result.stdout.fnmatch_lines(["*bus.log could not be written: it has gone away"])
    recorded = read_run(the_report(pytester))
    assert len(recorded.results) == 2
    assert recorded.end is not None
    assert recorded.end["exit_status"] == ExitCode.BENCH_ERROR
    assert (the_report(pytester) / "junit.xml").exists()
