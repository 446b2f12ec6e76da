"""Counts what the cases have to do on the built-in device, and prints it as a run needs to know it.

    python tests/workload.py >conformance/reporting/workload.json

A run estimates by this how long it will take (see ``conformance.reporting.estimate``). Families of
cases with much to do stand alone, the others together by the file that they are in.
"""

import contextlib
import json
import os
import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import pytest

from conformance.reporting.workload import family_of, service_of
from conformance.run.bench import DEFAULT_RESPONSE_TIMEOUT

# A family stands alone that has so much of all answers, silences or time.
PART = 0.002
SENT, RECEIVED = "T", "R"


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
        self._log: Path | None = None
        self._before = 0.0

    def pytest_runtest_logstart(self) -> None:
        self._before = self._before or time.process_time()

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        now = time.process_time()
        self.cases[nodeid] = Count(1, seconds=now - self._before)
        self._before = now

    def count(self, results: Path, log: Path) -> None:
        """Count the answers of each case in the log of the run: what is right behind a request."""
        directions = [line[-1] for line in log.read_text(encoding="utf-8").splitlines()]
        records = map(json.loads, results.read_text(encoding="utf-8").splitlines())
        found = [record for record in records if record["record"] == "case"]
        for (name, count), record in zip(self.cases.items(), found, strict=True):
            assert name.endswith(record["result"]["case_id"]), name
            count.silences = record["result"]["waited"] / DEFAULT_RESPONSE_TIMEOUT
            place = record["frames"]
            if place is not None:
                part = directions[place["first"] - 1 : place["last"]]
                count.answers = sum(pair == (SENT, RECEIVED) for pair in pairwise(part))


def run() -> dict[str, Count]:
    """Run all cases against the built-in device."""
    timer = Timer()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(sys.stderr):
        here = os.getcwd()
        os.chdir(folder)
        arguments = ["--self-test", "-q", "-p", "no:cacheprovider", "--report-dir=reports"]
        try:
            status = pytest.main([*arguments, f"--rootdir={folder}"], plugins=[timer])
        finally:
            os.chdir(here)
        if status:
            raise SystemExit(f"the self-test fails: {status}")
        (report,) = Path(folder, "reports").glob("*-node-*")
        timer.count(report / "results.jsonl", report / "bus.log")
    return timer.cases


def table(cases: dict[str, Count]) -> dict[str, list[float]]:
    """Return what a case has to do, by family or by service."""
    families: defaultdict[tuple[str, str], Count] = defaultdict(Count)
    services: defaultdict[str, Count] = defaultdict(Count)
    whole = Count()
    for name, count in cases.items():
        families[service_of(name), family_of(name)].add(count)
        services[service_of(name)].add(count)
        whole.add(count)
    alone: dict[str, Count] = {}
    rest: defaultdict[str, Count] = defaultdict(Count)
    for (service, family), count in families.items():
        if (
            count.answers > PART * whole.answers
            or count.silences > PART * whole.silences
            or count.seconds > PART * whole.seconds
        ):
            alone[family] = count
        else:
            rest[service].add(count)
    return {name: count.each() for name, count in sorted({**services, **rest, **alone}.items())}


if __name__ == "__main__":
    lines = [f" {json.dumps(name)}: {values}" for name, values in table(run()).items()]
    print("{\n" + ",\n".join(lines) + "\n}")
