"""Prints the time left during a run, and the progress of the discovery before the first case."""

import time
from collections.abc import Sequence
from math import inf

import pytest

from conformance.device.effort import USUAL_EXAMPLES
from conformance.device.known_objects import KnownObject
from conformance.device.options import ANSWER_DELAY, SIMULATED
from conformance.plugin.options import Options
from conformance.plugin.state import STATE
from conformance.plugin.terminal import SummaryTerminal
from conformance.plugin.workers import Worker
from conformance.reporting.estimate import Estimate, Taken
from conformance.run.verdict import CaseResult, Verdict

# The first estimate comes after this number of cases and this part of the work.
FIRST_CASES, FIRST_PART = 20, 0.05
# The first estimate comes after this time at the latest, in seconds.
FIRST_WORD = 60.0
# It is repeated after each tenth of the run, within these limits, in seconds.
OFTEN, SELDOM = 30.0, 300.0
# A run with less time left than this prints no estimate, in seconds.
SHORT = 5.0
# How often the progress of a discovery is printed, in seconds.
LOOK = 10.0
# A run with more time left than this prints how to select fewer cases, in seconds.
LONG = 3600.0
HINT = "; to shorten the run: -k, --sdo-examples"
# A run that takes less than this says nothing of it beforehand, in seconds.
LONG_ENOUGH = 120.0


def in_words(seconds: float) -> str:
    """Write a time in words, rounded.

    >>> [in_words(seconds) for seconds in (8.4, 75, 3000, 40000)]
    ['8 s', '75 s', '50 min', '11 h']
    """
    if seconds < 100:
        return f"{seconds:.0f} s"
    if seconds < 100 * 60:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.0f} h"


def estimate_for(options: Options) -> Estimate:
    """Return the estimate of how long the cases of a run take."""
    given = options.given
    free = given[SIMULATED] and not given[ANSWER_DELAY]  # time jumps over a silence
    return Estimate(
        0.0 if free else options.run.response_timeout,
        options.examples / USUAL_EXAMPLES,
        options.effort.search_seconds,
    )


def say(
    config: pytest.Config, line: str, *, behind_dots: bool = False, always: bool = False
) -> None:
    """Write a line to the terminal, if this process has one; with -qq only if ``always``.

    pytest does not know that its line has only begun where that has dots without a file's name.
    """
    terminal: SummaryTerminal | None = config.pluginmanager.get_plugin("terminalreporter")
    verbosity = config.getoption("verbose")
    if terminal is None or (verbosity < -1 and not always):
        return
    terminal.ensure_newline()
    if behind_dots and verbosity <= 0:
        terminal.write("\n")
    terminal.write_line(f"conformance: {line}")


class DiscoveryProgress:
    """Prints the progress of a discovery that takes long."""

    def __init__(self, config: pytest.Config) -> None:
        """Begin the first discovery of the run."""
        self._config = config
        self._said = self._begin = time.monotonic()

    def __call__(self, node_id: int, entry: KnownObject, number: int, count: int) -> None:
        """Take that an object is read next, after ``number`` of ``count`` others."""
        now = time.monotonic()
        if number == 0:
            self._begin = now
        if now < self._said + LOOK:
            return
        self._said = now
        left = (now - self._begin) / number * (count - number) if number else 0.0
        more = f", about {in_words(left)} left" if number else ""
        say(self._config, f"node {node_id}: reading {entry}, object {number + 1} of {count}{more}")


class TimeLeft:
    """The hooks of the process that reports: it estimates how long the run will take yet."""

    def __init__(
        self,
        config: pytest.Config,
        estimate: Estimate,
        budget: float | None = None,
        *,
        takes_time: bool = True,
    ) -> None:
        """Take the terminal of the run; its ``budget`` are the seconds after which it ends.

        If it does not ``takes_time``, the clock of the bus jumps to the next event.
        """
        self._takes_time = takes_time
        self._config = config
        self._estimate = estimate
        self._deadline = inf if budget is None else time.monotonic() + budget
        self._begin: dict[str, float] = {}
        self._started: float | None = None
        self._next: float | None = None
        self._results: dict[str, tuple[str, CaseResult | None]] = {}

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Take the cases of this process; a controller of workers has none."""
        self._estimate.select(item.nodeid for item in session.items)

    @pytest.hookimpl
    def pytest_runtestloop(self) -> None:
        """Say how long the run takes at the pace that the devices had before the first case."""
        state = self._config.stash.get(STATE, None)
        if state is None or state.bench is None or not self._takes_time:
            return
        paces = [session.channel.pace for session in state.bench.sessions.values()]
        seconds = self._estimate.before(max((pace.typical for pace in paces), default=0.0))
        seconds = min(seconds, max(self._deadline - time.monotonic(), 0.0))
        if seconds < LONG_ENOUGH:
            return
        slowest = max(pace.typical for pace in paces)
        say(
            self._config,
            f"the device took {slowest * 1000:.3g} ms for an answer before the first case: at this "
            f"pace the run takes about {in_words(seconds)}{HINT if seconds > LONG else ''}",
        )

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, node: Worker, ids: Sequence[str]) -> None:
        """Take the cases of a worker."""
        self._estimate.select(ids, node.workerinput["workerid"])

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take the report of a test, and its worker."""
        node: Worker | None = getattr(report, "node", None)
        worker = "" if node is None else node.workerinput["workerid"]
        now = time.monotonic()
        if self._started is None:
            self._started = now - report.duration
        self._begin.setdefault(worker, now - report.duration)
        values = getattr(report, "conformance", None)
        if values is not None:
            self._results[report.nodeid] = worker, CaseResult.from_dict(values)
        else:
            self._results.setdefault(report.nodeid, (worker, None))

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        """Count a finished case, and say how long the rest will take."""
        if nodeid not in self._results or self._started is None:
            return  # no estimate was printed
        worker, result = self._results.pop(nodeid)
        now, begin = time.monotonic(), self._begin[worker]
        self._begin[worker] = now
        self._estimate.finish(nodeid, Taken.by(result, now - begin), worker)
        if result is None or result.verdict is not Verdict.NOT_RUN:
            self._look(now - self._started)

    def _look(self, elapsed: float) -> None:
        estimate = self._estimate
        if self._next is None:
            early = estimate.done < FIRST_CASES or estimate.part < FIRST_PART
            if early and (elapsed < FIRST_WORD or estimate.done == 0):
                return
        elif elapsed < self._next:
            return
        left = min(estimate.left(), max(self._deadline - time.monotonic(), 0.0))
        first = self._next is None
        self._next = elapsed + min(max((elapsed + left) / 10, OFTEN), SELDOM)
        if left < SHORT:
            return
        hint = HINT if first and left > LONG else ""
        say(
            self._config,
            f"{estimate.done} of {estimate.selected} cases in {in_words(elapsed)}, at this "
            f"device's pace about {in_words(left)} left{hint}",
            behind_dots=True,
        )
