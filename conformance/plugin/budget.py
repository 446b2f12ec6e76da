"""--sdo-budget: the cases of a run in their order, as far as the time goes at this device's pace.

A case that would not be over in time is not run; a shorter case behind it may be. The cases that
judge the whole run are always run: they only look at the observations of the others.
"""

import time
from collections.abc import Generator, Sequence

import pytest

from conformance.device.not_testable import Lack, Missing
from conformance.plugin.items import judges_run
from conformance.plugin.state import RESULT, case_of, left_out, uses_device
from conformance.reporting.estimate import Estimate, Taken
from conformance.run.verdict import Verdict

WHY = "budget"
OUT_OF_TIME = Missing(Lack.TIME)


class Budget:
    """The hooks of a process that runs cases: they leave out cases that would take too long."""

    def __init__(self, seconds: float, node_ids: Sequence[int], estimate: Estimate) -> None:
        """Each device has its part of the time, and the rest of the devices before it."""
        self._begin = time.monotonic()
        self._seconds = seconds
        self._node_ids = list(node_ids)
        self._estimate = estimate
        self._tried: set[int] = set()

    def left(self, node_id: int) -> float:
        """Return the seconds that are left for the cases of a device."""
        nodes = self._node_ids
        parts = (nodes.index(node_id) + 1) / len(nodes) if node_id in nodes else 1.0
        return self._begin + self._seconds * parts - time.monotonic()

    def check(self, item: pytest.Item) -> None:
        """Skip a case that would take too long."""
        case = case_of(item)
        if judges_run(item) and case.node_id in self._tried:
            return
        if self._estimate.due(item.nodeid) > self.left(case.node_id):
            item.stash[RESULT] = left_out(case, Verdict.NOT_RUN, WHY, OUT_OF_TIME)
            pytest.skip(f"{Verdict.NOT_RUN.value}: {WHY}")

    def take(self, item: pytest.Item, seconds: float) -> None:
        """Take the time of a case, with its set-up and its end."""
        taken = Taken.by(item.stash.get(RESULT, None), seconds)
        if taken.tried:
            self._tried.add(case_of(item).node_id)
            self._estimate.pace.add(self._estimate.work(item.nodeid), taken)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self) -> None:
        """Begin to count."""
        self._begin = time.monotonic()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Leave out a case that would take too long."""
        if uses_device(item):
            self.check(item)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Take how long a case has taken."""
        begin = time.monotonic()
        outcome = yield
        if uses_device(item):
            self.take(item, time.monotonic() - begin)
        return outcome
