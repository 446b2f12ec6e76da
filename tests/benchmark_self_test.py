"""How long a self-test takes, beside its frames alone, and its requests: part of ``make bench``.

    python tests/benchmark_self_test.py [--answer-delay SECONDS]

The floor is the exchange of the very same frames, as the bus log of the run has them, by two
threads with bare python-can on the same kind of bus, which is in this process. With a delay the
device takes so long for each answer; then the floor is the number of its answers times that.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import can

from conformance.reporting.recorded import read_run
from conformance.run.bench import private_channel

PATIENCE = 10.0
SENT, RECEIVED = "T", "R"
OUTCOME = re.compile(r"\d+ passed.* in [\d.]+s")
# Cases and the matrix; how much of random conversations is tried is a matter of taste.
CHOSEN = ("-k", "not random")


@dataclass(frozen=True, slots=True)
class TimedRun:
    """A self-test: seconds, the directions of its frames, pytest's count, requests by service."""

    seconds: float
    directions: list[str]
    outcome: str
    requests: Counter[str]


def timed_run(*arguments: str) -> TimedRun:
    """Run the self-test."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            *(sys.executable, "-m", "pytest", "--self-test", "-q", "-p", "no:cacheprovider"),
            *(f"--rootdir={folder}", f"--sdo-report-dir={folder}", *CHOSEN, *arguments),
        ]
        begin = time.perf_counter()
        run = subprocess.run(  # noqa: S603 - it is our own
            command, cwd=folder, capture_output=True, text=True, check=False
        )
        seconds = time.perf_counter() - begin
        outcome = OUTCOME.search(run.stdout)
        if run.returncode or outcome is None:
            raise SystemExit(run.stdout + run.stderr)
        (report,) = (log.parent for log in Path(folder).glob("*/bus.log"))
        lines = (report / "bus.log").read_text(encoding="utf-8").splitlines()
        recorded = read_run(report)
    directions = [line.rpartition(" ")[2] for line in lines]
    requests: Counter[str] = Counter()
    for result, place in zip(recorded.results, recorded.places, strict=True):
        if place is not None:
            requests[result.service] += directions[place.first - 1 : place.last].count(SENT)
    requests["beside the cases"] = directions.count(SENT) - requests.total()
    return TimedRun(seconds, directions, outcome.group(), requests)


def frames_alone(directions: Sequence[str]) -> float:
    """Return the seconds in which two threads exchange as many frames in the same order."""
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
        begin = time.perf_counter()
        thread.start()
        exchange(near, SENT)
        thread.join()
        return time.perf_counter() - begin


def main() -> None:
    """Print a line for each way to run the self-test."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--answer-delay", type=float, help="seconds that the device takes")
    delay = parser.parse_args().answer_delay
    if delay is not None:
        run = timed_run("-p", "no:xdist", f"--sdo-answer-delay={delay}")
        answers = sum(direction == RECEIVED for direction, _ in groupby(run.directions))
        floor = answers * delay
        print(
            f"self-test, {delay * 1000:g} ms an answer: {run.seconds:.1f} s for {answers} answers, "
            f"x floor {run.seconds / floor:.2f} ({run.outcome})"
        )
        return
    for name, arguments in (
        ("one process", ("-p", "no:xdist")),
        ("two workers", ("-n", "2")),
        ("simulated bus", ("-p", "no:xdist", "--sdo-simulated")),
    ):
        run = timed_run(*arguments)
        floor = frames_alone(run.directions)
        print(
            f"self-test, {name}: {run.seconds:.1f} s for {len(run.directions)} frames, which alone "
            f"take {floor:.1f} s, x floor {run.seconds / floor:.2f} ({run.outcome})",
            flush=True,
        )
    print(f"{run.requests.total()} requests by service:")
    for service, count in run.requests.most_common():
        print(f"{count:7} {service}")


if __name__ == "__main__":
    main()
