"""A run says how long it will take yet."""

import re
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast

import pytest
from plugin_runs import run, self_test

from conformance.device.known_objects import KnownObject
from conformance.plugin import time_left
from conformance.plugin.time_left import DiscoveryProgress, TimeLeft, in_words
from conformance.reporting.estimate import Estimate
from conformance.sdo.layout import Multiplexer

pytest_plugins = ["pytester"]
LINE = re.compile(
    r"^conformance: (\d+) of (\d+) cases in \d+ s, at this device's pace about .* left$"
)


@pytest.fixture(autouse=True)
def _impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the first word come behind three cases, and each that may."""
    for name, value in (("FIRST_CASES", 3), ("FIRST_PART", 0.0), ("OFTEN", 0.0), ("SHORT", -1.0)):
        monkeypatch.setattr(f"conformance.plugin.time_left.{name}", value)


@pytest.mark.parametrize("verbosity", [("-q",), (), ("-v",)], ids=["quiet", "plain", "verbose"])
def test_it_says_so_after_the_first_cases_and_then_again(
    pytester: pytest.Pytester, verbosity: tuple[str, ...]
) -> None:
    result = self_test(pytester, "--sdo-simulated", "-k", "abort.not-answered", *verbosity)
    said = [found for line in result.outlines if (found := LINE.match(line))]
    assert said, result.outlines
    assert int(said[0][1]) == 3
    assert len({found[2] for found in said}) == 1
    result.assert_outcomes(passed=int(said[0][2]))


@dataclass
class Process:
    """What pytest-xdist hands its hooks of a worker."""

    workerinput: dict[str, Any]


def report(name: str, worker: Process) -> pytest.TestReport:
    """Return what comes of a case in a worker."""
    made = pytest.TestReport(name, ("", 0, ""), {}, "passed", None, "call", duration=0.0)
    made.node = worker  # type: ignore[attr-defined]
    return made


def test_workers_are_taken_together(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    config = cast("pytest.Config", None)
    monkeypatch.setattr(time_left, "say", lambda _, line, **how: said.append(line))
    told = TimeLeft(config, Estimate())
    workers = [Process({"workerid": worker}) for worker in ("gw0", "gw1")]
    names = [f"cases/test_abort.py::abort.repeated[{number}]" for number in range(6)]
    for worker in workers:
        told.pytest_xdist_node_collection_finished(worker, names)
    for name in names[:3]:
        for worker in workers:
            told.pytest_runtest_logreport(report(name, worker))
            told.pytest_runtest_logfinish(name)
    assert said[0].startswith("3 of 12 cases in")


def test_nothing_is_said_where_nothing_is_wanted(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--sdo-simulated", "-k", "abort.not-answered", "-qq")
    result.stdout.no_fnmatch_line("conformance: *left*")


def test_nothing_is_estimated_where_nothing_runs(pytester: pytest.Pytester) -> None:
    """Cases that are not run are done at once, which says nothing of a device."""
    nowhere = ("--node-id=5", "--can-interface=slcan", "--can-channel=/dev/none")
    result = run(pytester, *nowhere, "-k", "matrix.idle")
    assert result.parseoutcomes().get("passed") is None
    result.stdout.fnmatch_lines(["*: the bus could not be opened"])
    result.stdout.no_fnmatch_line("*at this device's pace*")


def test_a_long_discovery_says_what_it_is_at(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("conformance.plugin.time_left.LOOK", 0.0)
    result = self_test(pytester, "--sdo-simulated", "-k", "abort.not-answered")
    result.stdout.fnmatch_lines(
        ["conformance: node 5: reading 2001h:00, object 1 of *", "*, object 2 of *, about * left"]
    )


def test_a_long_discovery_tells_what_it_takes_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    """It says so every 10 s, from what the objects before have taken."""
    said: list[str] = []
    clock = iter((0.0, 0.0, 9.9, 10.0, 15.0, 20.0))
    monkeypatch.setattr(time_left, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    monkeypatch.setattr(time_left, "say", lambda _, line: said.append(line))
    progress = DiscoveryProgress(cast("pytest.Config", None))
    entry = KnownObject(Multiplexer(0x2001))
    for number in range(5):
        progress(5, entry, number, 12)
    assert said == [
        "node 5: reading 2001h:00, object 3 of 12, about 50 s left",
        "node 5: reading 2001h:00, object 5 of 12, about 40 s left",
    ]


def test_a_slow_device_is_told_before_the_first_case(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("conformance.plugin.time_left.LONG_ENOUGH", 0.0)
    chosen = ("--sdo-simulated", "-k", "abort.not-answered")
    result = self_test(pytester, *chosen, "--sdo-answer-delay=0.01")
    result.stdout.fnmatch_lines(
        ["conformance: the device took 1* ms for an answer before the first case: *about * s"]
    )
    result = self_test(pytester, *chosen)  # whose clock jumps
    result.stdout.no_fnmatch_line("*before the first case*")


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.2, "0 s"), (99, "99 s"), (100, "2 min"), (5999, "100 min"), (6000, "2 h"), (43200, "12 h")],
)
def test_in_words(seconds: float, words: str) -> None:
    assert in_words(seconds) == words
