"""A worker sends one report of a case; where it arrives, everybody is told of all phases."""

from collections import Counter
from itertools import chain, combinations
from typing import Any

import pytest
from plugin_runs import QUICK, reports, self_test

from conformance.plugin.direct import Phases, run_briefly, run_directly
from conformance.plugin.joined_reports import Parting

pytest_plugins = ["pytester"]

PHASES = ("setup", "call", "teardown")
CHOSEN = ("-k", "segmented-upload.toggle or server-timeout", "--sdo-fault=upload-toggle-ignored")
# Writes down what is told of a run, where it is reported, and how many reports a worker sends.
OBSERVER = """
    def note(*what, to):
        with open(to, "a", encoding="utf-8") as file:
            print(*what, file=file)

    class Observer:
        def pytest_runtest_logstart(self, nodeid, location):
            note("start", nodeid, location, to="told.txt")

        def pytest_runtest_logreport(self, report):
            note(report.when, report.outcome, report.nodeid, report.location, to="told.txt")
            note(sorted(report.keywords), len(report.user_properties), to="told.txt")
            assert report.duration >= 0.0 and report.stop >= report.start > 1.7e9

        def pytest_runtest_logfinish(self, nodeid, location):
            note("finish", nodeid, location, to="told.txt")

    def pytest_report_to_serializable(report):
        note(report.when, report.outcome, to="sent.txt")

    def pytest_configure(config):
        if not hasattr(config, "workerinput"):
            config.pluginmanager.register(Observer())
"""
LISTENER = """
    def pytest_runtest_logreport(report):
        with open("heard.txt", "a", encoding="utf-8") as file:
            print(report.when, report.outcome, file=file)
"""


def observed(pytester: pytest.Pytester, workers: str, *options: str) -> tuple[list[str], list[str]]:
    """Run cases; return what was told of them, and which reports a worker has sent."""
    folder = f"--sdo-report-dir={reports(pytester)}"
    pytester.runpytest_subprocess(*QUICK, "--self-test", "-n", workers, folder, *CHOSEN, *options)
    found = []
    for path in (pytester.path / "told.txt", pytester.path / "sent.txt"):
        found.append(path.read_text("utf-8").splitlines() if path.exists() else [])
        path.unlink(missing_ok=True)
    told, sent = found
    return told, sent


def test_all_is_told_that_is_told_without_workers(pytester: pytest.Pytester) -> None:
    pytester.makeconftest(OBSERVER)
    expected, _ = observed(pytester, "0")
    told, sent = observed(pytester, "1")
    assert told == expected
    cases = sum(line.startswith("start ") for line in told)
    # The last one, which cannot be tested, is left to pytest: two phases.
    assert len(sent) == cases + 1
    assert {line.split()[1] for line in sent} == {"passed", "failed", "skipped"}


def test_who_listens_in_a_worker_hears_all_phases(pytester: pytest.Pytester) -> None:
    pytester.makeconftest(OBSERVER)
    # A conftest.py is not told of cases that are elsewhere.
    pytester.makepyfile(listener=LISTENER)
    pytester.syspathinsert()
    _, sent = observed(pytester, "1", "-p", "listener")
    heard = (pytester.path / "heard.txt").read_text("utf-8").splitlines()
    # The controller listens as well.
    assert sorted(heard) == sorted(sent * 2)
    assert "setup passed" in sent
    assert "teardown passed" in sent


@pytest.mark.parametrize("workers", ["0", "2"])
@pytest.mark.parametrize("listening", [False, True])
def test_quiet_phases_are_told_to_those_who_listen(
    pytester: pytest.Pytester, workers: str, *, listening: bool
) -> None:
    """Without anybody there is a report a case; the last one of a process is left to pytest."""
    made: Counter[str | None] = Counter()
    of_pytest = pytest.TestReport.__init__

    def counting(self: pytest.TestReport, *given: Any, **named: Any) -> None:
        of_pytest(self, *given, **named)
        made[self.when] += 1

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(pytest.TestReport, "__init__", counting)
        plugins = [Listener()] if listening else []
        result = self_test(pytester, "-k", "matrix.idle", "-n", workers, plugins=plugins)
    cases = result.parseoutcomes()["passed"]
    last = int(workers) or 1
    assert made["call"] == cases
    assert made["setup"] == made["teardown"] == (cases if listening else last)


class Listener:
    """What everybody is told of a test."""

    def __init__(self) -> None:
        self.told: list[tuple[object, ...]] = []
        self.exceptions: list[str | None] = []

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.told.append(("start", nodeid))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.told.append((report.when, report.outcome, report.nodeid, str(report.longrepr)))

    def pytest_exception_interact(self, report: pytest.TestReport) -> None:
        self.exceptions.append(report.when)

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        self.told.append(("finish", nodeid))


def subsets() -> list[tuple[str, ...]]:
    return list(chain.from_iterable(combinations(PHASES, count) for count in range(4)))


@pytest.mark.parametrize("fails", subsets(), ids=lambda fails: "+".join(fails) or "none")
def test_whichever_phase_fails_is_told(pytester: pytest.Pytester, fails: tuple[str, ...]) -> None:
    item = pytester.getitem("def test_func(): pass")
    listener = Listener()
    item.config.pluginmanager.register(listener)

    def phase(name: str) -> None:
        if name in fails:
            raise ValueError(name)

    phases: Phases = (
        ("setup", lambda _: phase("setup")),
        ("call", lambda _: phase("call")),
        ("teardown", lambda _: phase("teardown")),
    )
    run_directly(item, phases)  # type: ignore[arg-type]
    directly, listener.told = listener.told, []
    # As in a worker, but that the controller is the same process.
    item.config.workerinput = {}  # type: ignore[attr-defined]
    item.config.pluginmanager.register(Parting(item.config))
    run_briefly(item, phases)  # type: ignore[arg-type]
    assert listener.told == directly
    reached = [name for name in fails if name != "call" or "setup" not in fails]
    assert listener.exceptions == reached * 2
