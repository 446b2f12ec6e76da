"""Several devices at once within one process: each has a thread, which performs its cases.

A device is waited for most of the time. As many processes as devices would all be in each other's
way then: what one has in the caches of a processor is gone when it goes on, and a case took more
than twice as long to compute. Threads share what is there.

pytest runs its items one after another. So the cases of a device are performed ahead of it: it
waits for what has come of each, and reports that. Nothing of a user's may stand between pytest and
a case then, which could have wanted to keep the case from being run.
"""

import threading
import time
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace

import pytest

from conformance.bus.errors import BenchError
from conformance.bus.stop import RunStopped
from conformance.plugin.budget import Budget
from conformance.plugin.case_arguments import take_arguments
from conformance.plugin.direct import is_alone
from conformance.plugin.items import CaseFunction
from conformance.plugin.options import Options
from conformance.plugin.performing import Performing
from conformance.plugin.state import (
    RunState,
    begin_again,
)
from conformance.plugin.suite_errors import suite_error
from conformance.plugin.taking_part import PROTOCOL, foreign, nobody_takes_part
from conformance.plugin.time_left import estimate_for
from conformance.reporting.bus_log import Place
from conformance.run.bench import private_channel

# By these options a run ends behind a case, as far as pytest has come.
ENDING = ("maxfail", "stepwise", "stepwise_skip")
# So many cases of a device wait for pytest at most.
MOST_AHEAD = 2000


@dataclass(frozen=True, slots=True)
class Performed:
    """What has come of a case: what pytest is to raise in which phase, and for how long it ran.

    ``place`` is where its frames are.
    """

    phase: str
    outcome: BaseException | None
    seconds: float
    place: Place | None


PERFORMED = pytest.StashKey[Performed]()


def may_go_ahead(config: pytest.Config, items: Iterable[pytest.Item]) -> bool:
    """Say whether the cases of a worker may be performed ahead of pytest."""
    return nobody_between(config) and all(map(is_alone, items))


def nobody_between(config: pytest.Config) -> bool:
    """Say whether nobody can keep a case from being run, or wants to end the run behind one."""
    ends = any(config.getoption(name, default=False) for name in ENDING)
    return not ends and nobody_takes_part(config) and not foreign(config, PROTOCOL)


def state_of(state: RunState, node_id: int) -> RunState:
    """Return the state of one device of a process: as if it were alone in a process."""
    options, share = state.options, state.options.share
    run = options.run
    others = frozenset[int]() if options.self_test else frozenset(options.node_ids) - {node_id}
    bus = replace(run.bus, channel=private_channel()) if options.self_test else run.bus
    part: Options = replace(
        options,
        run=replace(run, node_ids=[node_id], neighbours=others, bus=bus),
        share=replace(
            share,
            node_ids=[node_id],
            worker=f"{share.worker}-{node_id}",
            plain_tests=share.plain_tests and node_id == share.node_ids[0],
        ),
    )
    own = RunState(part, stop=state.stop.for_thread(), begun=state.begun)
    if node_id in state.findings.out:
        own.findings.out[node_id] = state.findings.out[node_id]
    return own


class Ahead:
    """The thread of one device."""

    def __init__(self, config: pytest.Config, state: RunState, items: list[CaseFunction]) -> None:
        """``items`` are the cases of the device, in their order."""
        self.state = state
        self._budget: Budget | None = None
        options = state.options
        if options.budget is not None:
            node_ids = options.run.node_ids
            self._budget = Budget(options.budget, node_ids, estimate_for(options))
            state.seconds_left = self._budget.left
        self._performing = Performing(config, state, self._budget)
        self._next = deque(items)
        # What was performed and has not been asked for yet.
        self._found: dict[pytest.Item, Performed] = {}
        self._changed = threading.Condition()
        self._is_open = self._is_over = self._is_ending = False
        self.stopped = ""
        state.stop.when_requested(self._wake)
        self._thread = threading.Thread(target=self._run, name=state.options.share.worker)
        self._thread.daemon = True  # nothing that pytest has not waited for keeps the process

    # For pytest

    def start(self) -> None:
        """Begin to open the bench."""
        self._thread.start()

    def wait_until_open(self) -> None:
        """Wait until the device is known, or it is known that it cannot be tested."""
        with self._changed:
            self._changed.wait_for(lambda: self._is_open or self._is_over)

    def performed(self, item: CaseFunction) -> Performed | None:
        """Wait for what comes of a case, and return it; None if it will not be run any more."""
        with self._changed:
            self._changed.wait_for(lambda: item in self._found or self._is_over)
            found = self._found.pop(item, None)
            self._changed.notify_all()
        return found

    def end(self) -> None:
        """Perform no further case, and close the bench."""
        with self._changed:
            self._is_ending = True
            if self._next and not self.state.stop.requests:
                self.state.stop.request("")
            self._changed.notify_all()

    def join(self) -> None:
        """Wait until the bench is closed."""
        self._thread.join()

    def _wake(self) -> None:
        """Have the thread look whether it is to stop; a signal may do this at any moment.

        The lock of the condition may be taken again by a thread that has it.
        """
        with self._changed:
            self._changed.notify_all()

    # The thread

    def _run(self) -> None:
        """Open the bench, perform what there is to perform until it is ended, and close it."""
        try:
            self.stopped = self._performing.open()
            self._tell(is_open=True)
            while (item := self._take()) is not None:
                self._give(item, self._perform(item))
        except BaseException as error:
            self._fail(error)
        self._tell(is_over=True)
        try:
            self._performing.close()
        except BaseException as error:
            self._fail(error)

    def _fail(self, error: BaseException) -> None:
        """Take an error of the suite itself, which would end the thread without a word."""
        self.state.findings.bench_errors.append(suite_error(error))
        self.state.leave_out_all("the suite itself has failed")

    def _take(self) -> CaseFunction | None:
        """Wait for a case to perform, and return it; None where there will be no other."""
        stop = self.state.stop
        with self._changed:
            self._changed.wait_for(
                lambda: (
                    self._is_ending
                    or stop.requests
                    or (self._next and len(self._found) < MOST_AHEAD)
                )
            )
            return None if self._is_ending or stop.requests else self._next[0]

    def _give(self, item: CaseFunction, performed: Performed) -> None:
        with self._changed:
            self._next.remove(item)
            self._found[item] = performed
            self._changed.notify_all()

    def _tell(self, *, is_open: bool = False, is_over: bool = False) -> None:
        with self._changed:
            self._is_open |= is_open
            self._is_over |= is_over
            self._changed.notify_all()

    def _perform(self, item: CaseFunction) -> Performed:
        """Perform a case: what pytest does with it in two phases, and the hooks of the suite."""
        state, begin = self.state, time.monotonic()
        phase = "setup"
        outcome: BaseException | None = None
        if state.log is not None:
            state.log.begin()
        begin_again(item)
        try:
            try:
                self._performing.set_up(item)
                phase = "call"
                self._performing.call(item)
            except RunStopped:
                self._performing.end_stopped(item)
        except BaseException as error:
            outcome = error  # it is raised again where pytest waits
        take_arguments(item)
        if phase == "call" or isinstance(outcome, BenchError):
            state.heed(outcome)
        seconds = time.monotonic() - begin
        if self._budget is not None:
            self._budget.take(item, seconds)
        place = None
        if state.log is not None:
            state.log.flush()
            place = state.log.place()
        return Performed(phase, outcome, seconds, place)
