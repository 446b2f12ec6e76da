"""Stops runs at random moments by signals, and looks at what is left: run by hand.

    python tests/stopping/stopped_runs.py --times 50 self-test stand-in
    python tests/stopping/stopped_runs.py --devices 3 --workers 1 stand-in

The buses are python-can's virtual one, within a self-test, and what stands in for SocketCAN, with a
device of its own process; or ``vcan0`` of a kernel. Of each run it is checked that it ended with
the right status, that each case that it has told is in its record and report, that each value is
back or stands whole in the journal, and that none of its processes goes on.
"""

import argparse
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "fleet")]

from fleet_run import CHANNEL, Bus, socketcan, stand_in  # noqa: E402
from remembering_device import memory_of  # noqa: E402

from conformance.__main__ import main  # noqa: E402
from conformance.commands.status import DONE  # noqa: E402
from conformance.reference.built_in_device import reference_entries  # noqa: E402
from conformance.reporting.journal import journals, read_journal  # noqa: E402
from conformance.reporting.recorded import NotRecorded, read_run  # noqa: E402

DEVICE = Path(__file__).with_name("remembering_device.py")
SIGNALS = {name: getattr(signal, f"SIG{name}") for name in ("INT", "TERM", "KILL")}
CASES = [ROOT / "cases" / "test_segmented_download.py"]
# The first node-ID.
FIRST = 5
# Many short cases; a busy machine is not what is looked at.
SELECTED = ("-k", "size or toggle or refused", "--sdo-response-timeout=20")
OBJECTS = ("2001=unsigned8", "2004=unsigned32", "2010=visible_string", "2020=domain")
# What a test is called in the verbose output when it has ended, of a process and of workers.
ENDED = "(?:PASSED|FAILED|INFO|NON-STRICT)"
TOLD = re.compile(rf"^(?:\S*::(?=\S+ {ENDED})|\[gw.* {ENDED} \S*::)(\S+)", re.MULTILINE)
INTERRUPTED = 2
MOST_SAID = 12
# Also on a machine that is slow and busy.
HANGS = 900.0
GONE_WITHIN = 15.0
# One run in STARTS is stopped while it is starting, which takes about STARTING seconds.
STARTS, STARTING = 5, 2.0


@dataclass(slots=True)
class Outcome:
    """What was wrong with a run, and how far it had come."""

    wrong: list[str] = field(default_factory=list)
    status: int = 0
    cases: int = 0
    left: int = 0
    seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class Bench:
    """Where runs go: the options that lead there, and what a program needs in its environment.

    ``node_ids`` are the devices.
    """

    node_ids: list[int]
    options: tuple[str, ...]
    environment: dict[str, str]
    has_device: bool


@dataclass(frozen=True, slots=True)
class Moment:
    """Seconds after the start, or after the run has ``begun`` to write its reports."""

    after: float
    begun: bool

    def __str__(self) -> str:
        return f"{self.after:.2f} s after {'its reports were begun' if self.begun else 'its start'}"


def await_report(folder: Path, run: subprocess.Popen[bytes]) -> float:
    """Wait until a run has a report folder, or has ended; return the seconds that took."""
    begin = time.monotonic()
    reports = folder / "reports"
    while not (reports.is_dir() and any(reports.iterdir())) and run.poll() is None:
        time.sleep(0.01)
    return time.monotonic() - begin


@contextmanager
def bench_of(name: str, folder: Path, devices: int, workers: int) -> Iterator[Bench]:
    """Open one of the buses."""
    node_ids = list(range(FIRST, FIRST + devices))
    more = ["-n", str(workers)] if workers else []
    more.append(f"--node-id={','.join(map(str, node_ids))}")
    if name == "self-test":
        yield Bench(node_ids, ("--self-test", *more), {}, has_device=False)
        return
    with stand_in(folder) if name == "stand-in" else socketcan(CHANNEL) as bus:
        yield Bench(node_ids, (*_on(bus), *more), dict(bus.environment), has_device=True)


def _on(bus: Bus) -> tuple[str, ...]:
    named = (f"--sdo-object={name}" for name in OBJECTS)
    return ("--can-interface=socketcan", f"--can-channel={bus.channel}", *named)


def stopped(bench: Bench, folder: Path, number: int | None, moment: Moment) -> Outcome:
    """Run, send a signal at a moment, and look at what is left."""
    device = f"{sys.executable} {DEVICE} {folder} {{node_id}} socketcan {CHANNEL}"
    process = (f"--sdo-process={device}",) if bench.has_device else ()
    command = [
        *(sys.executable, "-u", "-m", "pytest", "-v", "-p", "no:cacheprovider"),
        *("-p", "no:hypothesispytest", f"--rootdir={folder}", "-c", os.devnull, *SELECTED),
        *(f"--sdo-report-dir={folder / 'reports'}", *bench.options, *process, *map(str, CASES)),
    ]
    python = {"PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}
    outcome = Outcome()
    with (folder / "output.txt").open("w") as output:
        run = subprocess.Popen(  # noqa: S603 - it is our own
            command,
            cwd=folder,
            env=os.environ | python | bench.environment,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            if moment.begun:
                await_report(folder, run)
            if number is not None:
                time.sleep(moment.after)
                run.send_signal(number)
            begin = time.monotonic()
            outcome.status = run.wait(HANGS)
            outcome.seconds = time.monotonic() - begin
        except subprocess.TimeoutExpired:
            outcome.wrong.append("it hangs")
            os.killpg(run.pid, signal.SIGKILL)
            run.wait()
            return outcome
    _check(outcome, folder, bench, number)
    return outcome


def _check(outcome: Outcome, folder: Path, bench: Bench, number: int | None) -> None:
    output = (folder / "output.txt").read_text(encoding="utf-8", errors="replace")
    has_begun = (folder / "reports").is_dir()
    allowed = {0} if number in (None, signal.SIGKILL) else {0, INTERRUPTED}
    if number is not None and (number == signal.SIGKILL or not has_begun):
        allowed.add(-number)  # Python itself was starting, or nothing could be done
        if not has_begun and output.endswith("KeyboardInterrupt\n"):
            allowed.add(1)  # Python was looking for what to start
    if outcome.status not in allowed:
        said = " / ".join(output.splitlines()[-MOST_SAID:])
        outcome.wrong.append(f"exit status {outcome.status}: {said}")
    if has_begun and ("Traceback" in output or "INTERNALERROR" in output):
        outcome.wrong.append("it shows a traceback")
    if has_begun:
        _check_record(outcome, folder, bench, output, number)
        _check_values(outcome, folder, bench)
    _check_processes(outcome, folder)


def item_name(case_id: str, node_id: int, *, several: bool) -> str:
    """Return what pytest calls a case on a device.

    >>> item_name("frame.short[1]", 5, several=True)
    'frame.short@5[1]'
    """
    name, bracket, variation = case_id.partition("[")
    return f"{name}@{node_id}{bracket}{variation}" if several else case_id


def _check_record(
    outcome: Outcome, folder: Path, bench: Bench, output: str, number: int | None
) -> None:
    (report,) = (folder / "reports").iterdir()
    try:
        run = read_run(report)
    except NotRecorded as error:
        if TOLD.search(output):
            outcome.wrong.append(str(error))
        return
    outcome.cases = len(run.results)
    recorded = {
        item_name(result.case_id, result.node_id, several=len(bench.node_ids) > 1)
        for result in run.results
    }
    missing = set(TOLD.findall(output)) - recorded
    if missing:
        outcome.wrong.append(f"{len(missing)} cases were told and are not in the record")
    if number == signal.SIGKILL:
        with Path(os.devnull).open("w") as nowhere:
            sys.stdout, before = nowhere, sys.stdout
            status = main(["report", str(report)])
            sys.stdout = before
        if status != DONE:
            outcome.wrong.append("there is no report of it")
    elif run.end is None:
        outcome.wrong.append("its record has no end")
    text = (report / "junit.xml").read_text(encoding="utf-8")
    if (run.end is None) != ("the run was killed" in text):
        outcome.wrong.append("its report does not say how it ended")


def _check_values(outcome: Outcome, folder: Path, bench: Bench) -> None:
    (report,) = (folder / "reports").iterdir()
    listed = {
        (left.node_id, str(mux)): value.hex()
        for path in journals(report)
        for left in read_journal(path)[1]
        for mux, value in left.values.items()
    }
    outcome.left = len(listed)
    if outcome.status in (0, INTERRUPTED) and listed:
        outcome.wrong.append(f"{sorted(listed)} were not put back")
    for node_id in bench.node_ids:
        memory = memory_of(folder, node_id)
        if not bench.has_device or not memory.exists():
            continue
        held = json.loads(memory.read_text(encoding="utf-8"))["values"]
        for name, value in initial_values(node_id).items():
            if held[name] != value and listed.get((node_id, name)) != value:
                outcome.wrong.append(f"{name} of node {node_id} is neither back nor listed")


def initial_values(node_id: int) -> dict[str, str]:
    """Return what a device holds at first."""
    return {str(mux): entry.value.hex() for mux, entry in reference_entries(node_id).items()}


def _check_processes(outcome: Outcome, folder: Path) -> None:
    """Wait until nothing that names the folder runs any more."""
    deadline = time.monotonic() + GONE_WITHIN
    while found := _running(folder):
        if time.monotonic() > deadline:
            outcome.wrong.append(f"it goes on: {found}")
            for process in found:
                os.kill(process, signal.SIGKILL)
            return
        time.sleep(0.05)


def _running(folder: Path) -> list[int]:
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                text = (entry / "cmdline").read_bytes() + (entry / "environ").read_bytes()
            except OSError:
                continue
            if os.fsencode(folder) in text and int(entry.name) != os.getpid():
                found.append(int(entry.name))
    return found


def main_program() -> int:
    """Run all and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("buses", nargs="+", choices=["self-test", "stand-in", "socketcan"])
    parser.add_argument("--times", type=int, default=50)
    parser.add_argument("--signals", nargs="+", choices=SIGNALS, default=list(SIGNALS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=0)
    parser.add_argument("--devices", type=int, default=1)
    options = parser.parse_args()
    chosen = random.Random(options.seed)
    failures = 0
    with tempfile.TemporaryDirectory(prefix="stopped-") as name:
        base = Path(name)
        for bus in options.buses:
            with bench_of(bus, base / "built", options.devices, options.workers) as bench:
                whole = base / f"{bus}-whole"
                whole.mkdir()
                first = stopped(bench, whole, None, Moment(0.0, begun=True))
                print(f"{bus}: the cases take {first.seconds:.1f} s: {first.wrong or 'all well'}")
                for kind in options.signals:
                    outcomes = []
                    for turn in range(options.times):
                        folder = base / f"{bus}-{kind}-{turn}"
                        folder.mkdir()
                        at_start = turn % STARTS == 0
                        after = chosen.uniform(0, STARTING if at_start else first.seconds)
                        moment = Moment(after, begun=not at_start)
                        found = stopped(bench, folder, SIGNALS[kind], moment)
                        outcomes.append(found)
                        for wrong in found.wrong:
                            failures += 1
                            print(f"  {bus} SIG{kind} {turn}, {moment}: {wrong}")
                    _tell(bus, kind, outcomes)
    return 1 if failures else 0


def _tell(bus: str, kind: str, outcomes: list[Outcome]) -> None:
    well = sum(not outcome.wrong for outcome in outcomes)
    statuses = dict(sorted(Counter(outcome.status for outcome in outcomes).items()))
    begun = sum(outcome.cases > 0 for outcome in outcomes)
    left = sum(outcome.left > 0 for outcome in outcomes)
    longest = max((outcome.seconds for outcome in outcomes), default=0.0)
    print(
        f"{bus} SIG{kind}: {well} of {len(outcomes)} well; exit status: {statuses}; {begun} in the "
        f"middle of the cases; {left} with values listed; at most {longest:.1f} s to end",
        flush=True,
    )


if __name__ == "__main__":
    sys.exit(main_program())
