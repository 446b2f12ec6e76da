"""The cases of the suite, run without what pytest does around a test that may be anything.

They have no fixtures, print nothing and log nothing, so there is nothing to set up, to capture or
to tear down: that took as long as half of the cases themselves. Everybody who listens is still told
of each case and of each of its phases. Where somebody else takes part in setting up, calling or
tearing down tests, or in repeating them, pytest runs the cases like any others.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from functools import partial

import pytest

from conformance.plugin.items import VARIATION, CaseFunction
from conformance.plugin.joined_reports import Phase, join
from conformance.plugin.taking_part import nobody_takes_part

# By these marks a user keeps a case from being run.
KEEPING_AWAY = {"skip", "skipif", "xfail"}


def is_alone(item: pytest.Item) -> bool:
    """Say whether a test is a case of the suite that nobody has added anything to."""
    return (
        isinstance(item, CaseFunction)
        and item.is_own
        and set(item.fixturenames) <= {VARIATION}
        and KEEPING_AWAY.isdisjoint(mark.name for mark in item.iter_markers())
    )


def may_run_directly(config: pytest.Config, items: Iterable[pytest.Item]) -> bool:
    """Say whether a run has nothing but cases of the suite, and nobody takes part in them."""
    return nobody_takes_part(config) and all(map(is_alone, items))


Phases = Sequence[tuple[Phase, Callable[[CaseFunction], None]]]


def run_directly(item: CaseFunction, phases: Phases, unseen: Collection[object] = ()) -> None:
    """Run a case in the three phases that pytest reports, but not to plugins that nobody sees."""
    hook, told = item.ihook, {"nodeid": item.nodeid, "location": item.location}
    tell = _teller(item, unseen)
    hook.pytest_runtest_logstart(**told)
    passes = True
    for phase, run in phases:
        if passes or phase == "teardown":
            call = _call(item, phase, run)
            passes = _told(item, call, _report(item, call), tell)
    hook.pytest_runtest_logfinish(**told)


def run_briefly(item: CaseFunction, phases: Phases, unseen: Collection[object] = ()) -> None:
    """Run a case where nobody listens, with one report: a worker sends it, see joined_reports."""
    hook, told = item.ihook, {"nodeid": item.nodeid, "location": item.location}
    tell = _teller(item, unseen)
    sends = hasattr(item.config, "workerinput")
    if not sends:
        hook.pytest_runtest_logstart(**told)
    (_, set_up), (_, call), (_, tear_down) = phases
    before = decisive = _call(item, "setup", set_up)
    if before.excinfo is None:
        decisive = _call(item, "call", call)
    report = _report(item, decisive)
    after = _call(item, "teardown", tear_down)
    if sends:
        join(report, [each for each in (before, after) if each.excinfo is None])
    _told(item, decisive, report, tell)
    if after.excinfo is not None:
        _told(item, after, _report(item, after), tell)
    if after.excinfo is not None or not sends:
        hook.pytest_runtest_logfinish(**told)


def unseen_terminal(config: pytest.Config) -> list[object]:
    """Return what writes each result, in a worker, to a terminal that is none."""
    terminal = config.pluginmanager.get_plugin("terminalreporter")
    return [terminal] if terminal is not None and hasattr(config, "workerinput") else []


def _teller(item: CaseFunction, unseen: Collection[object]) -> Callable[..., object]:
    """Return what tells everybody of a report, but the ``unseen``."""
    tell: Callable[..., object] = item.ihook.pytest_runtest_logreport
    if unseen and item.ihook is item.config.hook:
        name = "pytest_runtest_logreport"
        tell = item.config.pluginmanager.subset_hook_caller(name, unseen)
    return tell


def _call(
    item: CaseFunction, phase: Phase, run: Callable[[CaseFunction], None]
) -> pytest.CallInfo[None]:
    """Run one phase."""
    reraise = (pytest.exit.Exception, KeyboardInterrupt)
    return pytest.CallInfo.from_call(partial(run, item), phase, reraise)


def _report(item: CaseFunction, call: pytest.CallInfo[None]) -> pytest.TestReport:
    report: pytest.TestReport = item.ihook.pytest_runtest_makereport(item=item, call=call)
    return report


def _told(
    item: CaseFunction,
    call: pytest.CallInfo[None],
    report: pytest.TestReport,
    tell: Callable[..., object],
) -> bool:
    """Have a phase reported; say whether it has passed."""
    tell(report=report)
    if report.failed:
        item.ihook.pytest_exception_interact(node=item, call=call, report=report)
    return report.passed
