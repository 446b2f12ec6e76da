"""The end of a run: results are gathered, reports written, the exit status settled."""

from collections.abc import Generator, Sequence
from pathlib import Path
from typing import Any

import pytest

from conformance.bus.errors import (
    BenchError,
    DeviceLost,
    FailedOnce,
    NotWritten,
    OtherDevice,
    SilentNode,
    SuiteError,
)
from conformance.device.effort import Effort
from conformance.device.known_deviations import KnownDeviation, write_deviations
from conformance.device.options import NO_PAGE, WRITE_DEVIATIONS
from conformance.plugin import budget
from conformance.plugin.arguments import ASKED
from conformance.plugin.exit_code import ExitCode
from conformance.plugin.printed_failures import PrintedFailures
from conformance.plugin.recorder import Recorder, as_place
from conformance.plugin.run_description import about_run
from conformance.plugin.selection import FOLDER
from conformance.plugin.state import RunState, uses_device
from conformance.plugin.terminal import SummaryTerminal
from conformance.plugin.terminal_summary import TerminalSummary
from conformance.plugin.workers import Controller
from conformance.reporting.cause_counts import causes_of
from conformance.reporting.requirements import untested
from conformance.run.drafting import draft
from conformance.run.known_failures import stale_entries
from conformance.run.verdict import CaseResult, Verdict
from conformance.sdo.rules import Cause

# Those of pytest; a plugin that runs a case again has others for the tries that do not count.
OUTCOMES = ("passed", "failed", "skipped")
# How a run has ended that was not ended before.
COMPLETE = "complete"


class FinalReport:
    """The hooks of the process that reports: the only one, or the controller of workers."""

    def __init__(
        self,
        state: RunState,
        controller: Controller | None,
        failures: PrintedFailures,
        *,
        shows_all: bool = False,
    ) -> None:
        """Take the state, and the controller where the work is done elsewhere.

        ``failures`` takes the printed failures. ``shows_all`` prints each case that fails, not only
        the first for each cause.
        """
        self._state = state
        self._controller = controller
        self._failures = failures
        self._shows_all = shows_all
        self._told: set[tuple[int, Cause]] = set()
        self._repeated: set[str] = set()
        self._stale: list[KnownDeviation] = []
        self._untested: list[str] = []
        self._suite_cases = 0
        self._suite_left_out = False
        self._recorder: Recorder | None = None

    @pytest.hookimpl(wrapper=True)
    def pytest_runtestloop(self, session: pytest.Session) -> Generator[None, object, object]:
        """Begin the record of the run before anything is opened."""
        cases = sum(map(uses_device, _items(session)))
        if (cases or self._controller is not None) and not session.config.option.collectonly:
            state = self._state
            about = about_run(session.config, state)
            page = not state.options.given[NO_PAGE]
            self._recorder = Recorder(state.report_dir, about, state.results, page=page)
            if self._controller is None:
                self._recorder.selected(cases)
            _show_dots_alone(session)
        return (yield)

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, ids: Sequence[str]) -> None:
        """Take how many cases a worker has."""
        if self._recorder is not None:
            self._recorder.selected(len(ids))

    # Results

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Collect results, of this process and of its workers."""
        values = getattr(report, "conformance", None)
        recorder = self._recorder
        if recorder is not None:
            for device in getattr(report, "conformance_devices", ()):
                recorder.device(device)
        if values is None or recorder is None or report.outcome not in OUTCOMES:
            return
        self._suite_cases += report.nodeid.startswith(f"{FOLDER}/")
        result = CaseResult.from_dict(values)
        recorder.case(result, as_place(getattr(report, "conformance_frames", None)))
        self._failures.take(report, result)
        self._tell_once(report, result)

    def _tell_once(self, report: pytest.TestReport, result: CaseResult) -> None:
        """Keep one failure block of each cause; with -v each case is shown."""
        if not report.failed or result.cause is None or self._shows_all:
            return
        cause = (result.node_id, result.cause)
        if cause in self._told:
            self._repeated.add(report.nodeid)
        self._told.add(cause)

    def pytest_report_teststatus(
        self, report: pytest.CollectReport | pytest.TestReport
    ) -> tuple[str, str, str] | None:
        """Show cases that passed with a remark apart from cases that passed."""
        if not isinstance(report, pytest.TestReport):
            return None  # a file that could not be collected
        if ("verdict", Verdict.NOT_RUN.value) in report.user_properties:
            # They are counted with their reason, and not as skipped.
            return "", "", "NOT RUN" if report.when == "setup" else ""
        values = getattr(report, "conformance", None)
        if values is None:
            return None
        if report.nodeid in self._repeated:
            return "failed for a cause shown above", "F", "FAILED"
        if not report.passed:
            return None
        if values["verdict"] == Verdict.NON_STRICT:
            return "non-strict", "n", "NON-STRICT"
        if values["verdict"] == Verdict.INFO:
            return "info", "i", "INFO"
        return None

    # The end

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Write the reports, and settle the exit status."""
        recorder = self._recorder
        if recorder is None:
            self._settle(session)
            return
        state, findings = self._state, self._state.findings
        for result in findings.unreached:
            recorder.case(result)
        if self._controller is not None:
            try:
                recorder.merge(self._logs_of_workers(self._controller), state.bus_log)
            except OSError as error:
                self._not_written(f"The logs of the workers cannot be merged: {error}.")
        if state.results:
            self._stale = stale_entries(
                state.options.deviations,
                recorder.run.by_device,
                partly=findings.partly,
                beside=findings.broken_beside,
            )
            if self._suite_cases or session.config.stash[ASKED]:
                self._untested = untested(
                    state.options.requirements,
                    recorder.run.by_device,
                    state.options.node_ids,
                )
            draft = state.options.given[WRITE_DEVIATIONS]
            if draft is not None:
                self._draft(draft, recorder.run.by_device)
        if trouble := recorder.trouble:
            self._not_written(trouble)
        self._settle(session)
        for trouble in recorder.end(self._about_end(session)):
            self._not_written(trouble)
        self._settle(session)
        state.results[:] = recorder.run.by_device
        self._failures.causes = causes_of(recorder.run)

    def _not_written(self, why: str) -> None:
        self._state.findings.bench_errors.append(NotWritten(why))

    def _settle(self, session: pytest.Session) -> None:
        """Settle the exit status."""
        findings = self._state.findings
        if self._state.stop.requests and session.exitstatus == pytest.ExitCode.INTERRUPTED:
            return
        # After a failure that came once no run is green; repeated failures are the device's anyway.
        once = [error for error in findings.bench_errors if isinstance(error, FailedOnce)]
        if len(once) < len(findings.bench_errors):
            session.exitstatus = _exit_code(findings.bench_errors)
        elif session.exitstatus == pytest.ExitCode.OK and findings.unrestored:
            session.exitstatus = ExitCode.BENCH_ERROR
        elif session.exitstatus == pytest.ExitCode.OK and (
            findings.unjudged or findings.beside or self._stale
        ):
            session.exitstatus = pytest.ExitCode.TESTS_FAILED
        elif session.exitstatus == pytest.ExitCode.OK and once:
            session.exitstatus = ExitCode.BENCH_ERROR
        elif session.exitstatus == pytest.ExitCode.OK and self._nothing_was_run():
            session.exitstatus = pytest.ExitCode.NO_TESTS_COLLECTED
        elif session.exitstatus == pytest.ExitCode.OK and self._leaves_out_the_suite(session):
            self._suite_left_out = True
            session.exitstatus = pytest.ExitCode.NO_TESTS_COLLECTED
        elif session.exitstatus == pytest.ExitCode.OK and self._untested:
            session.exitstatus = ExitCode.NOT_TESTED

    def _leaves_out_the_suite(self, session: pytest.Session) -> bool:
        """Say whether a green run would stand for a device that was not tested.

        Where the user names test files of his own, and these talk to it, he asked for no more.
        """
        if self._suite_cases or session.config.option.collectonly:
            return False
        if not session.config.stash[ASKED]:
            return False
        paths = (Path(argument.partition("::")[0]) for argument in session.config.args)
        folder = session.config.invocation_params.dir
        return not self._state.results or any((folder / path).is_dir() for path in paths)

    def _nothing_was_run(self) -> bool:
        results = self._state.results
        return bool(results) and all(result.verdict is Verdict.NOT_RUN for result in results)

    def _how(self, session: pytest.Session) -> str:
        """Say how the run has ended, if not by itself."""
        if session.exitstatus == pytest.ExitCode.INTERRUPTED and self._state.stop.requests:
            return self._state.stop.reason
        unreached = [
            result for result in self._state.findings.unreached if result.verdict is Verdict.NOT_RUN
        ]
        ended = str(session.shouldfail or session.shouldstop or "")
        out_of_time = any(result.missing == budget.OUT_OF_TIME for result in self._state.results)
        spent = budget.WHY if out_of_time else COMPLETE
        return ended or (unreached[0].actual if unreached else spent)

    def _about_end(self, session: pytest.Session) -> dict[str, Any]:
        """Return the last line of the record."""
        findings = self._state.findings
        properties = dict(findings.properties)
        if findings.unrestored:
            properties["not-restored"] = "; ".join(findings.unrestored)
        if findings.notes:
            properties["bench-notes"] = "; ".join(dict.fromkeys(findings.notes))
        if self._stale:
            properties["stale-deviations"] = "; ".join(map(str, self._stale))
        if self._untested:
            properties["required-but-not-tested"] = "; ".join(self._untested)
        troubles = [error for error in findings.bench_errors if not isinstance(error, DeviceLost)]
        return {
            "how": self._how(session),
            "exit_status": int(session.exitstatus),
            "properties": properties,
            "bench_errors": list(map(str, troubles)),
            "unrestored": findings.unrestored,
        }

    def _draft(self, path: Path, results: Sequence[CaseResult]) -> None:
        state = self._state
        drafted = draft(
            results,
            state.options.deviations,
            strict=state.options.strict,
            beside=state.findings.broken_beside,
        )
        try:
            write_deviations(path, drafted)
        except OSError as error:
            self._not_written(f"The known deviations cannot be written: {error}.")

    def _logs_of_workers(self, controller: Controller) -> list[Path]:
        # One that has not ended is writing still.
        logs = map(self._state.bus_log_of, sorted(controller.finished))
        return [log for log in logs if log.is_file()]

    def pytest_terminal_summary(self, terminalreporter: SummaryTerminal) -> None:
        """Say what the counts do not: remarks, what is missing, what is wrong with the bench."""
        whole = self._shows_all or self._state.options.effort is Effort.THOROUGH
        summary = TerminalSummary(terminalreporter, self._state, whole=whole)
        left_out = self._suite_left_out
        summary.write(self._failures.causes, self._stale, self._untested, left_out=left_out)


def _items(session: pytest.Session) -> Sequence[pytest.Item]:
    """Return the items of this process; up to pytest 7.4 a controller has not even none."""
    return getattr(session, "items", ())


def _show_dots_alone(session: pytest.Session) -> None:
    """Have pytest print no files of the suite: the order of cases jumps between them.

    The cases of a self-test were 406 lines, each with the name of a file.
    """
    terminal: SummaryTerminal | None = session.config.pluginmanager.get_plugin("terminalreporter")
    if terminal is None or session.config.getoption("verbose") != 0:
        return
    if any(item.nodeid.startswith(f"{FOLDER}/") for item in _items(session)):
        terminal.showfspath = False


def _exit_code(errors: list[BenchError]) -> ExitCode | pytest.ExitCode:
    kinds = {type(error) for error in errors}
    if OtherDevice in kinds:
        return pytest.ExitCode.USAGE_ERROR
    if not kinds <= {SilentNode, DeviceLost, SuiteError}:
        return ExitCode.BENCH_ERROR
    if SuiteError in kinds:
        return ExitCode.SUITE_ERROR
    return ExitCode.SILENT_NODE if SilentNode in kinds else ExitCode.DEVICE_LOST
