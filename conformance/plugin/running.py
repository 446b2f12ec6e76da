"""A run within pytest: the bench is opened, each case judged; ``final_report`` reports on it."""

from collections import defaultdict
from collections.abc import Collection, Generator, Sequence
from contextlib import suppress
from functools import partial
from typing import NoReturn

import pytest

from conformance.bus.errors import (
    BenchError,
    DeviceLost,
    NotWritten,
)
from conformance.bus.link import Direction
from conformance.bus.stop import RunStopped
from conformance.device.known_deviations import unknown_case
from conformance.plugin.attempts import begin, conclude_tries, is_told
from conformance.plugin.bench_opening import open_bench
from conformance.plugin.outcome import (
    attach,
    end_with,
)
from conformance.plugin.state import (
    CASE_RUN,
    EARLIER,
    REACHED,
    RESULT,
    RunState,
    begin_again,
    case_of,
    left_out,
    uses_device,
)
from conformance.plugin.workers import hand_back
from conformance.run.accounting import Scope, account
from conformance.run.case_run import CaseRun
from conformance.run.losses import MOST_IN_A_ROW, Losses
from conformance.run.session import DeviceSession
from conformance.run.verdict import Afterwards, CaseResult, Verdict
from conformance.sdo.rules import RULES

# The case that judges what came too late; where it was not selected, the run itself does.
LATE_ANSWERS = "run.no-late-response"


class Running:
    """The hooks of a process that talks to devices."""

    def __init__(self, config: pytest.Config, state: RunState) -> None:
        """Take the state; nothing is opened before the first case."""
        self._config = config
        self._state = state
        self._has_begun = False
        self._losses: defaultdict[int, Losses] = defaultdict(Losses)
        self._scope: Scope | None = None

    # Before anything is deselected.
    @pytest.hookimpl(tryfirst=True)
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
        cases = [(case.case_id, case.tested_rules) for case in map(case_of, items)]
        reserved = [
            (case_id, info.tested_rules)
            for info in self._state.reserved
            for case_id, _ in info.variations()
        ]
        self._scope = Scope(options.deviations, [tested for _, tested in (*cases, *reserved)])
        if some:
            self._state.findings.partly += map(str, self._scope.shared)
            return
        self._note_left_out(reserved)
        unknown = unknown_case(
            options.deviations,
            (case_id for case_id, _ in (*cases, *reserved)),
            {rule.id for rule in RULES}.union(*[tested for _, tested in cases]),
        )
        if unknown is None:
            return
        if not options.share.worker:
            raise pytest.UsageError(unknown)
        self._state.findings.wrong_use = unknown
        self._state.leave_out_all("wrong use")

    def pytest_deselected(self, items: Sequence[pytest.Item]) -> None:
        """Note which known deviations a selection says nothing of: it leaves out their cases."""
        self._note_left_out([(case.case_id, case.tested_rules) for case in map(case_of, items)])

    def _note_left_out(self, cases: Collection[tuple[str, Collection[str]]]) -> None:
        if self._scope is None:
            return
        self._state.findings.partly += [
            str(known)
            for known in self._scope.shared
            if any(self._scope.is_about(known, case_id, tested) for case_id, tested in cases)
        ]

    # The bench

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Open the bench; no case is run on a device that is silent, or behind a broken bus."""
        wanted = any(uses_device(item) for item in session.items)
        if not wanted or self._config.option.collectonly or session.testsfailed:
            return
        self._has_begun = True
        state = self._state
        try:
            open_bench(self._config, state)
        except BenchError as error:
            state.findings.bench_errors.append(error)
            state.leave_out_all("the bus could not be opened")
        except RunStopped as stopped:
            state.leave_out_all(str(stopped))
            session.shouldstop = str(stopped)

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
        """Skip the cases of a device that is out of the run, and those that would stop it again.

        What an earlier try of the case has left is forgotten: a plugin may run an item once more.
        """
        begin_again(item)
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
        item.stash[RESULT] = left_out(
            case_of(item), Verdict.NOT_RUN, f"{stop.reason} during this case"
        )
        pytest.skip(f"{Verdict.NOT_RUN}: {stop.reason}")

    def _judge(self, item: pytest.Item, run: CaseRun, error: BaseException | None) -> None:
        """Judge a case that ended by ``error``, if by any, and raise what it is to pytest."""
        session = self._state.session(case_of(item).node_id)
        again = partial(begin, session, case_of(item))
        run, error, result = conclude_tries(item, run, error, again)
        state = self._state
        self._look_after(item, session, result, run)
        account(result, state.options.deviations, strict=state.options.strict)
        result.notes += [
            f"run again: before it was {earlier.verdict} ({earlier.cause or earlier.actual})"
            for earlier in item.stash.get(EARLIER, ())
        ]
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
        wrongly = result.afterwards is Afterwards.ANSWERS_WRONGLY
        wedged = losses.is_wedged(answers_wrongly=wrongly) and session.revival is not None
        if not session.lost:
            losses.survived(result.case_id)
        if not session.lost and not wedged:
            if why := session.channel.pace.unsound:
                self._give_up(result, why)
            return
        sent = [each.frame for each in session.frames if each.direction is Direction.SENT]
        cause = "it answered wrongly whatever it was asked"
        if session.lost:
            cause = losses.add(result.case_id, case_of(item).risk, sent)
        try:
            why = session.revive()
        except BenchError as error:
            why = str(error)
        if not why and losses.is_hopeless:
            why = f"it was lost in {MOST_IN_A_ROW} different cases in a row"
        if not why:
            result.notes.append(f"the device was lost ({cause}), and has been brought back")
            return
        self._state.findings.bench_errors.append(session.loss())
        self._state.findings.out[result.node_id] = f"lost in {result.case_id}; {why}"

    def _give_up(self, result: CaseResult, why: str) -> None:
        """Take a device out of the run that answers, but not in a way that could be tested."""
        findings = self._state.findings
        findings.bench_errors.append(
            DeviceLost(f"Node {result.node_id} was given up after {result.case_id}: {why}.")
        )
        findings.out[result.node_id] = f"given up after {result.case_id}: {why}"

    # The end

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Close the bench; a worker hands back what it found."""
        state = self._state
        if self._has_begun:
            ended = str(
                session.shouldfail or session.shouldstop or "the run ended before this case"
            )
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
            if errors := state.bench.errors():
                state.findings.notes.append(
                    f"the controller has reported errors on the bus since the run began: {errors}"
                )
            for node_id, device in state.bench.sessions.items():
                judged, known = state.judged_late_answers[node_id], state.options.deviations
                state.findings.close(device, judged=judged, known=known, lost=sum(lost.values()))
        if state.values is not None:
            state.values.close(state.findings)
        if state.log is not None and (trouble := state.log.close()):
            state.findings.bench_errors.append(NotWritten(trouble))
        if state.options.share.worker:
            hand_back(self._config, state.findings)
