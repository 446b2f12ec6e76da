"""The pytest plugin: options and header.

``collecting`` collects the cases, ``running`` runs them.
"""

from collections.abc import Generator

import pytest

from conformance import __version__
from conformance.device.options import ANSWER_DELAY, BUDGET, NODE_ID, SIMULATED
from conformance.plugin.arguments import ASKED, add_options, check_names, put_before
from conformance.plugin.budget import Budget
from conformance.plugin.case_arguments import CaseArguments
from conformance.plugin.case_reports import CaseReports
from conformance.plugin.collecting import Collecting
from conformance.plugin.deviation_scope import DeviationScope
from conformance.plugin.final_report import FinalReport
from conformance.plugin.fixtures import Fixtures
from conformance.plugin.marks import MARKS
from conformance.plugin.options import read_options
from conformance.plugin.printed_failures import PrintedFailures
from conformance.plugin.running import Running
from conformance.plugin.selection import NAMED, read_arguments
from conformance.plugin.state import STATE, RunState
from conformance.plugin.stopping import Stopping
from conformance.plugin.terminal import fitted
from conformance.plugin.time_left import TimeLeft, estimate_for, say
from conformance.plugin.unrestored import left_lines
from conformance.plugin.workers import Controller, is_controller
from conformance.run.bench import RunSettings
from conformance.run.case_files import CASES


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options and settings."""
    add_options(parser)


@pytest.hookimpl(wrapper=True)
def pytest_load_initial_conftests(
    early_config: pytest.Config, parser: pytest.Parser, args: list[str]
) -> Generator[None, object, object]:
    """Add the settings, and check the options that nobody knows, not even a conftest."""
    put_before(early_config, args)
    loaded = yield
    known, unknown = parser.parse_known_and_unknown_args(args)
    check_names(unknown, (f"--{name.replace('_', '-')}" for name in vars(known)))
    return loaded


def pytest_configure(config: pytest.Config) -> None:
    """Read the options; without a path, run the suite's own cases on the device asked for."""
    config.pluginmanager.register(CaseArguments(), "conformance-case-arguments")
    config.pluginmanager.register(Fixtures(), "conformance-fixtures")
    for name, what in MARKS.items():
        config.addinivalue_line("markers", f"{name}: a case that {what}")
    options = read_options(config)
    if options is None:
        return
    state = RunState(options)
    config.stash[STATE] = state
    controller, given, budget = None, options.given, options.given[BUDGET]
    if is_controller(config):
        controller = Controller(
            config,
            options.node_ids,
            state.report_dir,
            state.findings,
            state.stop,
            divisible=options.self_test,
        )
        config.pluginmanager.register(controller, "conformance-controller")
    if not options.share.worker:
        failures = PrintedFailures(state)
        config.pluginmanager.register(failures, "conformance-printed-failures")
        config.pluginmanager.register(
            FinalReport(state, controller, failures, shows_all=config.getoption("verbose") > 0),
            "conformance-final-report",
        )
        takes_time = not given[SIMULATED] or bool(given[ANSWER_DELAY])
        time_left = TimeLeft(config, estimate_for(options), budget, takes_time=takes_time)
        config.pluginmanager.register(time_left, "conformance-time-left")
    if controller is None:
        if budget is not None:
            within = Budget(budget, options.run.node_ids, estimate_for(options))
            state.seconds_left = within.left
            config.pluginmanager.register(within, "conformance-budget")
        config.pluginmanager.register(DeviationScope(state), "conformance-deviation-scope")
        config.pluginmanager.register(Running(config, state), "conformance-running")
        config.pluginmanager.register(CaseReports(state), "conformance-case-reports")
    # The last plugin is the innermost: the plugins before it meet its exceptions.
    config.pluginmanager.register(Stopping(state.stop, options.share), "conformance-stopping")
    if config.args_source is not pytest.Config.ArgsSource.ARGS:
        if config.stash[ASKED]:
            config.args = [str(CASES)]
    else:
        config.args, config.stash[NAMED] = read_arguments(config.args, config.invocation_params.dir)


def pytest_sessionstart(session: pytest.Session) -> None:
    """Register ``Collecting`` behind all plugins that configure themselves: its docstring says why.

    With -q pytest prints no header; changed values of an earlier run are listed all the same.
    """
    config = session.config
    config.pluginmanager.register(Collecting(), "conformance-collecting")
    state = config.stash.get(STATE, None)
    if state is not None and config.getoption("verbose") < 0:
        for line in left_lines(state.options):
            say(config, line, always=True)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Where pytest has found no tests and no device was named, say how to name it."""
    config = session.config
    nothing = session.exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED
    if nothing and STATE not in config.stash and not hasattr(config, "workerinput"):
        say(config, "no device is named: add --node-id=5 for node 5 on can0, or --self-test")


def pytest_report_header(config: pytest.Config) -> list[str]:
    """Name the device, the bus and the settings."""
    state = config.stash.get(STATE, None)
    if state is None:
        return []
    run = state.options.run
    target = f"node {', '.join(map(str, state.options.node_ids))} on {run.bus}"
    if state.options.self_test:
        target = f"built-in {state.options.server or 'reference server'}, {target}"
    rate = f"{run.bus.bitrate} bit/s" if run.bus.bitrate else "as the interface is set"
    lines = [
        f"conformance: {__version__}, target: {target}",
        f"conformance: bit rate: {rate}, response time-out: {run.response_timeout * 1000:g} ms, "
        f"seed: {run.seed}, strict: {'yes' if state.options.strict else 'no'}",
        f"conformance: objects: {_objects(run)}",
        *(f"conformance: {line}" for line in left_lines(state.options)),
    ]
    return [line for text in lines for line in fitted(text)]


def _objects(run: RunSettings) -> str:
    """Say how many objects of the devices are known before the first request."""
    listing = run.all_listings[run.node_ids[0]]
    if not listing.is_complete:
        named = len(run.permits.named)
        return f"{named} named, no EDS (--sdo-eds=FILE adds cases for each object of the device)"
    writable = len(run.permits.allowed(known for known in listing.entries if known.access.writable))
    return f"{len(listing.entries)} entries in the EDS, {writable} of them may be written"


@pytest.hookimpl(optionalhook=True, tryfirst=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int | None:
    """Let ``-n auto`` mean a worker for each device: devices are waited for most of the time."""
    node_ids = config.getoption(NODE_ID.destination)
    return len(node_ids) if node_ids else None
