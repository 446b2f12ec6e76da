"""How many requests each case of a run sends, by the log of its bus.

A request counts when it is answered: the segments of a sub-block are one, as a client that sends
them waits but once.
"""

from collections.abc import Generator, Sequence
from pathlib import Path

import pytest
from case_runs import run_cases

from conformance.plugin.items import ordered
from conformance.run.verdict import Verdict


class Counter:
    """A pytest plugin that counts the requests of each case, by the log of the bus."""

    def __init__(self) -> None:
        """Nothing has been run yet."""
        self.verdicts: dict[str, Verdict] = {}
        self.services: dict[str, str] = {}
        self._places: dict[str, tuple[int, int]] = {}
        self._answered = [0]

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take the place of the frames of a case."""
        values = getattr(report, "conformance", None)
        place = getattr(report, "conformance_frames", None)
        if values is not None and place is not None:
            self.verdicts[values["case_id"]] = Verdict(values["verdict"])
            self.services[values["case_id"]] = values["service"]
            self._places[values["case_id"]] = (place["first"], place["last"])

    @pytest.hookimpl(trylast=True)
    def pytest_unconfigure(self, config: pytest.Config) -> None:
        """Read the log while it is there."""
        (log,) = Path(config.getoption("sdo_report_dir")).glob("*/bus.log")
        sent = False
        for line in log.read_text("utf-8").splitlines():
            before, sent = sent, line.endswith(" T")
            self._answered.append(self._answered[-1] + (before and not sent))

    @property
    def requests(self) -> dict[str, int]:
        """How many requests each case has sent: one at least, if it has sent anything."""
        return {
            case: max(self._answered[last] - self._answered[first - 1], 1) if first <= last else 0
            for case, (first, last) in self._places.items()
        }

    @property
    def total(self) -> int:
        """How many requests the run has sent, with those beside the cases."""
        return self._answered[-1]


class ByFile:
    """A pytest plugin that leaves the cases in the order of the files."""

    @pytest.hookimpl(wrapper=True)
    def pytest_collection_modifyitems(
        self, items: list[pytest.Item]
    ) -> Generator[None, object, object]:
        """Undo the order of a run, but for what judges it."""
        before = ordered(items, as_files=True)
        outcome = yield
        items[:] = before
        return outcome


def count(*arguments: str, plugins: Sequence[object] = ()) -> Counter:
    """Count what the cases send to the built-in device."""
    counter = Counter()
    run = run_cases(None, *arguments, plugins=[counter, *plugins])
    if run.exit_code:
        raise SystemExit(f"the self-test fails: {run.exit_code}")
    return counter
