"""--sdo-budget: a run ends in time, and says in every report what it was not to run."""

import json
from types import SimpleNamespace

import pytest
from plugin_runs import QUICK, parsed, reports, self_test, the_report

from conformance.device.option_kinds import duration
from conformance.plugin.budget import Budget
from conformance.reporting.estimate import Estimate

pytest_plugins = ["pytester"]

CHOSEN = ("--sdo-simulated", "-k", "abort.not-answered or upload.identity or test_whole_run")
NOT_RUN = "not run: budget"


class Clock:
    """A clock that goes on by a second whenever it is looked at."""

    def __init__(self) -> None:
        self.now = 0.0

    def monotonic(self) -> float:
        self.now += 1.0
        return self.now


@pytest.fixture(autouse=True)
def _clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the time of a run be counted, not measured."""
    monkeypatch.setattr("conformance.plugin.budget.time", Clock())


def skipped(pytester: pytest.Pytester, name: str) -> list[str]:
    """Return what a JUnit file says of the cases that were skipped."""
    folder = pytester.path if name == "all.xml" else the_report(pytester)
    return [each.attrib["message"] for each in parsed(folder / name).iter("skipped")]


def recorded(pytester: pytest.Pytester) -> list[dict[str, object]]:
    """Return the lines of results.jsonl."""
    text = (the_report(pytester) / "results.jsonl").read_text("utf-8")
    return [json.loads(line) for line in text.splitlines()]


def test_what_does_not_fit_is_not_run(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *CHOSEN, "--sdo-budget=14s", "--junitxml=all.xml")
    assert result.ret == pytest.ExitCode.OK
    left = len(skipped(pytester, "junit.xml"))
    passed = result.parseoutcomes()["passed"]
    assert left > 0
    assert passed > 4, "some cases, and those that judge the whole run"
    assert skipped(pytester, "junit.xml") == [NOT_RUN] * left
    assert skipped(pytester, "all.xml") == [NOT_RUN] * left
    verdicts = [line["result"]["verdict"] for line in recorded(pytester) if "result" in line]  # type: ignore[index]
    assert verdicts.count("not run") == left
    assert recorded(pytester)[-1]["how"] == "budget"
    result.stdout.fnmatch_lines([f"not run: {left} case* of node 5: budget"])


def test_what_judges_the_run_is_run(pytester: pytest.Pytester) -> None:
    self_test(pytester, *CHOSEN, "--sdo-budget=20s", "-v").stdout.fnmatch_lines(
        ["*::run.no-late-response PASSED*"]
    )


def test_the_exit_status_is_that_of_what_was_run(pytester: pytest.Pytester) -> None:
    wrong = self_test(pytester, *CHOSEN, "--sdo-fault=every-abort-answered", "--sdo-budget=20s")
    assert wrong.ret == pytest.ExitCode.TESTS_FAILED
    assert NOT_RUN in skipped(pytester, "junit.xml")


def test_a_run_without_any_case_is_no_success(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *CHOSEN, "--sdo-budget=0.5")
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    assert set(skipped(pytester, "junit.xml")) == {NOT_RUN}
    assert "passed" not in result.parseoutcomes()


def test_enough_time(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *CHOSEN, "--sdo-budget=24h")
    assert result.ret == pytest.ExitCode.OK
    assert skipped(pytester, "junit.xml") == []
    assert recorded(pytester)[-1]["how"] == "complete"


def test_values_are_put_back(pytester: pytest.Pytester) -> None:
    """The cases with downloads end by the budget; what they have written is as it was."""
    chosen = ("--sdo-simulated", "-k", "sequence.downloads")
    result = self_test(pytester, *chosen, "--sdo-budget=30s")
    assert NOT_RUN in skipped(pytester, "junit.xml")
    assert result.parseoutcomes()["passed"] > 1
    assert not (the_report(pytester) / "not-restored.jsonl").exists()
    result.stdout.no_fnmatch_line("not restored*")


def test_workers_keep_to_it(pytester: pytest.Pytester) -> None:
    folder = f"--sdo-report-dir={reports(pytester)}"
    arguments = ("--self-test", *CHOSEN, "-n", "2", "--sdo-budget=0.000001")
    result = pytester.runpytest_subprocess(*QUICK, folder, *arguments)
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    assert set(skipped(pytester, "junit.xml")) == {NOT_RUN}


def test_devices_in_turn_share_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SimpleNamespace(monotonic=lambda: 100.0)
    monkeypatch.setattr("conformance.plugin.budget.time", clock)
    budget = Budget(90.0, [5, 9, 12], Estimate())
    assert [budget.left(node_id) for node_id in (5, 9, 12)] == [30.0, 60.0, 90.0]
    clock.monotonic = lambda: 140.0
    assert [budget.left(node_id) for node_id in (5, 9, 12)] == [-10.0, 20.0, 50.0]


TIMES = {
    "5min": 300,
    "300s": 300,
    "300": 300,
    "2min30s": 150,
    "1h": 3600,
    "0.5": 0.5,
    "1h30min": 5400,
}


@pytest.mark.parametrize(("text", "seconds"), TIMES.items(), ids=TIMES)
def test_how_a_time_is_written(text: str, seconds: float) -> None:
    assert duration(text) == seconds


@pytest.mark.parametrize("text", ["", "0", "0min", "-5", "5 minutes", "5m", "min", "inf", "nan"])
def test_what_is_no_time(text: str) -> None:
    with pytest.raises(ValueError, match="is no time: write 5min"):
        duration(text)
