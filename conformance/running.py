"""A run within pytest: the bench is opened, each case judged, the reports written."""

from collections.abc import Callable, Generator
from contextlib import AbstractContextManager
from enum import IntEnum

import pytest

from conformance.bus.errors import BenchError, BusOff, DeviceLost, InterfaceLost, SilentNode
from conformance.bus.link import Captured
from conformance.collection import CaseFunction
from conformance.device.device import NotTestable
from conformance.faults.hosting import simulated_bus, virtual_host
from conformance.outcome import CaseFailed, Evidence, SummaryTerminal, attach, end_with
from conformance.reporting.bus_log import BusLog
from conformance.reporting.junit import write_junit
from conformance.reporting.summary import run_properties, summary_lines
from conformance.run.bench import Bench
from conformance.run.verdict import CaseResult, Verdict
from conformance.state import CASE_RUN, RESULT, RunState, case_of

# The case that judges what came too late; where it was not selected, the run itself does.
LATE_ANSWERS = "run.no-late-response"


class ExitCode(IntEnum):
    """What pytest's own exit codes do not tell: it is the bench that is broken."""

    SILENT_NODE = 10
    BENCH_ERROR = 11
    DEVICE_LOST = 12


class Running:
    """The hooks of a run that has a device."""

    def __init__(self, config: pytest.Config, state: RunState) -> None:
        """Take the state; nothing is opened before the first case."""
        self._config = config
        self._state = state

    # The bench

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool | None:
        """Open the bench; where that fails, or a node is silent, no case is run."""
        uses_device = any(
            "device_session" in getattr(item, "fixturenames", ()) for item in session.items
        )
        if not uses_device or self._config.option.collectonly or session.testsfailed:
            return None
        try:
            self._open()
        except BenchError as error:
            self._state.bench_errors.append(error)
            return True
        return None

    def _open(self) -> None:
        state, options = self._state, self._state.options
        try:
            state.report_dir.mkdir(parents=True)
            state.log = BusLog(state.report_dir / "bus.log", options.run.bus.channel or "can0")
        except OSError as error:
            raise BenchError(
                f"The report folder {state.report_dir} cannot be made: {error}. "
                "Choose another with --report-dir=DIR."
            ) from error
        state.bench = self._bench(state.log.write)
        state.bench.open()
        devices = [session.device for session in state.bench.sessions.values()]
        state.properties = run_properties(options.run, devices)

    def _bench(self, listener: Callable[[Captured], None]) -> Bench:
        options = self._state.options
        run = options.run
        if options.simulated:
            bus = simulated_bus(run.node_ids, options.server)
            return Bench(run, [], listener, lambda settings: bus)
        hosts: list[AbstractContextManager[object]] = []
        if options.self_test and run.bus.channel is not None:
            hosts += [
                virtual_host(run.bus.channel, node_id, options.server) for node_id in run.node_ids
            ]
        return Bench(run, hosts, listener)

    # Cases

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Generator[None, object, object]:
        """Judge the case when its function has ended, before anything is torn down."""
        run = item.stash.get(CASE_RUN, None)
        if run is None:
            return (yield)
        error: BaseException | None = None
        outcome: object = None
        try:
            outcome = yield
        except KeyboardInterrupt:
            run.conclude(None)  # the values are put back all the same
            raise
        except BaseException as caught:
            # Also what derives from BaseException alone, as the outcomes of pytest do.
            error = caught
        told = isinstance(error, pytest.skip.Exception | pytest.xfail.Exception)
        result = run.conclude(NotTestable(str(error)) if told else error)
        item.stash[RESULT] = result
        attach(item, result)
        state = self._state
        state.judged_late_answers |= result.case_id == LATE_ANSWERS
        if state.session(result.node_id).lost:
            state.bench_errors.append(run.sdo.lost())
            item.session.shouldstop = f"node {result.node_id} was lost in {result.case_id}"
        if told and error is not None and result.verdict is Verdict.NOT_TESTABLE:
            raise error
        end_with(result, error, strict=state.options.strict)
        return outcome

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Put the evidence into the report, and the result with it."""
        report = yield
        error = call.excinfo.value if call.excinfo else None
        if call.when == "setup" and report.skipped and isinstance(item, CaseFunction):
            item.stash[RESULT] = _not_set_up(item, str(error))
            attach(item, item.stash[RESULT])
            report.user_properties = list(item.user_properties)
        if isinstance(error, BenchError):
            self._state.bench_errors.append(error)
            report.longrepr = str(error)
            if isinstance(error, InterfaceLost | BusOff):
                item.session.shouldstop = "the bus is gone"
        result = item.stash.get(RESULT, None)
        if result is None or call.when == "teardown":
            return report
        report.conformance = result.as_dict()  # type: ignore[attr-defined]
        if report.skipped and isinstance(item, CaseFunction):
            path, line, _ = item.location
            report.longrepr = (path, (line or 0) + 1, str(error))
        elif isinstance(error, BenchError):
            # A broken bench is an error of the set-up, whenever it shows.
            report.when = "setup"
            report.longrepr = Evidence(result)  # type: ignore[assignment]
        elif isinstance(error, CaseFailed):
            report.longrepr = Evidence(result)  # type: ignore[assignment]
        elif report.failed:
            report.sections.append(("frames on the bus", "\n".join(result.trace)))
        return report

    # Results

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Collect results."""
        values = getattr(report, "conformance", None)
        if values is not None:
            self._state.results.append(CaseResult.from_dict(values))

    def pytest_report_teststatus(self, report: pytest.TestReport) -> tuple[str, str, str] | None:
        """Show what passed with a remark apart from what passed."""
        values = getattr(report, "conformance", None)
        if values is None or not report.passed:
            return None
        if values["verdict"] == Verdict.NON_STRICT:
            return "non-strict", "n", "NON-STRICT"
        if values["verdict"] == Verdict.INFO:
            return "info", "i", "INFO"
        return None

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Close the bench, write the reports, and settle the exit status."""
        state = self._state
        if state.bench is not None:
            try:
                state.bench.close()
            except BenchError as error:
                state.bench_errors.append(error)
        if state.log is not None:
            state.log.close()
        if state.results:
            state.report_dir.mkdir(parents=True, exist_ok=True)
            write_junit(
                state.report_dir / "junit.xml",
                state.results,
                state.properties,
                timestamp=f"{state.begun:%Y-%m-%dT%H:%M:%S}",
                strict=state.options.strict,
            )
        if state.bench_errors:
            session.exitstatus = _exit_code(state.bench_errors)
        elif session.exitstatus == pytest.ExitCode.OK and self._unjudged():
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def _unjudged(self) -> list[str]:
        """What the run saw on the way and no case has judged, for want of being selected."""
        if self._state.judged_late_answers or self._state.bench is None:
            return []
        return [
            f"{incident.case_id}: {incident.violation}"
            for session in self._state.bench.sessions.values()
            for incident in session.whole_run.late
        ]

    def pytest_terminal_summary(self, terminalreporter: SummaryTerminal) -> None:
        """Say what the counts do not: remarks, what is missing, what is wrong with the bench."""
        state, write = self._state, terminalreporter.write_line
        terminalreporter.ensure_newline()
        if state.results:
            terminalreporter.section("conformance")
            for line in summary_lines(state.results):
                write(line)
            write(f"reports: {state.report_dir}")
        for unjudged in self._unjudged():
            write(f"came too late, after {unjudged}", red=True)
        sessions = state.bench.sessions.values() if state.bench else ()
        for session in sessions:
            for mux, value in session.restorer.unrestored.items():
                write(f"not restored: write {value} to {mux} of node {session.device.node_id}")
        if state.bench_errors:
            terminalreporter.section("the bench", red=True)
            for error in dict.fromkeys(map(str, state.bench_errors)):
                write(error)


def _not_set_up(item: CaseFunction, reason: str) -> CaseResult:
    case = case_of(item)
    rule = case.rule
    return CaseResult(
        case.case_id,
        case.service,
        case.node_id,
        rule.level.value,
        rule.clause,
        rule.sentence,
        Verdict.NOT_TESTABLE,
        rows=list(rule.rows),
        actual=reason.removeprefix(f"{Verdict.NOT_TESTABLE}: "),
    )


def _exit_code(errors: list[BenchError]) -> ExitCode:
    kinds = {type(error) for error in errors}
    if kinds <= {DeviceLost}:
        return ExitCode.DEVICE_LOST
    return ExitCode.SILENT_NODE if kinds <= {SilentNode} else ExitCode.BENCH_ERROR
