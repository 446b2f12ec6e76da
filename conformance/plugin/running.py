"""A run within pytest: the bench is opened, each case judged; ``final_report`` reports on it."""

from collections import defaultdict
from collections.abc import Callable, Generator, Sequence
from contextlib import AbstractContextManager, suppress
from enum import IntEnum
from functools import partial
from typing import Any, NoReturn

import can
import pytest

from conformance.bus.errors import (
    BenchError,
    BusOff,
    DeviceLost,
    InterfaceLost,
    NotWritten,
    SuiteError,
    TransmitBufferFull,
)
from conformance.bus.link import Captured, Direction
from conformance.bus.opening import BusSettings, open_bus
from conformance.bus.stop import RunStopped
from conformance.device.known_deviations import unknown_case
from conformance.faults.hosting import simulated_bus, virtual_host
from conformance.plugin.about import about_device
from conformance.plugin.attempts import begin, conclude_tries, is_told
from conformance.plugin.items import CaseFunction
from conformance.plugin.outcome import (
    CaseFailed,
    Evidence,
    attach,
    attach_not_run,
    end_with,
)
from conformance.plugin.recorder import as_values
from conformance.plugin.state import (
    CASE_RUN,
    REACHED,
    RESULT,
    RunState,
    case_of,
    left_out,
    uses_device,
)
from conformance.plugin.suite_errors import (
    comes_from_here,
    is_own_case,
    suite_error,
    traceback_of,
)
from conformance.plugin.time_left import DiscoveryProgress
from conformance.plugin.unrestored import Values
from conformance.plugin.workers import belongs_here, hand_back
from conformance.reporting.bus_log import BusLog
from conformance.run.accounting import Scope, account
from conformance.run.bench import Bench
from conformance.run.losses import MOST_IN_A_ROW, Losses
from conformance.run.session import CaseRun, DeviceSession
from conformance.run.verdict import CaseResult, Verdict
from conformance.sdo.rules import RULES

# The case that judges what came too late; where it was not selected, the run itself does.
LATE_ANSWERS = "run.no-late-response"
# In so many cases one after another a full transmit buffer is a cable that is out.
MOST_FULL = 3


class ExitCode(IntEnum):
    """What pytest's own exit codes do not tell: it is the bench that is broken."""

    SILENT_NODE = 10
    BENCH_ERROR = 11
    DEVICE_LOST = 12
    SUITE_ERROR = 13


class Running:
    """The hooks of a process that talks to devices."""

    def __init__(self, config: pytest.Config, state: RunState) -> None:
        """Take the state; nothing is opened before the first case."""
        self._config = config
        self._state = state
        self._has_begun = False
        self._full_in_a_row = 0
        self._losses: defaultdict[int, Losses] = defaultdict(Losses)
        self._scope: Scope | None = None
        # What was discovered of the devices: it goes with the first report.
        self._discovered: list[dict[str, Any]] = []
        self._values: Values | None = None

    def pytest_collection_modifyitems(
        self, config: pytest.Config, items: list[pytest.Item]
    ) -> None:
        """Hold the known deviations to the cases and rules that there are."""
        options = self._state.options
        if not options.deviations or not options.run.node_ids:
            return
        some = config.args_source is pytest.Config.ArgsSource.ARGS or config.getoption(
            "lf", default=False
        )
        cases = [case_of(item) for item in items]
        self._scope = Scope(options.deviations, [case.tested_rules for case in cases])
        if some:
            self._state.findings.partly += map(str, self._scope.shared)
            return
        unknown = unknown_case(
            options.deviations,
            (case.case_id for case in cases),
            {rule.id for rule in RULES}.union(*[case.tested_rules for case in cases]),
        )
        if unknown is None:
            return
        if not options.share.worker:
            raise pytest.UsageError(unknown)
        self._state.findings.wrong_use = unknown
        self._leave_out_all("wrong use")

    def pytest_deselected(self, items: Sequence[pytest.Item]) -> None:
        """Note which known deviations a selection says nothing of: it leaves out their cases."""
        if self._scope is None:
            return
        cases = [case_of(item) for item in items]
        self._state.findings.partly += [
            str(known)
            for known in self._scope.shared
            if any(self._scope.is_about(known, case.case_id, case.tested_rules) for case in cases)
        ]

    # The bench

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Open the bench; no case is run on a device that is silent, or behind a broken bus."""
        wanted = any(uses_device(item) for item in session.items)
        if not wanted or self._config.option.collectonly or session.testsfailed:
            return
        self._has_begun = True
        try:
            self._open()
        except BenchError as error:
            self._state.findings.bench_errors.append(error)
            self._leave_out_all("the bus could not be opened")
        except RunStopped as stopped:
            self._leave_out_all(str(stopped))
            session.shouldstop = str(stopped)

    def _open(self) -> None:
        state, options = self._state, self._state.options
        try:
            state.report_dir.mkdir(parents=True, exist_ok=True)
            log = BusLog(state.bus_log, options.run.bus.channel or "can0")
        except OSError as error:
            raise BenchError(
                f"The report folder {state.report_dir} cannot be made: {error}. "
                "Choose another with --sdo-report-dir=DIR."
            ) from error
        state.log = log
        state.bench = self._bench(self._listener(log))
        state.bench.open()
        for node_id, silence in state.bench.silent.items():
            state.findings.bench_errors.append(silence)
            lost = isinstance(silence, DeviceLost)
            state.findings.out[node_id] = "lost before the first case" if lost else "silent"
        for session in state.bench.sessions.values():
            about = about_device(session.device, alone=len(options.node_ids) == 1)
            state.findings.properties |= about["properties"]
            self._discovered.append(about)

    def _listener(self, log: BusLog) -> Callable[[Captured], None]:
        share, neighbours = self._state.options.share, self._state.options.run.neighbours

        def listen(captured: Captured) -> None:
            if belongs_here(captured, share, neighbours):
                log.write(captured)

        return listen if neighbours else log.write

    def _bench(self, listener: Callable[[Captured], None]) -> Bench:
        options = self._state.options
        run = options.run
        if options.simulated:
            bus = simulated_bus(
                run.node_ids,
                options.server,
                options.answer_delay,
                server_timeout=run.server_timeout,
            )
            return self._bench_with(listener, [], lambda settings: bus)
        hosts: list[AbstractContextManager[object]] = []
        if options.self_test and run.bus.channel is not None:
            hosts += [
                virtual_host(
                    run.bus.channel,
                    node_id,
                    options.server,
                    options.answer_delay,
                    server_timeout=run.server_timeout,
                )
                for node_id in run.node_ids
            ]
        return self._bench_with(listener, hosts, open_bus)

    def _bench_with(
        self,
        listener: Callable[[Captured], None],
        hosts: list[AbstractContextManager[object]],
        opener: Callable[[BusSettings], can.BusABC],
    ) -> Bench:
        state = self._state
        self._values = Values(state.options, state.journal)
        return Bench(
            state.options.run,
            hosts,
            listener,
            state.report_dir,
            opener,
            state.stop,
            self._values.remember,
            self._values.before,
            DiscoveryProgress(self._config),
        )

    # Cases

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> None:
        """Note that the run has come to a case."""
        item.stash[REACHED] = True
        if self._state.log is not None:
            self._state.log.begin()

    # Within the wrappers of pytest, which would not be ready to tear down what they did not set up.
    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Generator[None, object, object]:
        """Skip the cases of a device that is out of the run, and those that would stop it again."""
        if not uses_device(item):
            return (yield)
        try:
            self._state.stop.check()
            self._skip_what_is_out(item)
            return (yield)
        except RunStopped:
            self._end_stopped(item)

    def _skip_what_is_out(self, item: pytest.Item) -> None:
        case = case_of(item)
        why = self._why_out(item)
        if why is not None:
            item.stash[RESULT] = left_out(case, Verdict.NOT_RUN, why)
        elif stopped := self._losses[case.node_id].why_not(case.case_id, case.risk):
            item.stash[RESULT] = left_out(case, Verdict.NOT_TESTABLE, stopped)
        else:
            return
        pytest.skip(f"{item.stash[RESULT].verdict.value}: {item.stash[RESULT].actual}")

    def _why_out(self, item: pytest.Item) -> str | None:
        """Say why the device of a case is not tested any further; None where it is."""
        if not uses_device(item):
            return None
        return self._state.findings.out.get(case_of(item).node_id)

    def _leave_out_all(self, reason: str) -> None:
        for node_id in self._state.options.run.node_ids:
            self._state.findings.out.setdefault(node_id, reason)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Generator[None, object, object]:
        """Judge the case when its function has ended, before anything is torn down."""
        run = item.stash.get(CASE_RUN, None)
        if run is None:
            return (yield)
        outcome: object = None
        error: BaseException | None = None
        try:
            outcome = yield
        except RunStopped:
            self._end_stopped(item)
        except (KeyboardInterrupt, pytest.exit.Exception):
            run.conclude(None)  # the values are put back all the same
            raise
        except BaseException as caught:
            # Also what derives from BaseException alone, as the outcomes of pytest do.
            error = caught
        try:
            self._judge(item, run, error)
        except RunStopped:
            self._end_stopped(item)
        return outcome

    def _end_stopped(self, item: pytest.Item) -> NoReturn:
        """End a case that a request to stop has interrupted; the run ends with it."""
        run = item.stash.get(CASE_RUN, None)
        stop = self._state.stop
        if run is not None and not stop.gives_up:
            with suppress(RunStopped):
                run.conclude(None)  # the values are put back all the same
        item.session.shouldstop = stop.reason
        item.stash[RESULT] = left_out(case_of(item), Verdict.NOT_RUN, f"{stop.reason} in it")
        pytest.skip(f"{Verdict.NOT_RUN}: {stop.reason}")

    def _judge(self, item: pytest.Item, run: CaseRun, error: BaseException | None) -> None:
        """Judge a case that ended by ``error``, if by any, and raise what it is to pytest."""
        session = self._state.session(case_of(item).node_id)
        again = partial(begin, session, case_of(item))
        run, error, result = conclude_tries(item, run, error, again)
        state = self._state
        self._look_after(item, session, result, run)
        account(result, state.options.deviations, strict=state.options.strict)
        item.stash[RESULT] = result
        attach(item, result)
        if result.case_id == LATE_ANSWERS:
            late = state.session(result.node_id).whole_run.late
            state.judged_late_answers[result.node_id] = len(late)
        if is_told(error) and error is not None and result.verdict is Verdict.NOT_TESTABLE:
            raise error
        end_with(result, run.bench_error or error, strict=state.options.strict)

    def _look_after(
        self, item: pytest.Item, session: DeviceSession, result: CaseResult, run: CaseRun
    ) -> None:
        """Bring a lost device back; where nothing can, it is out of the run."""
        losses = self._losses[result.node_id]
        if not session.lost:
            losses.survived(result.case_id)
            if why := session.channel.pace.unsound:
                self._give_up(result, why)
            return
        sent = [each.frame for each in session.frames if each.direction is Direction.SENT]
        cause = losses.add(result.case_id, case_of(item).risk, sent)
        try:
            why = session.revive()
        except BenchError as error:
            why = str(error)
        if not why and losses.is_hopeless:
            why = f"it was lost in {MOST_IN_A_ROW} cases in a row, whatever they sent"
        if not why:
            result.notes.append(f"the device was lost by {cause}, and has been brought back")
            return
        self._state.findings.bench_errors.append(session.loss())
        self._state.findings.out[result.node_id] = f"lost in {result.case_id}; {why}"

    def _give_up(self, result: CaseResult, why: str) -> None:
        """Take a device out of the run that answers, but not in a way that could be tested."""
        findings = self._state.findings
        findings.bench_errors.append(
            DeviceLost(f"Node {result.node_id} was given up behind {result.case_id}: {why}.")
        )
        findings.out[result.node_id] = f"given up behind {result.case_id}: {why}"

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Put the evidence into the report, and the result with it."""
        report = yield
        if self._discovered:
            report.conformance_devices = self._discovered  # type: ignore[attr-defined]
            self._discovered = []
        error = call.excinfo.value if call.excinfo else None
        if call.when == "setup" and report.skipped:
            if RESULT not in item.stash and isinstance(item, CaseFunction):
                why = str(error).removeprefix(f"{Verdict.NOT_TESTABLE}: ")
                item.stash[RESULT] = left_out(case_of(item), Verdict.NOT_TESTABLE, why)
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
            if isinstance(error, InterfaceLost | BusOff):
                self._leave_out_all("the bus is gone")
        if call.when == "call":
            full = isinstance(error, TransmitBufferFull)
            self._full_in_a_row = self._full_in_a_row + 1 if full else 0
            if self._full_in_a_row >= MOST_FULL:
                self._leave_out_all("no frame leaves the interface: its transmit buffer stays full")
        result = item.stash.get(RESULT, None)
        if result is None or call.when == "teardown":
            return report
        report.conformance = result.as_dict()  # type: ignore[attr-defined]
        if self._state.log is not None:
            self._state.log.flush()
            place = as_values(self._state.log.place())
            report.conformance_frames = place  # type: ignore[attr-defined]
        if report.skipped and isinstance(item, CaseFunction):
            path, line, _ = item.location
            report.longrepr = (path, (line or 0) + 1, str(error))
        elif isinstance(error, BenchError | CaseFailed):
            report.longrepr = Evidence(result)  # type: ignore[assignment]
            if isinstance(error, BenchError):
                # A broken bench is an error of the set-up, whenever it shows.
                report.when = "setup"
            if isinstance(error, SuiteError):
                report.sections.append(("traceback", traceback_of(error)))
        elif report.failed:
            report.sections.append(("frames on the bus", "\n".join(result.trace)))
        return report

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

    # The end

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Close the bench; a worker hands back what it found."""
        state = self._state
        if self._has_begun:
            ended = str(session.shouldfail or session.shouldstop or "the run was ended before")
            state.findings.unreached += [
                left_out(case_of(item), Verdict.NOT_RUN, ended)
                for item in session.items
                if uses_device(item) and REACHED not in item.stash
            ]
        for node_id, losses in self._losses.items():
            if node_id not in state.findings.out:
                state.findings.stopped += losses.lines()
        if state.bench is not None:
            try:
                state.bench.close()
            except BenchError as error:
                state.findings.bench_errors.append(error)
            except RunStopped:
                pass  # what is not back is listed
            lost = state.bench.counted()
            if lost:
                counts = ", ".join(f"{name} {count}" for name, count in lost.items())
                state.findings.notes.append(
                    f"the interface has counted since the run began: {counts}"
                )
            for node_id, device in state.bench.sessions.items():
                judged, known = state.judged_late_answers[node_id], state.options.deviations
                state.findings.close(device, judged=judged, known=known, lost=sum(lost.values()))
        if self._values is not None:
            self._values.close(state.findings)
        if state.log is not None and (trouble := state.log.close()):
            state.findings.bench_errors.append(NotWritten(trouble))
        if state.options.share.worker:
            hand_back(self._config, state.findings)


def _was_stopped(item: pytest.Item) -> bool:
    """Say whether a case was interrupted by a request to end the run."""
    return RESULT in item.stash and item.stash[RESULT].verdict is Verdict.NOT_RUN
