"""The cases of the suite, run without what pytest does around a test that may be anything.

They have no fixtures, print nothing and log nothing, so there is nothing to set up, to capture or
to tear down: that took as long as half of the cases themselves. Everybody is still told of each
case and makes its reports of it. Where somebody else takes part in setting up, calling or tearing
down tests, or in repeating them, pytest runs the cases like any others.
"""

from collections.abc import Callable, Collection, Iterable
from functools import partial
from typing import Literal

import pytest

from conformance.plugin.items import VARIATION, CaseFunction

PROTOCOL, CALLED = "pytest_runtest_protocol", "pytest_pyfunc_call"
PHASES = ("pytest_runtest_setup", "pytest_runtest_call", "pytest_runtest_teardown")
# By these marks a user keeps a case from being run.
KEEPING_AWAY = {"skip", "skipif", "xfail"}
# They look at every phase of a test.
LOOKING = ("usepdb", "trace", "setuponly", "setupshow", "setupplan")
LOG_LEVELS = ("log_level", "log_cli_level", "log_file_level")
OURS = __name__.partition(".")[0]
# What takes part in each phase of a test, but has nothing to do in those of a case.
IDLE = {"_pytest", OURS, "_hypothesis_pytestplugin"}


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


def foreign(config: pytest.Config, hook: str, *, but_wrappers: bool = False) -> bool:
    """Say whether somebody else implements a hook, ``but_wrappers`` do not count."""
    return any(
        package(each.plugin) not in IDLE
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


Phase = Literal["setup", "call", "teardown"]


def run_directly(
    item: CaseFunction,
    set_up: Callable[[CaseFunction], None],
    call: Callable[[CaseFunction], None],
    tear_down: Callable[[CaseFunction], None],
    unseen: Collection[object] = (),
) -> None:
    """Run a case in the three phases that pytest reports, but not to plugins that nobody sees."""
    hook, told = item.ihook, {"nodeid": item.nodeid, "location": item.location}
    report = hook.pytest_runtest_logreport
    if unseen and hook is item.config.hook:
        report = item.config.pluginmanager.subset_hook_caller(report.name, unseen)
    hook.pytest_runtest_logstart(**told)
    if _passes(item, report, "setup", set_up):
        _passes(item, report, "call", call)
    _passes(item, report, "teardown", tear_down)
    hook.pytest_runtest_logfinish(**told)


def unseen_terminal(config: pytest.Config) -> list[object]:
    """Return what writes each result, in a worker, to a terminal that is none."""
    terminal = config.pluginmanager.get_plugin("terminalreporter")
    return [terminal] if terminal is not None and hasattr(config, "workerinput") else []


def _passes(
    item: CaseFunction,
    tell: Callable[..., object],
    phase: Phase,
    run: Callable[[CaseFunction], None],
) -> bool:
    """Run one phase, and have it reported; say whether it has passed."""
    reraise = (pytest.exit.Exception, KeyboardInterrupt)
    call = pytest.CallInfo.from_call(partial(run, item), phase, reraise)
    report: pytest.TestReport = item.ihook.pytest_runtest_makereport(item=item, call=call)
    tell(report=report)
    if report.failed:
        item.ihook.pytest_exception_interact(node=item, call=call, report=report)
    return report.passed
