"""How long self-tests take, beside their frames alone, and their requests by service.

The floor is what no run can be without: the exchange of the very same frames, as the bus log of the
run has them, by two threads with bare python-can on the same kind of bus, which is in this process,
and as many empty tests, by pytest alone. The two threads run on whichever processor they are given;
where they are kept on one, as a self-test is, they take half of that or less, which a line of its
own says. Of a device that takes a time for each answer it is that
time for each request; of several devices, one of them.

Devices that take their time have no threads of their own: what they compute, a lab does not. They
answer within the call that sends the request, and the answer is there when it is due.
"""

import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import can
from bench_rows import Cost, Row, best, computed, cost

from conformance.reporting.recorded import read_run
from conformance.run.bench import private_channel

PATIENCE = 10.0
SENT, RECEIVED = "T", "R"
OUTCOME = re.compile(r"\d+ passed.* in [\d.]+s")
COLLECTED = re.compile(r"(\d+) tests collected in ([\d.]+)s")
ONE_PROCESS = ("-p", "no:xdist")
SIMULATED = "--sdo-simulated"
# As users run it: what Python and pytest have compiled is kept.
ENVIRONMENT = {
    name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"
}
EMPTY_TESTS = """
import pytest

@pytest.mark.parametrize("number", range({count}))
def test_nothing(number):
    pass
"""
# Seconds that a device takes for an answer.
DELAY = 0.002
COLLECTIONS = 3
# A device may take so many times its requests, and the collection of all cases so many seconds.
MOST_OF_REQUESTS, MOST_COLLECTING = 1.15, 1.0


@dataclass(frozen=True, slots=True)
class TimedRun:
    """A self-test: its cost, the directions of its frames, pytest's count, requests by service."""

    cost: Cost
    directions: list[str]
    outcome: str
    requests: Counter[str]
    cases: int


def timed_pytest(folder: str, *arguments: str) -> tuple[Cost, str]:
    """Run pytest in a folder; return its cost and what it has printed."""
    plain = ("-q", "-p", "no:cacheprovider", f"--rootdir={folder}")
    wall, cpu = time.perf_counter(), computed()
    run = subprocess.run(  # noqa: S603 - it is our own
        [sys.executable, "-m", "pytest", *plain, *arguments],
        cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    spent = Cost(time.perf_counter() - wall, computed() - cpu)
    if run.returncode:
        raise SystemExit(run.stdout + run.stderr)
    return spent, run.stdout


def timed_run(cases: str, *arguments: str) -> TimedRun:
    """Run these cases of the self-test."""
    with tempfile.TemporaryDirectory() as folder:
        asked = ("--self-test", f"--sdo-report-dir={folder}", "-k", cases, *arguments)
        spent, printed = timed_pytest(folder, *asked)
        outcome = OUTCOME.search(printed)
        if outcome is None:
            raise SystemExit(printed)
        (report,) = (log.parent for log in Path(folder).glob("*/bus.log"))
        lines = (report / "bus.log").read_text(encoding="utf-8").splitlines()
        recorded = read_run(report)
    directions = [line.rpartition(" ")[2] for line in lines]
    requests: Counter[str] = Counter()
    for result, place in zip(recorded.results, recorded.places, strict=True):
        if place is not None:
            requests[result.service] += directions[place.first - 1 : place.last].count(SENT)
    requests["beside the cases"] = directions.count(SENT) - requests.total()
    return TimedRun(spent, directions, outcome.group(), requests, len(recorded.results))


def empty_tests(count: int) -> Cost:
    """Let pytest run as many tests that do nothing, without the suite."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "test_empty.py").write_text(EMPTY_TESTS.format(count=count), encoding="utf-8")
        spent, _ = timed_pytest(folder, *ONE_PROCESS, "-p", "no:conformance")
    return spent


def frames_alone(directions: Sequence[str]) -> Cost:
    """Let two threads exchange as many frames in the same order."""
    channel = private_channel()

    def exchange(bus: can.BusABC, own: str) -> None:
        for direction in directions:
            if direction == own:
                bus.send(can.Message(arbitration_id=0x605, data=bytes(8), is_extended_id=False))
            else:
                bus.recv(PATIENCE)

    with (
        can.Bus(interface="virtual", channel=channel) as near,
        can.Bus(interface="virtual", channel=channel) as far,
    ):
        thread = threading.Thread(target=exchange, args=(far, RECEIVED))

        def both() -> None:
            thread.start()
            exchange(near, SENT)
            thread.join()

        return cost(both)


def self_tests(cases: str) -> Iterator[Row | str]:
    """Yield a row for each way to run the self-test, and then its requests by service."""
    tests: Cost | None = None
    for name, arguments in (
        ("one process", ONE_PROCESS),
        ("two workers", ("-n", "2")),
        ("simulated bus", (*ONE_PROCESS, SIMULATED)),
    ):
        run = timed_run(cases, *arguments)
        frames = frames_alone(run.directions)
        if tests is None:
            tests = empty_tests(run.cases)
            yield Row(f"  {len(run.directions)} frames alone", frames)
            yield Row(f"  {run.cases} empty tests", tests)
        floor = Cost(frames.wall + tests.wall, frames.cpu + tests.cpu)
        yield Row(f"self-test, {name}", run.cost, floor, rate=run.outcome)
    yield f"{run.requests.total()} requests by service:"
    for service, count in run.requests.most_common():
        yield f"{count:7} {service}"


def delayed(cases: str, devices: int) -> Iterator[Row | str]:
    """Yield rows for a device that takes its time, and for some of them at once."""
    delay = (SIMULATED, f"--sdo-answer-delay={DELAY}")
    one = timed_run(cases, *ONE_PROCESS, *delay)
    requests = one.directions.count(SENT)
    answers = sum(direction == RECEIVED for direction, _ in groupby(one.directions))
    name, shown = f"a device, {1000 * DELAY:g} ms an answer", f"{MOST_OF_REQUESTS:g} x"
    kept = one.cost.wall <= MOST_OF_REQUESTS * requests * DELAY
    floor = Cost(requests * DELAY, 0.0)
    yield Row(f"{name}: requests", one.cost, floor, shown, kept, f"{requests} requests")
    yield Row(f"{name}: answers", one.cost, Cost(answers * DELAY, 0.0), rate=f"{answers} answers")
    if devices > 1:
        run = timed_run(cases, f"--node-id=1-{devices}", "-n", "auto", *delay)
        yield Row(f"{devices} such devices", run.cost, one.cost, rate=run.outcome)


def collection() -> Iterator[Row | str]:
    """Yield a row for the collection of all cases, as pytest counts it: the best of some tries."""
    found, cases = [], ""
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(COLLECTIONS):
            spent, printed = timed_pytest(folder, "--self-test", "--collect-only")
            collected = COLLECTED.search(printed)
            if collected is None:
                raise SystemExit(printed)
            cases = collected[1]
            found.append(Cost(float(collected[2]), spent.cpu))
    least = best(found)
    kept = least.wall <= MOST_COLLECTING
    bound = f"{MOST_COLLECTING:g} s"
    yield Row(f"collection of {cases} cases", least, None, bound, kept)
