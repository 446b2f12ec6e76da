"""Measures which case catches which fault at how many requests, and orders the cases by that.

    python tests/faults/worth.py catches [--workers N] [NAME ...]   # half an hour
    python tests/faults/worth.py order                              # two minutes
    python tests/faults/worth.py quick [--workers N] [NAME ...]     # a quarter of an hour

``catches`` adds the faults to ``catches.json`` that are not in it yet, one after another; it may be
ended and begun again. NAMEs are measured anew. It takes scripts of few requests; a fault that they
do not catch meets the cases that it names. Faults that take a thorough run are left out. ``order``
counts the requests of each case, and writes ``conformance/plugin/case_order.json``, by which a run
orders its cases and ``--sdo-quick`` chooses them.
``quick`` runs that choice against all faults that show without a declared time-out. What catches
one there is added to ``catches.json``; what does not, though it has in another order, is taken out
where no other case catches the fault either. The next ``order`` chooses by that.
"""

import argparse
import json
import os
import sys
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

from case_runs import AT_THE_END, run_cases
from catches import Catchers, Catches, measure, read_catches, write_catches
from counting import ByFile, count
from cover import CATCHERS, Choice, Costs, by_worth, family_of
from detection import (
    HUGE,
    TIMEOUT_OF_FAULTS,
    scripts,
)
from early import EARLY, early_cases

from conformance.device.effort import REQUESTS_IN_HASTE, REQUESTS_OF_SMALL_CASE
from conformance.faults.catalogue import faults, find_deviation
from conformance.plugin import case_order
from conformance.plugin.exit_code import ExitCode
from conformance.run.verdict import Verdict

TABLE = Path(case_order.__file__).with_suffix(".json")
# A value that is written by one of these and read by another is written once.
ONE_EXCHANGE = ("segmented-upload.size", "segmented-download.size")
# How often a quick run is made and counted: then its cases cost what they were thought to.
ROUNDS = 12
# A device of which nothing may be written.
READ_ONLY = "--sdo-object=1000=unsigned32,ro"


def caught_by_quick(name: str) -> tuple[bool, dict[str, float]]:
    """Say whether a quick run fails a fault, or ends with it, and which of its cases catch it."""
    deviation = find_deviation(name)
    assert deviation is not None
    catchers = Catchers(deviation.soft)
    timeout = f"--sdo-response-timeout={TIMEOUT_OF_FAULTS}"
    run = run_cases(name, "--sdo-quick", timeout, plugins=[catchers])
    lost = run.exit_code == ExitCode.DEVICE_LOST
    return bool(run.failed(strict=deviation.soft)) or lost, catchers.found


def prove_quick(names: Sequence[str], workers: int) -> None:
    """Run a quick run against faults, and let what was measured say what it shows."""
    shown = [
        each.name
        for each in faults()
        if not (each.timed or each.thorough) and (each.name in names or not names)
    ]
    chosen = {case for case, known in case_order.table().items() if known.quick}
    catches = read_catches()
    missed = []
    with ProcessPoolExecutor(workers) as pool:
        for name, (caught, found) in zip(shown, pool.map(caught_by_quick, shown), strict=True):
            if not caught:
                missed.append(name)
                print(f"{name} is not caught", flush=True)
                for case in catches[name].keys() & chosen:
                    del catches[name][case]
            catches[name] |= found
            write_catches(catches)
    print(f"a quick run catches {1 - len(missed) / len(shown):.1%} of {len(shown)} faults")


def needs(catches: Catches, costs: Costs, services: Mapping[str, str]) -> dict[str, set[str]]:
    """Return what each case catches; a quick run has each service and each class of defect too."""
    about = {fault.name: f"class {fault.defect}" for fault in faults()}
    needed: defaultdict[str, set[str]] = defaultdict(set)
    for name, found in catches.items():
        for case in found.keys() & costs.each.keys():
            if not case.startswith(AT_THE_END):
                needed[case] |= {name, about[name], f"service {services[case]}"}
    return dict(needed)


def own_catchers(found: Mapping[str, float], costs: Costs) -> dict[str, float]:
    """Return the catchers of a fault that have requests of their own."""
    own = found.keys() & costs.each.keys()
    return {case: found[case] for case in own if not case.startswith(AT_THE_END)}


@dataclass(frozen=True, slots=True)
class Table:
    """The content of ``plugin/case_order.json``, without the requests of a quick run."""

    total: int
    catches: Catches
    costs: Costs
    order: Sequence[str]
    needs_write: Collection[str]

    def write(self, quick: Mapping[str, int], beside: int) -> None:
        """Write it with the cases of a quick run, what each sends there, and what is ``beside``."""
        usual = {name: own_catchers(found, self.costs) for name, found in self.catches.items()}
        order = list(dict.fromkeys([*self.order, *quick]))
        early = early_cases(order, quick, usual, self.costs.shared(), self.total)
        places = {case: place for place, case in enumerate(order)}
        caught: defaultdict[str, list[int]] = defaultdict(list)
        names = sorted(self.catches)
        for number, name in enumerate(names):
            catchers = sorted(usual[name].keys() & places.keys(), key=places.__getitem__)
            for case in {*catchers[:CATCHERS], *(usual[name].keys() & set(quick))}:
                caught[case].append(number)
            for case in self.catches[name].keys() - usual[name].keys():
                caught[case].append(number)
        judging = [case for case in self.costs.each if case.startswith(AT_THE_END)]
        rows: dict[str, list[object]] = {
            case: [
                quick.get(case) or self.costs.of([case]),
                int(case in self.needs_write),
                int(case in quick),
                int(case in early),
                caught[case],
            ]
            for case in [*order, *judging]
            if caught[case] or case in judging
        }
        write_table(
            {"requests": self.total, "beside": beside, "early": 0, "faults": names, "cases": rows}
        )


def write_table(kept: Mapping[str, Any]) -> None:
    """Write the table, a line for each case."""
    listed = ",\n".join(
        f"{json.dumps(case)}: {json.dumps(row, separators=(',', ':'))}"
        for case, row in kept["cases"].items()
    )
    head = ", ".join(f'"{name}": {kept[name]}' for name in ("requests", "beside", "early"))
    TABLE.write_text(
        f'{{{head},\n"faults": {json.dumps(kept["faults"])},\n"cases": {{\n{listed}\n}}}}\n',
        encoding="utf-8",
    )
    case_order.forget()


def count_early(usual: Catches) -> None:
    """Choose the early cases anew by what they cost in a run in the new order, and count them.

    What is more than a tenth of the run is early no more.
    """
    kept, run = json.loads(TABLE.read_text(encoding="utf-8")), count()
    rows = kept["cases"]
    order = [case for case in rows if not case.startswith(AT_THE_END)]
    quick = [case for case in order if rows[case][2]]
    costs = as_the_first({case: run.requests.get(case) or rows[case][0] for case in order})
    early = early_cases(order, quick, usual, costs, run.total)
    for case, row in rows.items():
        row[3] = int(case in early)
    write_table(kept)
    run = count()
    kept["requests"] = run.total
    for case, requests in run.requests.items():
        if case in early:
            rows[case][3] = int(kept["early"] + requests <= EARLY * run.total)
            kept["early"] += requests * rows[case][3]
    write_table(kept)


def costs_of(
    counted: Sequence[Mapping[str, int]], quick_runs: Sequence[Mapping[str, int]]
) -> Costs:
    """Return what cases cost: in quick runs if they were in one, the first of some more."""
    costs = Costs.by(*counted, *quick_runs)
    for requests in quick_runs:
        costs.correct(requests)
    costs.each |= {case: max(costs.each.values()) for case in costs.each if HUGE in case}
    costs.each = as_the_first(costs.each)
    return costs


def as_the_first(costs: Mapping[str, int]) -> dict[str, int]:
    """Let each case on a length cost what it does where it writes the value for the others.

    In a run that is the first of them, whichever it is.
    """
    dearest: dict[str, int] = {}
    for case, requests in costs.items():
        if family_of(case) in ONE_EXCHANGE:
            length = case.partition("[")[2]
            dearest[length] = max(dearest.get(length, 0), requests)
    return {
        case: dearest[case.partition("[")[2]] if family_of(case) in ONE_EXCHANGE else requests
        for case, requests in costs.items()
    }


def cheapest_of_missing(
    quick: Collection[str], needed: Mapping[str, set[str]], costs: Costs
) -> list[str]:
    """Return the cheapest case for each fault that a quick run does not show, but for dear ones."""
    shown = {name for case in quick for name in needed[case]}
    found: dict[str, str] = {}
    for case in sorted(needed, key=costs.each.__getitem__):
        if costs.each[case] <= REQUESTS_OF_SMALL_CASE:
            for name in needed[case] - shown:
                found.setdefault(name, case)
    return sorted(set(found.values()) - set(quick))


def make_table() -> None:
    """Count the requests, and write the table of the package."""
    with ProcessPoolExecutor() as pool:
        whole = pool.submit(count)
        in_files = pool.submit(count, *scripts(), plugins=[ByFile()])
        without_writes = pool.submit(count, READ_ONLY, *scripts())
        everything, read_only = whole.result(), without_writes.result().verdicts
    counted = [everything.requests, in_files.result().requests]
    costs = costs_of(counted, [])
    catches = read_catches()
    untestable = (Verdict.NOT_TESTABLE, None)
    needs_write = {case for case in costs.each if read_only.get(case) in untestable}
    usual = {name: own_catchers(found, costs) for name, found in catches.items()}
    order = by_worth(usual, costs.shared())
    table = Table(everything.total, catches, costs, order, needs_write)
    best: dict[str, int] = {}
    most = 0
    quick = [
        case for case, known in case_order.table().items() if known.quick and case in costs.each
    ]
    needed = needs(catches, costs, everything.services)
    quick += cheapest_of_missing(quick, needed, costs)  # what they cost there shows at once
    quick_runs: list[Mapping[str, int]] = []
    for number in range(ROUNDS):
        table.write(dict.fromkeys(quick, 1), REQUESTS_IN_HASTE - len(quick))  # and no others
        sent = count("--sdo-quick")
        beside = sent.total - sum(sent.requests.values())
        found = len({name for case in quick for name in needed[case]})
        print(f"{sent.total} requests, {beside} beside the cases: {found} faults", flush=True)
        if sent.total <= REQUESTS_IN_HASTE and found > most:
            most, best = found, {case: sent.requests[case] for case in quick}
        quick_runs.append(sent.requests)
        costs = costs_of(counted, quick_runs)
        budget = REQUESTS_IN_HASTE - sent.total + costs.of(quick)
        quick = Choice(needed, costs, budget, Random(number)).best(best or quick)
    if not best:
        raise SystemExit("no choice of cases for a quick run keeps to its requests")
    table.write(best, REQUESTS_IN_HASTE - sum(best.values()))  # no room for others
    count_early(usual)


def main() -> int:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("catches", "order", "quick"))
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_intermixed_args()
    if options.what == "catches":
        measure(options.names, options.workers)
    elif options.what == "quick":
        prove_quick(options.names, options.workers)
    else:
        make_table()
    return 0


if __name__ == "__main__":
    sys.exit(main())
