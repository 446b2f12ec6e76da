"""A run within pytest: the bench is opened, each case judged; ``final_report`` reports on it."""

from collections.abc import Generator
from typing import NoReturn

import pytest

from conformance.bus.stop import RunStopped
from conformance.plugin.case_engine import CaseEngine
from conformance.plugin.state import (
    CASE_RUN,
    REACHED,
    RunState,
    begin_again,
    case_of,
    left_out,
    uses_device,
)
from conformance.plugin.workers import hand_back
from conformance.run.verdict import Verdict


class Running:
    """The hooks of a process that talks to devices."""

    def __init__(self, config: pytest.Config, state: RunState) -> None:
        """Take the state; nothing is opened before the first case."""
        self._config = config
        self._state = state
        self._has_begun = False
        self._engine = CaseEngine(config, state)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Open the bench; no case is run on a device that is silent, or behind a broken bus."""
        wanted = any(uses_device(item) for item in session.items)
        if not wanted or self._config.option.collectonly or session.testsfailed:
            return
        self._has_begun = True
        if stopped := self._engine.open():
            session.shouldstop = stopped

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
        """Skip a case that cannot be run.

        The result of an earlier try is forgotten: a plugin may run an item once more.
        """
        begin_again(item)
        if not uses_device(item):
            return (yield)
        try:
            self._engine.admit(item)
            return (yield)
        except RunStopped:
            self._end_stopped(item)

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
            self._engine.judge(item, run, error)
        except RunStopped:
            self._end_stopped(item)
        return outcome

    def _end_stopped(self, item: pytest.Item) -> NoReturn:
        item.session.shouldstop = self._state.stop.reason
        self._engine.end_stopped(item)

    # The end

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Close the bench; a worker hands back its findings."""
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
        self._engine.close()
        if state.options.share.worker:
            hand_back(self._config, state.findings)
