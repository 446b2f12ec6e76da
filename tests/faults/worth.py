"""Measures which case catches which fault at how many requests, and orders the cases by that.

    python tests/faults/worth.py catches [--workers N] [NAME ...]   # half an hour
    python tests/faults/worth.py order                              # a minute

``catches`` adds the faults to ``catches.json`` that are not in it yet, one after another; it may be
ended and begun again. NAMEs are measured anew. It takes scripts of few requests; a fault that they
do not catch meets the cases that it names. ``order`` counts the requests of each case, and writes
``conformance/plugin/worth.json``, by which a run orders its cases and ``--sdo-quick`` chooses them.
"""

import argparse
import json
import os
import sys
from collections import defaultdict
from collections.abc import Collection, Generator, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

import pytest
from case_runs import AT_THE_END, FAILED, run_cases
from detection import (
    EXAMPLES_OF_FAULTS,
    TIMEOUT_OF_FAULTS,
    files_of,
    kind_of,
    scripts,
    timing_of,
)
from pairs import spread

from conformance.faults.catalogue import faults, find_deviation
from conformance.faults.registry import About
from conformance.plugin import worth
from conformance.plugin.items import CaseFunction, ordered
from conformance.run.verdict import CaseResult, Verdict

CATCHES = Path(__file__).with_name("catches.json")
TABLE = Path(worth.__file__).with_suffix(".json")
# A script of more requests than this meets no fault but those that name it.
CHEAP = 40
# Nor do more variations of a case than this.
MOST_VARIATIONS = 3
# So many cases for each fault are in the table: a device may lack what the first of them needs.
CATCHERS = 4
# So much more counts a case that fails by a rule that it tests itself.
OWN = 1.25
# A device of which nothing may be written.
READ_ONLY = "--sdo-object=1000=unsigned32,ro"

Catches = dict[str, dict[str, float]]
"""The cases that catch each fault; OWN for those whose own rule it breaks, else 1."""


@dataclass(slots=True)
class Catchers:
    """A pytest plugin that notes which cases catch a fault.

    Those that fail, and those that have come across what an earlier case had failed for: they would
    fail before it.
    """

    soft: bool
    left_out: frozenset[str] = frozenset()
    found: dict[str, float] = field(default_factory=dict)

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out what is dear."""
        items[:] = [
            item
            for item in items
            if isinstance(item, CaseFunction) and item.case_id not in self.left_out
        ]

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take the result of a case."""
        values = getattr(report, "conformance", None)
        if values is None:
            return
        result = CaseResult.from_dict(values)
        failed = (*FAILED, Verdict.NON_STRICT) if self.soft else FAILED
        prevented = result.verdict is Verdict.NOT_TESTABLE and result.cause
        if result.verdict in failed and result.tested_rules & result.broken_rules:
            self.found[result.case_id] = OWN
        elif result.verdict in failed or result.met or prevented:
            self.found[result.case_id] = 1


def catchers_of(name: str, left_out: frozenset[str]) -> dict[str, float]:
    """Return the cases that catch a fault: some of all, or else of those that it names."""
    deviation = find_deviation(name)
    assert deviation is not None
    examples = EXAMPLES_OF_FAULTS if deviation.about is About.HISTORY else 20
    named = ("-k", " or ".join(deviation.caught_by), *files_of(*deviation.caught_by))
    some, all_of_them = Catchers(deviation.soft, left_out), Catchers(deviation.soft)
    tries = [(some, 0, scripts()), (all_of_them, examples, named)]
    for catchers, number, arguments in tries[deviation.timed :]:
        run_cases(
            name,
            *timing_of(deviation),
            f"--sdo-response-timeout={TIMEOUT_OF_FAULTS}",
            f"--sdo-examples={number}",
            *arguments,
            simulated=not deviation.timed,
            plugins=[catchers],
        )
        if catchers.found:
            return catchers.found
    return {}


def candidates(costs: Mapping[str, int]) -> set[str]:
    """Return the scripts that meet each fault: of few requests, some variations of each."""
    families: defaultdict[str, list[str]] = defaultdict(list)
    for case, requests in costs.items():
        if requests <= CHEAP and kind_of(case) == "scripts":
            families[case.partition("[")[0]].append(case)
    return {case for cases in families.values() for case in spread(cases, MOST_VARIATIONS)}


def read_catches() -> Catches:
    """Return what was measured so far; negative numbers stand for cases that fail by their rule."""
    if not CATCHES.exists():
        return {}
    kept = json.loads(CATCHES.read_text(encoding="utf-8"))
    cases = kept["cases"]
    return {
        name: {cases[abs(number) - 1]: OWN if number < 0 else 1 for number in numbers}
        for name, numbers in kept["faults"].items()
    }


def write_catches(catches: Catches) -> None:
    """Keep what was measured, a line for each fault."""
    cases = sorted({case for found in catches.values() for case in found})
    numbers = {case: number for number, case in enumerate(cases, start=1)}
    lines = []
    for name, found in sorted(catches.items()):
        signed = sorted(
            (-1 if weight == OWN else 1) * numbers[case] for case, weight in found.items()
        )
        lines.append(f"{json.dumps(name)}: {json.dumps(signed, separators=(',', ':'))}")
    text = (
        '{"cases": '
        + json.dumps(cases, indent=0)
        + ',\n"faults": {\n'
        + ",\n".join(lines)
        + "\n}}\n"
    )
    part = CATCHES.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    part.replace(CATCHES)


def measure(names: Sequence[str], workers: int) -> None:
    """Add what is not known yet, fault by fault."""
    catches = {name: found for name, found in read_catches().items() if name not in names}
    wanted = [fault.name for fault in faults() if fault.name not in catches]
    wanted = [name for name in wanted if name in names or not names]
    Random(1).shuffle(wanted)
    costs = count(*scripts(), plugins=[ByFile()]).requests
    left_out = frozenset(costs) - candidates(costs)
    with ProcessPoolExecutor(workers) as pool:
        awaited = {pool.submit(catchers_of, name, left_out): name for name in wanted}
        for number, each in enumerate(as_completed(awaited), start=1):
            catches[awaited[each]] = each.result()
            write_catches(catches)
            print(f"{number}/{len(wanted)} {awaited[each]}: {len(each.result())}", flush=True)


class Counter:
    """A pytest plugin that counts the frames that each case sends, by the log of the bus."""

    def __init__(self) -> None:
        """Nothing has been run yet."""
        self.verdicts: dict[str, Verdict] = {}
        self._places: dict[str, tuple[int, int]] = {}
        self._sent = [0]

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take the place of the frames of a case."""
        values = getattr(report, "conformance", None)
        place = getattr(report, "conformance_frames", None)
        if values is not None and place is not None:
            self.verdicts[values["case_id"]] = Verdict(values["verdict"])
            self._places[values["case_id"]] = (place["first"], place["last"])

    @pytest.hookimpl(trylast=True)
    def pytest_unconfigure(self, config: pytest.Config) -> None:
        """Read the log while it is there."""
        (log,) = Path(config.getoption("sdo_report_dir")).glob("*/bus.log")
        for line in log.read_text("utf-8").splitlines():
            self._sent.append(self._sent[-1] + line.endswith(" T"))

    @property
    def requests(self) -> dict[str, int]:
        """How many frames each case has sent."""
        return {
            case: self._sent[last] - self._sent[first - 1] if first <= last else 0
            for case, (first, last) in self._places.items()
        }

    @property
    def total(self) -> int:
        """How many frames the run has sent, with those beside the cases."""
        return self._sent[-1]


class ByFile:
    """A pytest plugin that leaves the cases in the order of the files."""

    @pytest.hookimpl(wrapper=True)
    def pytest_collection_modifyitems(
        self, items: list[pytest.Item]
    ) -> Generator[None, object, object]:
        """Undo the order of a run, but for what judges it."""
        before = ordered(items, as_files=True)
        outcome = yield
        items[:] = before
        return outcome


def count(*arguments: str, plugins: Sequence[object] = ()) -> Counter:
    """Count what the cases send to the built-in device."""
    counter = Counter()
    run = run_cases(None, *arguments, plugins=[counter, *plugins])
    if run.exit_code:
        raise SystemExit(f"the self-test fails: {run.exit_code}")
    return counter


def cover(catches: Catches, costs: Mapping[str, int], left_out: Collection[str]) -> Iterable[str]:
    """Yield cases that catch all faults together: next, what catches most per request."""
    caught_by: defaultdict[str, dict[str, float]] = defaultdict(dict)
    for name, found in catches.items():
        for case, weight in found.items():
            if case in costs and case not in left_out and not case.startswith(AT_THE_END):
                caught_by[case][name] = weight
    while caught_by:
        best = max(caught_by, key=lambda case: sum(caught_by[case].values()) / max(costs[case], 1))
        gone = set(caught_by.pop(best))
        yield best
        for case in list(caught_by):
            for name in gone & caught_by[case].keys():
                del caught_by[case][name]
            if not caught_by[case]:
                del caught_by[case]


def by_worth(catches: Catches, costs: Mapping[str, int]) -> list[str]:
    """Return the cases that are worth an early place, the best first."""
    places: dict[str, None] = {}
    for _ in range(CATCHERS):
        places.update(dict.fromkeys(cover(catches, costs, places)))
    return list(places)


def make_table() -> None:
    """Count the requests, and write the table of the package."""
    with ProcessPoolExecutor() as pool:
        usual = pool.submit(count)
        in_files = pool.submit(count, *scripts(), plugins=[ByFile()])
        without_writes = pool.submit(count, READ_ONLY, *scripts())
        total, read_only = usual.result().total, without_writes.result().verdicts
    # In whichever order it is more: the first of some cases does what all of them need.
    by_file = in_files.result().requests
    costs = {
        case: max(requests, by_file.get(case, 0))
        for case, requests in usual.result().requests.items()
        if requests  # or it needs what the self-test does not declare
    }
    catches = read_catches()
    order = by_worth(catches, costs)
    places = {case: place for place, case in enumerate(order)}
    names = sorted(catches)
    caught: defaultdict[str, list[int]] = defaultdict(list)
    for number, name in enumerate(names):
        catchers = sorted(places[case] for case in catches[name] if case in places)
        for place in catchers[:CATCHERS]:
            caught[order[place]].append(number)
    untestable = (Verdict.NOT_TESTABLE, None)
    rows = [
        f"{json.dumps(case)}: [{costs[case]}, {int(read_only.get(case) in untestable)}, "
        f"{json.dumps(caught[case], separators=(',', ':'))}]"
        for case in order
        if caught[case]
    ]
    rows += [
        f"{json.dumps(case)}: [{requests}, 0, {json.dumps(judged, separators=(',', ':'))}]"
        for case, requests in costs.items()
        if case.startswith(AT_THE_END)
        for judged in [[number for number, name in enumerate(names) if case in catches[name]]]
    ]
    listed = ",\n".join(rows)
    beside = 0
    while True:
        TABLE.write_text(
            f'{{"requests": {total}, "beside": {beside},\n'
            f'"faults": {json.dumps(names)},\n"cases": {{\n{listed}\n}}}}\n',
            encoding="utf-8",
        )
        worth.forget()
        sent = count("--sdo-quick").total
        if beside > worth.QUICK:
            raise SystemExit("what comes beside the cases of a quick run is more than it may send")
        print(f"a quick run sends {sent} requests, {beside} of them beside the cases", flush=True)
        if sent <= worth.QUICK:
            return
        beside += sent - worth.QUICK


def main() -> int:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("catches", "order"))
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_intermixed_args()
    if options.what == "catches":
        measure(options.names, options.workers)
    else:
        make_table()
    return 0


if __name__ == "__main__":
    sys.exit(main())
