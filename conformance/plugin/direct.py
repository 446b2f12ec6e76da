"""The cases of the suite, run without what pytest does around a test that may be anything.

They have no fixtures, print nothing and log nothing, so there is nothing to set up, to capture or
to tear down: that took as long as half of the cases themselves. Everybody is still told of each
case and makes its reports of it. Where somebody else takes part in setting up, calling or tearing
down tests, or in repeating them, pytest runs the cases like any others.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from functools import partial

import pytest

from conformance.plugin.items import VARIATION, CaseFunction
from conformance.plugin.joined_reports import Phase, join

PROTOCOL, CALLED = "pytest_runtest_protocol", "pytest_pyfunc_call"
PHASES = ("pytest_runtest_setup", "pytest_runtest_call", "pytest_runtest_teardown")
# Of these everybody is told.
TOLD = ("pytest_runtest_logstart", "pytest_runtest_logreport", "pytest_runtest_logfinish")
MADE = "pytest_runtest_makereport"
# By these marks a user keeps a case from being run.
KEEPING_AWAY = {"skip", "skipif", "xfail"}
# They look at every phase of a test.
LOOKING = ("usepdb", "trace", "setuponly", "setupshow", "setupplan")
LOG_LEVELS = ("log_level", "log_cli_level", "log_file_level")
OURS = __name__.partition(".")[0]
# What takes part in each phase of a test, but has nothing to do in those of a case.
IDLE = {"_pytest", OURS, "_hypothesis_pytestplugin"}
# What sends the reports of a worker; pytest-xdist runs it there under the second name.
SENDING = {"xdist", "__channelexec__"}


def is_alone(item: pytest.Item) -> bool:
    """Say whether a test is a case of the suite that nobody has added anything to."""
    return (
        isinstance(item, CaseFunction)
        and item.is_own
        and set(item.fixturenames) <= {VARIATION}
        and KEEPING_AWAY.isdisjoint(mark.name for mark in item.iter_markers())
    )


def captures_logs(config: pytest.Config) -> bool:
    """Say whether what is logged during a test is wanted."""
    if not config.pluginmanager.hasplugin("logging"):
        return False
    return any(config.getoption(name) or config.getini(name) for name in LOG_LEVELS)


def nobody_takes_part(config: pytest.Config) -> bool:
    """Say whether nobody has anything to do in the phases of the suite's cases."""
    if any(config.getoption(name, default=False) for name in LOOKING) or captures_logs(config):
        return False
    return not any(
        foreign(config, name, but_wrappers=name == PROTOCOL) for name in (*PHASES, PROTOCOL, CALLED)
    )


def nobody_listens(config: pytest.Config) -> bool:
    """Say whether what a worker is told of its cases is only sent to the controller."""
    if not hasattr(config, "workerinput"):
        return False
    return not any(foreign(config, name, but=SENDING) for name in (*TOLD, MADE))


def foreign(
    config: pytest.Config, hook: str, *, but: Collection[str] = (), but_wrappers: bool = False
) -> bool:
    """Say whether somebody else implements a hook, ``but`` these packages or ``but_wrappers``."""
    return any(
        package(each.plugin) not in IDLE and package(each.plugin) not in but
        for each in getattr(config.hook, hook).get_hookimpls()
        if not (but_wrappers and (each.wrapper or each.hookwrapper))
    )


def package(plugin: object) -> str:
    """Return the package of a plugin, which is a module or an object."""
    name: str = getattr(plugin, "__name__", None) or type(plugin).__module__
    return name.partition(".")[0]


def may_run_directly(config: pytest.Config, items: Iterable[pytest.Item]) -> bool:
    """Say whether a run has nothing but cases of the suite, and nobody takes part in them."""
    return nobody_takes_part(config) and all(map(is_alone, items))


Phases = Sequence[tuple[Phase, Callable[[CaseFunction], None]]]


def run_directly(item: CaseFunction, phases: Phases, unseen: Collection[object] = ()) -> None:
    """Run a case in the three phases that pytest reports, but not to plugins that nobody sees."""
    hook, told = item.ihook, {"nodeid": item.nodeid, "location": item.location}
    tell = hook.pytest_runtest_logreport
    if unseen and hook is item.config.hook:
        tell = item.config.pluginmanager.subset_hook_caller(tell.name, unseen)
    hook.pytest_runtest_logstart(**told)
    passes = True
    for phase, run in phases:
        if passes or phase == "teardown":
            call = _call(item, phase, run)
            passes = _told(item, call, _report(item, call), tell)
    hook.pytest_runtest_logfinish(**told)


def run_briefly(item: CaseFunction, phases: Phases) -> None:
    """Run a case in a worker in which nobody listens, and send one report: see joined_reports."""
    (_, set_up), (_, call), (_, tear_down) = phases
    before = decisive = _call(item, "setup", set_up)
    if before.excinfo is None:
        decisive = _call(item, "call", call)
    report = _report(item, decisive)
    after = _call(item, "teardown", tear_down)
    quiet = [each for each in (before, after) if each.excinfo is None]
    join(report, quiet)
    tell = item.config.hook.pytest_runtest_logreport
    _told(item, decisive, report, tell)
    if after.excinfo is not None:
        _told(item, after, _report(item, after), tell)
        item.config.hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)


def unseen_terminal(config: pytest.Config) -> list[object]:
    """Return what writes each result, in a worker, to a terminal that is none."""
    terminal = config.pluginmanager.get_plugin("terminalreporter")
    return [terminal] if terminal is not None and hasattr(config, "workerinput") else []


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
