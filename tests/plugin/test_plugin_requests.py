"""What a run costs is counted in requests: so many at the most, and foreseen."""

from itertools import groupby
from pathlib import Path

import pytest
from plugin_runs import self_test, the_report

from conformance.reference import dictionary
from conformance.reference.built_in_device import reference_entries
from conformance.reporting.estimate import UNTRIED, Estimate, Taken
from conformance.run.verdict import CaseResult
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry

pytest_plugins = ["pytester"]

DOMAIN = Multiplexer(0x2011)
SENT, RECEIVED = "T", "R"


def counted(log: Path) -> tuple[int, int]:
    """Return how many frames the suite has sent, and how often it has waited for an answer."""
    directions = [line.rpartition(" ")[2] for line in log.read_text("utf-8").splitlines()]
    answers = sum(direction == RECEIVED for direction, _ in groupby(directions))
    return directions.count(SENT), answers


# On a device with a domain of 4 KB: 51,000 answers and 66,200 frames when this was written, of
# which 9,363 are the segments of one block download beyond 16 bits, with 75 answers. The self-test
# takes less: 40,600 answers and 54,900 frames. A few per cent hang on the order of the cases.
LENGTH, MOST_ANSWERS, MOST_FRAMES = 4096, 52_000, 67_000


# How much longer or shorter than foreseen the rest of a run may take after each of these parts.
PARTS, THIRD = (0.05, 0.1, 0.2, 0.4, 0.6, 0.8), 1 / 3
ANSWER = 0.005


class Cases:
    """Counts how many answers each case has waited for."""

    def __init__(self) -> None:
        self.answers: dict[str, int] = {}
        self.tried: dict[str, bool] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        values = getattr(report, "conformance", None)
        if values is None:
            return
        result = CaseResult.from_dict(values)
        self.answers[report.nodeid] = result.answers
        self.tried[report.nodeid] = result.verdict not in UNTRIED


def foreseen(cases: Cases) -> list[float]:
    """Return the rest that was foreseen by the rest that came, after the PARTS of a run.

    Nothing but answers takes time in it.
    """
    estimate = Estimate()
    estimate.select(cases.answers)
    left, parts, found = sum(cases.answers.values()) * ANSWER, list(PARTS), []
    for name, count in cases.answers.items():
        seconds = count * ANSWER
        estimate.finish(name, Taken(seconds, count, seconds, tried=cases.tried[name]))
        left -= seconds
        if parts and estimate.part >= parts[0]:
            found.append(estimate.left() / left)
            parts.pop(0)
    return found


def test_requests_of_a_run(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    def entries(node_id: int) -> dict[Multiplexer, Entry]:
        found = reference_entries(node_id)
        found[DOMAIN].value = bytes(position % 251 for position in range(LENGTH))
        return found

    monkeypatch.setattr(dictionary, "reference_entries", entries)
    cases = Cases()
    arguments = ("--sdo-simulated", "--sdo-no-page", "-p", "no:xdist")
    assert self_test(pytester, *arguments, plugins=[cases]).ret == 0
    frames, answers = counted(the_report(pytester) / "bus.log")
    assert answers <= MOST_ANSWERS
    assert frames <= MOST_FRAMES
    assert foreseen(cases) == pytest.approx([1.0] * len(PARTS), abs=THIRD)
