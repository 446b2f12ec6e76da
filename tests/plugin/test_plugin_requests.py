"""What a run costs is counted in requests: so many at the most, and foreseen."""

from dataclasses import dataclass
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


@dataclass(frozen=True)
class Counts:
    """How often the suite has waited for an answer, and how many frames it has sent."""

    answers: int
    frames: int

    def __le__(self, other: "Counts") -> bool:
        return self.answers <= other.answers and self.frames <= other.frames


def counted(log: Path) -> Counts:
    """Count what a run has cost."""
    directions = [line.rpartition(" ")[2] for line in log.read_text("utf-8").splitlines()]
    answers = sum(direction == RECEIVED for direction, _ in groupby(directions))
    return Counts(answers, directions.count(SENT))


# On a device with a domain of 4 KB: 49,300 answers and 63,900 frames when this was written, of
# which 9,363 are the segments of one block download beyond 16 bits, with 75 answers. The self-test
# takes less: 41,000 answers and 55,000 frames. A few per cent hang on the order of the cases.
# Without block downloads long values go in segments: 67,000 answers in a whole run, 107,000 when
# each case that failed or looked for room put the long value of the domain back. That shows in the
# scripts, which take 33,100 answers and 34,000 frames of it. A right device with block downloads
# and no block uploads takes 59,600 answers in a whole run, of which 18,700 are the one value beyond
# 16 bits, and 24,900 answers and 27,500 frames in the scripts.
LENGTH = 4096
SOUND, WITHOUT_BLOCKS = (50_500, 65_500), (34_500, 35_500)
WITHOUT_UPLOADS = (25_500, 28_500)
REFUSED_IN_SILENCE = "--sdo-fault=block-refused-in-silence"
SCRIPTS = "not matrix and not random and not beyond"

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


@pytest.fixture
def long_domain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give the built-in device a domain of 4 KB."""

    def entries(node_id: int) -> dict[Multiplexer, Entry]:
        found = reference_entries(node_id)
        found[DOMAIN].value = bytes(position % 251 for position in range(LENGTH))
        return found

    monkeypatch.setattr(dictionary, "reference_entries", entries)


@pytest.mark.usefixtures("long_domain")
def test_requests_of_a_run(pytester: pytest.Pytester) -> None:
    cases = Cases()
    arguments = ("--sdo-simulated", "--sdo-no-page", "-p", "no:xdist")
    assert self_test(pytester, *arguments, plugins=[cases]).ret == 0
    assert counted(the_report(pytester) / "bus.log") <= Counts(*SOUND)
    assert foreseen(cases) == pytest.approx([1.0] * len(PARTS), abs=THIRD)


@pytest.mark.usefixtures("long_domain")
def test_requests_of_a_run_on_a_device_that_fails(pytester: pytest.Pytester) -> None:
    self_test(pytester, "--sdo-simulated", "--sdo-no-page", REFUSED_IN_SILENCE, "-k", SCRIPTS)
    assert counted(the_report(pytester) / "bus.log") <= Counts(*WITHOUT_BLOCKS)


@pytest.mark.usefixtures("long_domain")
def test_requests_of_a_run_on_a_device_without_block_uploads(pytester: pytest.Pytester) -> None:
    arguments = ("--sdo-simulated", "--sdo-no-page", "--sdo-fault=no-block-upload", "-k", SCRIPTS)
    assert self_test(pytester, *arguments).ret == 0
    assert counted(the_report(pytester) / "bus.log") <= Counts(*WITHOUT_UPLOADS)


def test_what_a_device_serves_is_not_asked_for_by_each_case(pytester: pytest.Pytester) -> None:
    """One that has any sub-index of 1000h is asked for three of them once."""
    fault = "--sdo-fault=sub-index-of-variable-served"
    assert self_test(pytester, "--sdo-simulated", fault, "-k", "matrix.idle").ret == 0
    log = (the_report(pytester) / "bus.log").read_text("utf-8")
    assert [log.count(f"#400010{sub}00000000 T") for sub in ("FE", "FD", "7F")] == [1, 1, 1]
