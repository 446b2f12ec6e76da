"""The runs in a folder, by device; of each only what a table shows is kept."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from operator import itemgetter
from pathlib import Path

from conformance.reporting.cause_counts import causes_of
from conformance.reporting.page.writing import PAGE
from conformance.reporting.recorded import NotRecorded, RecordedRun, read_run
from conformance.reporting.results import RESULTS
from conformance.run.verdict import FAILED, NOT_TESTED, CaseResult, Verdict

NAME = "1008h:00"
FIRMWARE = "100Ah:00"
# What is the same device whatever program it runs.
OWN = ("vendor-id", "product-code", "serial-number")
DAY, MINUTE = 10, 16


class Outcome(StrEnum):
    """How the test of a device ended."""

    PASSED = "pass"
    FAILED = "fail"
    UNFINISHED = "killed"
    NOT_TESTED = "not tested"
    OTHER = "bench error"


@dataclass(frozen=True, slots=True)
class TestedOnce:
    """A device in one run: where the run lies, when it began, and what came of it.

    ``page`` is its report.html; None where there is none. ``firmware`` is what the device called
    its software.
    """

    folder: Path
    page: Path | None
    begun: str
    outcome: Outcome
    tested: int
    failed: int
    causes: int
    firmware: str

    @property
    def day(self) -> str:
        """The date on which the run began."""
        return self.begun[:DAY]

    @property
    def time(self) -> str:
        """The time of day at which it began."""
        return self.begun[DAY + 1 : MINUTE]

    @property
    def counts(self) -> str:
        """How many cases were tested and failed, and for how many causes."""
        if not self.failed:
            return f"{self.tested} tested"
        causes = f", {self.causes} {'cause' if self.causes == 1 else 'causes'}"
        return f"{self.failed} of {self.tested} failed{causes if self.causes else ''}"


@dataclass(slots=True)
class Tested:
    """A device and the runs that tested it, the latest first."""

    name: str
    about: str
    runs: list[TestedOnce] = field(default_factory=list)

    def on(self, day: str) -> list[TestedOnce]:
        """Return the runs of a date."""
        return [each for each in self.runs if each.day == day]


@dataclass(slots=True)
class Overview:
    """All devices in a folder of runs, by name; ``notes`` say what could not be read."""

    folder: Path
    devices: list[Tested] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @property
    def days(self) -> list[str]:
        """The dates of all runs, the latest first."""
        return sorted({each.day for device in self.devices for each in device.runs}, reverse=True)

    @property
    def runs(self) -> int:
        """How many runs there are."""
        return len({each.folder for device in self.devices for each in device.runs})


def read_overview(folder: Path) -> Overview:
    """Read all runs in a folder, one after another; raises OSError, and NotRecorded for none."""
    overview = Overview(folder)
    devices: dict[tuple[str, ...], Tested] = {}
    for path in sorted(folder.iterdir()):
        if not (path / RESULTS).is_file():
            continue
        try:
            run = read_run(path)
        except NotRecorded as error:
            overview.notes.append(str(error))
            continue
        for key, device, once in _tested(path, run):
            devices.setdefault(key, device).runs.append(once)
    _join_silent(devices)
    if not devices and not overview.notes:
        raise NotRecorded(f"{folder} has no folders of runs, which contain {RESULTS}.")
    for device in devices.values():
        device.runs.sort(key=lambda each: each.begun, reverse=True)
    overview.devices = sorted(devices.values(), key=lambda each: (each.name, each.about))
    return overview


def _join_silent(devices: dict[tuple[str, ...], Tested]) -> None:
    """Give runs in which a device was silent to the device with that node-ID that was met before.

    Behind the last such run it may have been met for the first time: then to the first one.
    """
    for key in [key for key in devices if not any(key[2:])]:
        same = [one for other, one in devices.items() if other[:2] == key[:2] and any(other[2:])]
        if not same:
            continue
        for once in devices.pop(key).runs:
            earlier = [
                (run.begun, device)
                for device in same
                for run in device.runs
                if run.begun <= once.begun
            ]
            nearest = max(earlier, key=itemgetter(0))[1] if earlier else same[0]
            nearest.runs.append(once)


def _tested(folder: Path, run: RecordedRun) -> Iterator[tuple[tuple[str, ...], Tested, TestedOnce]]:
    """Yield each device of a run, what makes it the same in another run, and what came of it."""
    known = {device["node_id"]: device for device in run.devices}
    server = run.about.get("server") or "reference server" if run.about["self_test"] else ""
    page = folder / PAGE
    causes = causes_of(run)
    for node_id in run.about["node_ids"]:
        device = known.get(node_id, {"identity": {}, "texts": {}})
        own = [device["identity"].get(name, "") for name in OWN]
        name = server or device["texts"].get(NAME, "") or f"node {node_id}"
        parts = [f"{part} {value}" for part, value in zip(OWN, own, strict=True) if value]
        about = ", ".join([f"node {node_id}", *parts])
        results = [result for result in run.results if result.node_id == node_id]
        once = TestedOnce(
            folder,
            page if page.is_file() else None,
            run.about["begun"],
            _outcome(run, results),
            sum(result.verdict not in NOT_TESTED for result in results),
            len(_failed(run, results)),
            sum(count.node_id == node_id for count in causes),
            device["texts"].get(FIRMWARE, ""),
        )
        yield (server, str(node_id), *own), Tested(name, about), once


def _failed(run: RecordedRun, results: list[CaseResult]) -> list[CaseResult]:
    failing = (*FAILED, *((Verdict.NON_STRICT,) if run.about["strict"] else ()))
    return [result for result in results if result.verdict in failing]


def _outcome(run: RecordedRun, results: list[CaseResult]) -> Outcome:
    if run.end is None:
        return Outcome.UNFINISHED
    if any(result.verdict is not Verdict.BENCH_ERROR for result in _failed(run, results)):
        return Outcome.FAILED
    if all(result.verdict in NOT_TESTED for result in results):
        return Outcome.NOT_TESTED
    status = run.end["exit_status"]
    others_failed = status == 1 and bool(_failed(run, run.results))
    if status == 0 or others_failed:
        return Outcome.PASSED
    return Outcome.FAILED if status == 1 else Outcome.OTHER
