"""How long the rest of a run takes is foreseen by its requests."""

import pytest
from plugin_runs import self_test, the_report

from conformance.reference import dictionary
from conformance.reference.built_in_device import reference_entries
from conformance.reporting.estimate import Estimate, Taken
from conformance.run.verdict import NOT_TESTED, CaseResult
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry

pytest_plugins = ["pytester"]

DOMAIN = Multiplexer(0x2011)
SENT, RECEIVED = "T", "R"


KB = 1024

# How much longer or shorter than foreseen the rest of a run may take after each of these parts.
PARTS, MOST_OFF = (0.05, 0.1, 0.2, 0.4, 0.6, 0.8), 1 / 3
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
        self.tried[report.nodeid] = result.verdict not in NOT_TESTED


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
def test_the_rest_of_a_run_is_foreseen(pytester: pytest.Pytester) -> None:
    cases = Cases()
    arguments = ("--sdo-simulated", "--sdo-no-page", "-p", "no:xdist")
    assert self_test(pytester, *arguments, plugins=[cases]).ret == 0
    assert foreseen(cases) == pytest.approx([1.0] * len(PARTS), abs=MOST_OFF)


def test_what_a_device_serves_is_not_asked_for_by_each_case(pytester: pytest.Pytester) -> None:
    """One that has any sub-index of 1000h is asked for three of them once."""
    fault = "--sdo-fault=sub-index-of-variable-served"
    assert self_test(pytester, "--sdo-simulated", fault, "-k", "matrix.idle").ret == 0
    log = (the_report(pytester) / "bus.log").read_text("utf-8")
    assert [log.count(f"#400010{sub}00000000 T") for sub in ("FE", "FD", "7F")] == [1, 1, 1]
