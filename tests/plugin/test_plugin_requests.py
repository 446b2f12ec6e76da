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


# On a device with a domain of 4 KB: 42,800 answers and 59,700 frames when this was written, of
# which 9,363 are the segments of one block download beyond 16 bits, with 75 answers. A few per cent
# hang on the order of the cases. Without block downloads long values go in segments: 57,000 answers
# in a whole run, as many on a right device without block uploads, 18,700 of them for the one value
# beyond 16 bits. That shows in the scripts, which take 22,500 answers of it. A domain of 64 KB
# takes 51,400 answers, 9,400 of which read it when the run begins, and 50,100 where there are no
# block uploads: then it is not read.
KB = 1024
SOUND, WITHOUT_BLOCKS, WITHOUT_UPLOADS = (44_500, 61_500), (24_000, 25_000), (24_000, 26_500)
# The scripts take 36,300 and 15,900 of them.
VERY_LONG, VERY_LONG_IN_SEGMENTS = (38_000, 59_000), (16_700, 18_200)
# Strings and domains that always have 300 bytes cost 37,900 answers; with 650 they are left alone.
# The scripts and a state of the matrix take 22,400 and 14,500.
ALWAYS_LONG = {
    "values-of-fixed-length-300": (23_500, 42_500),
    "values-of-fixed-length-650": (15_200, 16_400),
}
# One whose short values leave the end of a long one behind them reads 4 KB for ever: 22,100 in the
# scripts, where they take another object or read it in blocks.
LASTING = (24_000, 31_000)
REFUSED_IN_SILENCE = "--sdo-fault=block-refused-in-silence"
SCRIPTS = "not matrix and not random and not beyond"
AND_A_STATE = "(not matrix or matrix.block-download-inside) and not random and not beyond"

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
def long_domain(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    """Give the built-in device a domain of 4 KB, or of another size."""
    size = getattr(request, "param", 4 * KB)

    def entries(node_id: int) -> dict[Multiplexer, Entry]:
        found = reference_entries(node_id)
        found[DOMAIN].value = bytes(position % 251 for position in range(size))
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


@pytest.mark.usefixtures("long_domain")
def test_requests_of_a_run_on_a_device_whose_domain_is_never_short(
    pytester: pytest.Pytester,
) -> None:
    """Cases take another object where length is not the point."""
    fault = "--sdo-fault=shorter-value-keeps-tail"
    self_test(pytester, "--sdo-simulated", "--sdo-no-page", fault, "-k", SCRIPTS)
    assert counted(the_report(pytester) / "bus.log") <= Counts(*LASTING)


@pytest.mark.parametrize("long_domain", [64 * KB], indirect=True)
@pytest.mark.usefixtures("long_domain")
@pytest.mark.parametrize(
    ("options", "bound"),
    [((), VERY_LONG), (("--sdo-fault=no-block-upload",), VERY_LONG_IN_SEGMENTS)],
    ids=["blocks", "segments"],
)
def test_requests_of_a_run_on_a_device_with_a_very_long_domain(
    pytester: pytest.Pytester, options: tuple[str, ...], bound: tuple[int, int]
) -> None:
    arguments = ("--sdo-simulated", "--sdo-no-page", *options, "-k", SCRIPTS)
    assert self_test(pytester, *arguments).ret == 0
    assert counted(the_report(pytester) / "bus.log") <= Counts(*bound)


@pytest.mark.parametrize("server", ALWAYS_LONG)
def test_requests_of_a_run_on_a_device_whose_values_are_always_long(
    pytester: pytest.Pytester, server: str
) -> None:
    arguments = ("--sdo-simulated", "--sdo-no-page", f"--sdo-fault={server}", "-k", AND_A_STATE)
    assert self_test(pytester, *arguments).ret == 0
    assert counted(the_report(pytester) / "bus.log") <= Counts(*ALWAYS_LONG[server])


def test_what_a_device_serves_is_not_asked_for_by_each_case(pytester: pytest.Pytester) -> None:
    """One that has any sub-index of 1000h is asked for three of them once."""
    fault = "--sdo-fault=sub-index-of-variable-served"
    assert self_test(pytester, "--sdo-simulated", fault, "-k", "matrix.idle").ret == 0
    log = (the_report(pytester) / "bus.log").read_text("utf-8")
    assert [log.count(f"#400010{sub}00000000 T") for sub in ("FE", "FD", "7F")] == [1, 1, 1]
