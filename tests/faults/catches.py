"""Which case catches which fault: measured with every fault, and kept in ``catches.json``."""

import json
from collections import defaultdict
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

import pytest
from case_runs import FAILED, run_cases
from counting import ByFile, count
from detection import (
    EXAMPLES_OF_FAULTS,
    TIMEOUT_OF_FAULTS,
    conditions_of,
    files_of,
    kind_of,
    scripts,
)
from pairs import spread

from conformance.faults.catalogue import faults, find_deviation
from conformance.faults.registry import About
from conformance.plugin.items import CaseFunction
from conformance.run.verdict import CaseResult, Verdict

CATCHES = Path(__file__).with_name("catches.json")
# A script of more requests than this meets no fault but those that name it.
CHEAP = 40
# Nor do more variations of a case than this.
MOST_VARIATIONS = 3
# So much more counts a case that fails by a rule that it tests itself.
OWN = 1.25

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
            *conditions_of(deviation),
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
    wanted = [each.name for each in faults() if not each.thorough and each.name not in catches]
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
