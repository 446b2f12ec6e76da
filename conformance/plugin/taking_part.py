"""Whether anybody but pytest and this suite takes part in its cases, or listens to a run."""

from collections.abc import Collection

import pytest

PROTOCOL, CALLED = "pytest_runtest_protocol", "pytest_pyfunc_call"
PHASES = ("pytest_runtest_setup", "pytest_runtest_call", "pytest_runtest_teardown")
# Of these everybody is told.
TOLD = ("pytest_runtest_logstart", "pytest_runtest_logreport", "pytest_runtest_logfinish")
MADE = "pytest_runtest_makereport"
# They look at every phase of a test.
LOOKING = ("usepdb", "trace", "setuponly", "setupshow", "setupplan")
LOG_LEVELS = ("log_level", "log_cli_level", "log_file_level")
# They show how long each phase took, or count the last one.
LISTENING = ("durations", "xmlpath")
OURS = __name__.partition(".")[0]
# What takes part in each phase of a test, but has nothing to do in those of a case.
IDLE = {"_pytest", OURS, "_hypothesis_pytestplugin"}
# What sends the reports of a worker; pytest-xdist runs it there under the second name.
SENDING = {"xdist", "__channelexec__"}


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
    """Say whether nobody would hear that a case was set up or torn down without more ado."""
    asks = not hasattr(config, "workerinput")  # else the controller asks for itself
    if asks and any(config.getoption(name, default=None) is not None for name in LISTENING):
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
