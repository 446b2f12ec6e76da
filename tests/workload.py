"""Counts what the cases have to do on the built-in device, and prints it as a run needs to know it.

    python tests/workload.py >conformance/reporting/workload.json

A run estimates by this how long it will take (see ``conformance.reporting.estimate``). Cases with
much to do stand alone, such as the first of a family, which prepares what all of it need; so do the
rest of their families. The others stand together by the file that they are in.
"""

import contextlib
import json
import os
import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass

import pytest

from conformance.device.options import RESPONSE_TIMEOUT
from conformance.plugin.state import STATE
from conformance.reporting.workload import case_of, family_of, service_of

# A family stands alone that has this share of all answers, silences or time; a case by its answers.
PART = 0.002
# The file of the cases that only a thorough run has beside the usual ones.
RESERVED = "cases/test_state_pairs.py"


@dataclass
class Count:
    cases: int = 0
    answers: int = 0
    silences: float = 0.0
    seconds: float = 0.0

    def add(self, other: "Count") -> None:
        self.cases += other.cases
        self.answers += other.answers
        self.silences += other.silences
        self.seconds += other.seconds

    def is_part_of(self, whole: "Count") -> bool:
        """Say whether this is a part of all that counts."""
        return (
            self.answers > PART * whole.answers
            or self.silences > PART * whole.silences
            or self.seconds > PART * whole.seconds
        )

    def each(self) -> list[float]:
        """Return the answers, the silences and the milliseconds of a case."""
        return [
            round(self.answers / self.cases, 1),
            round(self.silences / self.cases, 2),
            round(1000 * self.seconds / self.cases, 2),
        ]


class Timer:
    """A pytest plugin that counts by case; the time is that of the processor."""

    def __init__(self) -> None:
        self.cases: dict[str, Count] = {}
        self._session: pytest.Session | None = None
        self._before = Count()
        self._waited = 0.0

    def pytest_sessionstart(self, session: pytest.Session) -> None:
        self._session = session

    def pytest_runtest_logstart(self) -> None:
        if not self._before.cases:
            self._before = self._now()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._waited += getattr(report, "conformance", {"waited": 0.0})["waited"]

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        now = self._now()
        self.cases[nodeid] = Count(
            1,
            now.answers - self._before.answers,
            now.silences - self._before.silences,
            now.seconds - self._before.seconds,
        )
        self._before = now

    def _now(self) -> Count:
        """Return what was counted since the beginning of the run."""
        assert self._session is not None
        bench = self._session.config.stash[STATE].bench
        assert bench is not None
        answers = sum(session.channel.pace.answers for session in bench.sessions.values())
        return Count(1, answers, self._waited / RESPONSE_TIMEOUT.default, time.process_time())


def run(*chosen: str) -> dict[str, Count]:
    """Run all cases of a usual run, or those that are chosen, against the built-in device."""
    timer = Timer()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(sys.stderr):
        here = os.getcwd()
        os.chdir(folder)
        arguments = ["--self-test", "-q", "-p", "no:cacheprovider", "--sdo-report-dir=reports"]
        arguments += chosen
        try:
            status = pytest.main([*arguments, f"--rootdir={folder}"], plugins=[timer])
        finally:
            os.chdir(here)
    if status:
        raise SystemExit(f"the self-test fails: {status}")
    return timer.cases


def table(cases: dict[str, Count]) -> dict[str, list[float]]:
    """Return what a case has to do, by family or by service."""
    whole = Count()
    for count in cases.values():
        whole.add(count)
    most = PART * whole.answers
    alone = {case_of(name): count for name, count in cases.items() if count.answers > most}
    families: defaultdict[tuple[str, str], Count] = defaultdict(Count)
    services: defaultdict[str, Count] = defaultdict(Count)
    for name, count in cases.items():
        if case_of(name) not in alone:
            families[service_of(name), family_of(name)].add(count)
        services[service_of(name)].add(count)
    rest: defaultdict[str, Count] = defaultdict(Count)
    begun = {name.partition("[")[0] for name in alone}
    for (service, family), count in families.items():
        if count.is_part_of(whole) or family in begun:
            alone[family] = count
        else:
            rest[service].add(count)
    return {name: count.each() for name, count in sorted({**services, **rest, **alone}.items())}


if __name__ == "__main__":
    lines = [
        f" {json.dumps(name)}: {values}" for name, values in table(run() | run(RESERVED)).items()
    ]
    print("{\n" + ",\n".join(lines) + "\n}")
