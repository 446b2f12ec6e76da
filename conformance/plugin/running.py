"""A run within pytest: the bench is opened, each case judged; ``final_report`` reports on it."""

from collections.abc import Generator
from typing import NoReturn

import pytest

from conformance.bus.stop import RunStopped
from conformance.plugin.ahead import PERFORMED, Ahead, may_go_ahead, state_of
from conformance.plugin.budget import Budget
from conformance.plugin.case_arguments import take_arguments
from conformance.plugin.direct import (
    Phases,
    may_run_directly,
    run_briefly,
    run_directly,
    unseen_terminal,
)
from conformance.plugin.items import CaseFunction
from conformance.plugin.performing import Performing
from conformance.plugin.side_by_side import mixed
from conformance.plugin.state import (
    CASE_RUN,
    REACHED,
    RESULT,
    RunState,
    begin_again,
    case_of,
    is_ahead,
    left_out,
    uses_device,
)
from conformance.plugin.taking_part import nobody_listens
from conformance.plugin.workers import hand_back
from conformance.reporting.workload import work_of
from conformance.run.verdict import CaseResult, Verdict

# In seconds; how the cases of several devices are mixed need not fit them exactly.
USUAL_ANSWER = 0.002


class Running:
    """The hooks of a process that talks to devices.

    Within a worker of several devices these are tested at once where that can be: see ``ahead``.
    """

    def __init__(
        self, config: pytest.Config, state: RunState, budget: Budget | None = None
    ) -> None:
        """Take the state, and the time there is; nothing is opened before the first case."""
        self._config = config
        self._state = state
        self._has_begun = False
        self._runs_directly = self._runs_briefly = False
        self._phases: Phases = (
            ("setup", self._set_up),
            ("call", self._call),
            ("teardown", self._tear_down),
        )
        self._unseen: list[object] = []
        self._goes_ahead = False
        self._performing = Performing(config, state, budget)
        self._ahead: dict[int, Ahead] = {}

    # Before a controller is told of the items, and of their order.
    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Mix the cases of devices that are going to be tested at once."""
        share = self._state.options.share
        if not share.worker or len(share.node_ids) < 2 or self._config.option.collectonly:
            return
        self._goes_ahead = may_go_ahead(self._config, session.items)
        if self._goes_ahead:
            silence = self._state.options.run.response_timeout
            session.items[:] = mixed(
                session.items, lambda name: work_of(name).due(1.0, USUAL_ANSWER, silence)
            )

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Open the bench; no case is run on a device that is silent, or behind a broken bus."""
        wanted = any(uses_device(item) for item in session.items)
        if not wanted or self._config.option.collectonly or session.testsfailed:
            return
        self._has_begun = True
        self._runs_directly = may_run_directly(self._config, session.items)
        self._runs_briefly = self._runs_directly and nobody_listens(self._config)
        self._unseen = unseen_terminal(self._config)
        stopped = self._go_ahead(session) if self._goes_ahead else self._performing.open()
        if stopped:
            session.shouldstop = stopped

    def _go_ahead(self, session: pytest.Session) -> str:
        """Begin with all devices at once; say why the run was stopped meanwhile."""
        state = self._state
        state.parts = {each: state_of(state, each) for each in state.options.run.node_ids}
        cases: dict[int, list[CaseFunction]] = {node_id: [] for node_id in state.parts}
        for item in session.items:
            if isinstance(item, CaseFunction) and item.node_id in cases:
                cases[item.node_id].append(item)
        for node_id, items in cases.items():
            self._ahead[node_id] = Ahead(self._config, state.parts[node_id], items)
            self._ahead[node_id].start()
        for ahead in self._ahead.values():
            ahead.wait_until_open()
            state.discovered += ahead.state.discovered
        return next((ahead.stopped for ahead in self._ahead.values() if ahead.stopped), "")

    # Cases

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(
        self, item: pytest.Item, nextitem: pytest.Item | None
    ) -> bool | None:
        """Note that the run has come to a case; run it where pytest need not."""
        item.stash[REACHED] = True
        if self._state.log is not None:
            self._state.log.begin()
        # By the last one pytest learns what it has to tear down: nothing.
        if not self._runs_directly or nextitem is None or not isinstance(item, CaseFunction):
            return None
        run = run_briefly if self._runs_briefly else run_directly
        run(item, self._phases, self._unseen)
        return True

    def _set_up(self, item: CaseFunction) -> None:
        if is_ahead(item):
            self._wait_for(item)
            return
        begin_again(item)
        try:
            self._performing.set_up(item)
        except RunStopped:
            self._end_stopped(item)

    def _call(self, item: CaseFunction) -> None:
        if PERFORMED in item.stash:
            self.pytest_pyfunc_call(item)
            return
        try:
            self._performing.call(item)
        except RunStopped:
            self._end_stopped(item)

    def _tear_down(self, item: CaseFunction) -> None:
        if not is_ahead(item):
            take_arguments(item)
        self.pytest_runtest_teardown(item)

    # Within the wrappers of pytest, which would not be ready to tear down what they did not set up.
    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Generator[None, object, object]:
        """Skip a case that cannot be run, or wait until it was performed.

        What an earlier try of the case has left is forgotten: a plugin may run an item once more.
        """
        if isinstance(item, CaseFunction) and is_ahead(item):
            outcome = yield
            self._wait_for(item)
            return outcome
        begin_again(item)
        if not uses_device(item):
            return (yield)
        try:
            self._performing.admit(item)
            return (yield)
        except RunStopped:
            self._end_stopped(item)

    def _wait_for(self, item: CaseFunction) -> None:
        """Wait for what comes of a case that is performed ahead."""
        performed = self._ahead[item.node_id].performed(item)
        stop = self._state.stop
        if performed is None:
            begin_again(item)
            why = self._state.of(item.node_id).findings.out.get(item.node_id, stop.reason)
            item.stash[RESULT] = left_out(case_of(item), Verdict.NOT_RUN, why)
            if stop.requests:
                item.session.shouldstop = stop.reason
            pytest.skip(f"{Verdict.NOT_RUN}: {why}")
        item.stash[PERFORMED] = performed
        result = item.stash.get(RESULT, None)
        if stop.requests and result is not None and result.verdict is Verdict.NOT_RUN:
            item.session.shouldstop = stop.reason
        if performed.phase == "setup" and performed.outcome is not None:
            raise performed.outcome

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Generator[None, object, object]:
        """Judge the case when its function has ended, before anything is torn down."""
        run = item.stash.get(CASE_RUN, None)
        if run is None or is_ahead(item):
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
            self._performing.judge(item, run, error)
        except RunStopped:
            self._end_stopped(item)
        return outcome

    @pytest.hookimpl(tryfirst=True)
    def pytest_pyfunc_call(self, pyfuncitem: pytest.Function) -> bool | None:
        """Tell what has come of a case that was performed ahead, where it would be called."""
        performed = pyfuncitem.stash.get(PERFORMED, None)
        if performed is None:
            return None
        if performed.outcome is not None:
            raise performed.outcome
        return True

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_teardown(self, item: pytest.Item) -> None:
        """Let go of what has come of a case: what it has raised holds on to much."""
        if PERFORMED in item.stash:
            del item.stash[PERFORMED]

    def _end_stopped(self, item: pytest.Item) -> NoReturn:
        item.session.shouldstop = self._state.stop.reason
        self._performing.end_stopped(item)

    # The end

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Close the bench; a worker hands back what it found."""
        state = self._state
        for ahead in self._ahead.values():
            ahead.end()
        for ahead in self._ahead.values():
            ahead.join()
        if self._has_begun:
            ended = str(
                session.shouldfail or session.shouldstop or "the run ended before this case"
            )
            state.findings.unreached += [
                _unreached(item, ended)
                for item in session.items
                if uses_device(item) and REACHED not in item.stash
            ]
        self._performing.close()
        for part in state.parts.values():
            state.findings.add(part.findings.as_dict())
        if state.options.share.worker:
            hand_back(self._config, state.findings)


def _unreached(item: pytest.Item, ended: str) -> CaseResult:
    """Return what is known of a case that pytest has not come to: it may have been performed."""
    result = item.stash.get(RESULT, None)
    if result is None or result.verdict is Verdict.NOT_RUN:
        return left_out(case_of(item), Verdict.NOT_RUN, ended)
    return result
