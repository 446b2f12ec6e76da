"""Pytest's report of a case: the evidence instead of a traceback, and the result with it."""

from collections.abc import Generator

import pytest

from conformance.bus.errors import BenchError, SuiteError
from conformance.plugin.case_arguments import as_lacking
from conformance.plugin.failure import CaseFailed, as_pytest_shows
from conformance.plugin.items import CaseFunction
from conformance.plugin.outcome import attach, attach_not_run
from conformance.plugin.recorder import as_values
from conformance.plugin.state import RESULT, RunState, case_of, left_out
from conformance.plugin.suite_errors import (
    comes_from_here,
    is_own_case,
    suite_error,
    traceback_of,
)
from conformance.reporting.bus_log import Place
from conformance.run.evidence import trace_texts
from conformance.run.verdict import Verdict


class CaseReports:
    """The hook that makes a report of each case, in the process that runs it."""

    def __init__(self, state: RunState) -> None:
        """Take the state of the run."""
        self._state = state

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Put the evidence into the report, and the result with it."""
        report = yield
        if self._state.discovered:
            report.conformance_devices = self._state.discovered  # type: ignore[attr-defined]
            self._state.discovered = []
        error = call.excinfo.value if call.excinfo else None
        if call.when == "setup" and report.skipped:
            if RESULT not in item.stash and isinstance(item, CaseFunction):
                lacking = as_lacking(error)
                item.stash[RESULT] = left_out(
                    case_of(item), Verdict.NOT_TESTABLE, str(lacking), lacking.missing
                )
            if RESULT in item.stash:
                left = item.stash[RESULT]
                (attach_not_run if left.verdict is Verdict.NOT_RUN else attach)(item, left)
                report.user_properties = list(item.user_properties)
        elif call.when == "call" and _was_stopped(item):
            attach_not_run(item, item.stash[RESULT])
            report.user_properties = list(item.user_properties)
        elif call.when != "call" and report.failed:
            self._take_suite_error(item, report, error)
        if isinstance(error, BenchError):
            self._state.findings.bench_errors.append(error)
            report.longrepr = str(error)
        if call.when == "call" or isinstance(error, BenchError):
            self._state.heed(error)
        result = item.stash.get(RESULT, None)
        if result is None or call.when == "teardown":
            return report
        report.conformance = result.as_dict()  # type: ignore[attr-defined]
        place = self._place()
        if place is not None:
            report.conformance_frames = as_values(place)  # type: ignore[attr-defined]
        if report.skipped and isinstance(item, CaseFunction):
            path, line, _ = item.location
            report.longrepr = (path, (line or 0) + 1, str(error))
        elif call.excinfo is not None and isinstance(error, BenchError | CaseFailed):
            report.longrepr = as_pytest_shows(item, call.excinfo, result)
            if isinstance(error, BenchError):
                # A broken bench is an error of the set-up, whenever it shows.
                report.when = "setup"
            if isinstance(error, SuiteError):
                report.sections.append(("traceback", traceback_of(error)))
        elif report.failed:
            report.sections.append(("frames on the bus", "\n".join(trace_texts(result))))
        return report

    def _place(self) -> Place | None:
        """Return where the frames of the case are that runs."""
        log = self._state.log
        if log is None:
            return None
        log.flush()
        return log.place()

    def _take_suite_error(
        self, item: pytest.Item, report: pytest.TestReport, error: BaseException | None
    ) -> None:
        """Keep an error that a fixture of the suite has raised for one of its cases."""
        own = isinstance(item, CaseFunction) and is_own_case(item)
        if not own or error is None or isinstance(error, BenchError) or not comes_from_here(error):
            return
        found = suite_error(error)
        self._state.findings.bench_errors.append(found)
        if report.when == "setup":
            result = left_out(case_of(item), Verdict.BENCH_ERROR, str(found))
            attach(item, result)
            report.user_properties = list(item.user_properties)
            report.conformance = result.as_dict()  # type: ignore[attr-defined]


def _was_stopped(item: pytest.Item) -> bool:
    """Say whether a case was interrupted by a request to end the run."""
    return RESULT in item.stash and item.stash[RESULT].verdict is Verdict.NOT_RUN
