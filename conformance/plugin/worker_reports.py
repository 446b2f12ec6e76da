"""How reports travel between the processes of pytest-xdist: all of a case at once, in one piece.

pytest-xdist sends six messages for each case. It takes a report apart and writes value by value, in
Python. Of sixteen devices side by side that took more time than all else the controller does.
"""

from collections.abc import Generator
from typing import Any

import pytest

from conformance.plugin.plain_values import pack, unpack

PARCEL = "conformance-parcel"
AROUND = "conformance_around"
BUNDLED = pytest.StashKey[bool]()

Values = dict[str, Any]


class Bundle:
    """The hooks of pytest as a case in a worker calls them.

    What is told of the case waits until it is over. Then its reports go together, as one report
    with the others ``AROUND`` it; those of a case that failed go one by one, because pytest-xdist
    counts failures report by report.
    """

    def __init__(self, hooks: Any, config: pytest.Config) -> None:
        """Take the hooks that pytest would call."""
        self._hooks = hooks
        self._config = config
        self._reports: list[pytest.TestReport] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._hooks, name)

    def pytest_runtest_logstart(self, *, nodeid: str, location: tuple[str, int, str]) -> None:
        """Wait."""

    def pytest_runtest_logreport(self, *, report: pytest.TestReport) -> None:
        """Keep a report."""
        self._reports.append(report)

    def pytest_runtest_logfinish(self, *, nodeid: str, location: tuple[str, int, str]) -> None:
        """Tell all that is known of the case."""
        reports, self._reports = self._reports, []
        if not reports or any(report.failed for report in reports):
            self._hooks.pytest_runtest_logstart(nodeid=nodeid, location=location)
            for report in reports:
                self._hooks.pytest_runtest_logreport(report=report)
            self._hooks.pytest_runtest_logfinish(nodeid=nodeid, location=location)
            return
        place = next((at for at, report in enumerate(reports) if report.when == "call"), 0)
        first, last = (
            [
                self._hooks.pytest_report_to_serializable(config=self._config, report=report)
                for report in part
            ]
            for part in (reports[:place], reports[place + 1 :])
        )
        setattr(reports[place], AROUND, (first, last))
        self._hooks.pytest_runtest_logreport(report=reports[place])


class Sender:
    """The hooks of a worker."""

    def __init__(self, config: pytest.Config) -> None:
        """Have cases bundle their reports from now on."""
        config.stash[BUNDLED] = True

    @pytest.hookimpl(wrapper=True)
    def pytest_report_to_serializable(self) -> Generator[None, Values | None, Values | None]:
        """Pack what pytest and other plugins have made of a report: strings, numbers, lists.

        What holds anything else goes as it would without this.
        """
        values = yield
        if values is None:
            return None
        try:
            return {PARCEL: pack(values)}
        except TypeError:
            return values


class Receiver:
    """The hooks of the controller."""

    def __init__(self, config: pytest.Config) -> None:
        """Take the hooks that are told of each case."""
        self._config = config

    @pytest.hookimpl(tryfirst=True)
    def pytest_report_from_serializable(self, data: Values) -> None:
        """Unpack a report for the plugin that reads it."""
        if PARCEL in data:
            data.update(unpack(data.pop(PARCEL)))

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> Generator[None, None, None]:
        """Tell of a bundle as of any other case."""
        first, last = report.__dict__.pop(AROUND, (None, None))
        if first is None:
            yield
            return
        hook = self._config.hook
        hook.pytest_runtest_logstart(nodeid=report.nodeid, location=report.location)
        self._tell(first, report)
        yield
        self._tell(last, report)
        hook.pytest_runtest_logfinish(nodeid=report.nodeid, location=report.location)

    def _tell(self, bundled: list[Values], beside: pytest.TestReport) -> None:
        hook = self._config.hook
        for values in bundled:
            report = hook.pytest_report_from_serializable(config=self._config, data=values)
            report.node = beside.node
            hook.pytest_runtest_logreport(report=report)
