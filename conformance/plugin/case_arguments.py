"""The arguments of the suite's own cases, by name.

They are no fixtures of pytest. A conftest.py may have a fixture called ``device`` or ``text``: it
is for the tests of its folder, and must not choose the object of a case of the suite. And a
fixture takes as long as two requests do, several times for each of thousands of cases.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import TypeVar

import pytest

from conformance.bus.stop import RunStopped
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.model_cases.conversations.plan import SearchPlan
from conformance.model_cases.conversations.search import ConversationSearch
from conformance.model_cases.conversations.store import FailingStore
from conformance.plugin.attempts import begin_attempt
from conformance.plugin.items import CaseFunction
from conformance.plugin.state import CASE_RUN, RESULT, STATE, case_of
from conformance.run.case_run import CaseRun
from conformance.run.session import DeviceSession
from conformance.run.verdict import Verdict

Found = TypeVar("Found")

OF_DEVICE: Mapping[str, Callable[[DeviceSession], object]] = {
    "device_session": lambda session: session,
    "device": lambda session: session.device,
    "whole_run": lambda session: session.whole_run,
    "roles": lambda session: Roles(session.device),
    "number": lambda session: Roles(session.device).number(),
    "variable": lambda session: Roles(session.device).variable(),
    "text": lambda session: Roles(session.device).text(),
    "write_only": lambda session: Roles(session.device).write_only(),
    "read_only_text": lambda session: Roles(session.device).read_only_text(),
    "server_timeout": lambda session: session.device.declared_timeout(),
}
# All others that need the conversation are among its tools.
CONVERSATIONS = "conversations"


class CaseArguments:
    """The hooks that give a case its arguments when it is set up."""

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Give a case of the suite its arguments, behind all fixtures."""
        if isinstance(item, CaseFunction) and item.is_own:
            give_arguments(item)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_teardown(self, item: pytest.Item) -> None:
        """End a case that has begun and was not performed: its values are put back."""
        if isinstance(item, CaseFunction) and item.is_own:
            take_arguments(item)


def give_arguments(item: CaseFunction) -> None:
    """Give a case of the suite its arguments; skips it if the device lacks something.

    That is found out before the conversation begins.
    """
    session, given = session_of(item), item.given
    for name in item.asked:
        if name in OF_DEVICE:
            given[name] = or_skip(partial(OF_DEVICE[name], session))
    if len(given) < len(item.asked):
        run = item.stash.get(CASE_RUN, None)
        if run is None or run.is_over:  # else a fixture for all tests has begun it
            run = item.stash[CASE_RUN] = begin_attempt(session, case_of(item))
        for name in item.asked:
            if name not in given:
                given[name] = (
                    search(item, run) if name == CONVERSATIONS else getattr(run.tools, name)
                )


def take_arguments(item: CaseFunction) -> None:
    """Take them away again. A case that was not performed is ended: its values are put back."""
    item.given.clear()
    end_unperformed(item)


def session_of(item: pytest.Item) -> DeviceSession:
    """Return the device of a case within the run; raises pytest.UsageError where there is none."""
    state = item.config.stash.get(STATE, None)
    if state is None:
        raise pytest.UsageError(
            "This test needs a device: name it with --node-id=N, or use --self-test."
        )
    return state.session(case_of(item).node_id)


def or_skip(find: Callable[[], Found]) -> Found:
    """Return the argument that a device has for a case; skips the case if it has none."""
    try:
        return find()
    except NotTestable as lacking:
        raise pytest.skip.Exception(f"{Verdict.NOT_TESTABLE}: {lacking}") from lacking


def as_lacking(skipped: BaseException | None) -> NotTestable:
    """Return what a case lacks that was skipped."""
    lacking = skipped.__cause__ if skipped is not None else None
    return lacking if isinstance(lacking, NotTestable) else NotTestable(str(skipped))


def end_unperformed(item: pytest.Item) -> None:
    """Conclude a case that has begun and has no result, as where a fixture has failed."""
    run = item.stash.get(CASE_RUN, None)
    if run is not None and RESULT not in item.stash and not run.is_over:
        with suppress(RunStopped):
            run.conclude(None)


def search(item: pytest.Item, run: CaseRun) -> ConversationSearch:
    """Return random conversations with the device, as many as --sdo-examples says."""
    case = case_of(item)
    state = item.config.stash[STATE]
    options, left = state.options, max(state.seconds_left(case.node_id), 0.0)
    folder = options.report_dir / "failing"
    store = FailingStore.of(folder, case.node_id, case.case_id)
    seconds = min(options.effort.search_seconds, left)
    plan = SearchPlan(options.examples, options.run.seed, seconds)
    return ConversationSearch(run.session, run, plan, store)
