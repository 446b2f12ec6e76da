"""Runs the cases against servers with faults that nobody chose, and prints what share is caught.

    python tests/mutants/measure.py [--share N] [--workers N] [--only KIND] [NAME ...]

The kinds are ``guarded`` (faults of the catalogue that show only under a condition), ``mutants``
(of the source of the reference server) and ``transitions`` (to a wrong next state). Each N-th of
them is measured, by a fixed seed. A server meets a quick run, and where this passes a whole one,
each up to its first failure. What lives is printed, unless ``judged.toml`` lists it with the
reason why no client can tell it from a right server. NAMEs are measured whatever their share.
"""

import argparse
import math
import os
import random
import signal
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from functools import cache
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent / each) for each in ("", "faults")]

from case_runs import run_cases  # noqa: E402
from drawn import drawn  # noqa: E402
from source_mutants import Mutant, mutants_of  # noqa: E402
from transitions import Misled, all_misled  # noqa: E402

from conformance.faults.catalogue import find_deviation  # noqa: E402
from conformance.reference import node, segmented_server, server  # noqa: E402

JUDGED = HERE / "judged.toml"
SEED = 38
GUARDED, MUTANTS, TRANSITIONS = "guarded", "mutants", "transitions"
KINDS = (GUARDED, MUTANTS, TRANSITIONS)
# The suite itself builds nodes, to know the objects of the built-in device.
SET_UP = ("__init__", "further_record", "present")
Z_95 = 1.96
# What a server may raise beside the cases, in the process of the suite.
DEATHS = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)
# Seconds of a processor, for a run that takes a quarter of them: some servers keep it for ever.
LONGEST_QUICK, LONGEST = 12.0, 60.0


@dataclass(frozen=True, slots=True)
class Outcome:
    """By which run a server is caught, and by which case first."""

    kind: str
    name: str
    quick: bool
    whole: bool
    case: str = ""


@cache
def changes() -> dict[str, Mutant | Misled]:
    """Return the mutants and the transitions by name."""
    found: list[Mutant | Misled] = [
        *mutants_of((server, segmented_server, node), SET_UP.__contains__),
        *all_misled(),
    ]
    return {change.name: change for change in found}


def kind_of(name: str) -> str:
    """Return the kind of a server."""
    if "@" in name:
        return GUARDED
    return MUTANTS if isinstance(changes()[name], Mutant) else TRANSITIONS


def servers(kind: str) -> list[str]:
    """Return the names of all servers of a kind, but for the equivalent ones."""
    names = drawn() if kind == GUARDED else [name for name in changes() if kind_of(name) == kind]
    return [name for name in names if name not in judged()["equivalent"]]


@cache
def judged() -> dict[str, dict[str, str]]:
    """Return why the ``equivalent`` servers cannot be told from a right one, and others live."""
    return tomllib.loads(JUDGED.read_text("utf-8"))


def measure(name: str) -> Outcome:
    """Run the cases against a server, up to the first failure."""
    kind = kind_of(name)
    for quick in (True, False):
        if case := caught_by(name, quick=quick):
            return Outcome(kind, name, quick, True, case)
    return Outcome(kind, name, quick=False, whole=False)


def caught_by(name: str, *, quick: bool) -> str:
    """Return the first case that fails a server, or how a run ends that no case fails."""
    fault = find_deviation(name) if kind_of(name) == GUARDED else None
    change: AbstractContextManager[None] = nullcontext() if fault else changes()[name].installed()
    arguments = ["-x", *(["--sdo-quick"] if quick else [])]
    if fault is not None and fault.soft:
        arguments.append("--strict")
    try:
        with change, limited(LONGEST_QUICK if quick else LONGEST):
            run = run_cases(name if fault else None, *arguments)
    except DEATHS as died:
        return f"the server died: {died!r}"
    failed = run.failed(strict=fault is not None and fault.soft)
    return failed[0] if failed else (f"exit status {run.exit_code}" if run.exit_code else "")


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Interrupt a run that takes too much time of a processor."""
    before = signal.signal(signal.SIGVTALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def wilson(caught: int, of: int) -> tuple[float, float]:
    """Return the 95 % interval of a share.

    >>> "{:.3f} {:.3f}".format(*wilson(9, 10))
    '0.596 0.982'
    """
    share, square = caught / of, Z_95**2
    middle = (share + square / (2 * of)) / (1 + square / of)
    spread = math.sqrt(share * (1 - share) / of + square / (4 * of * of)) * Z_95
    return middle - spread / (1 + square / of), middle + spread / (1 + square / of)


def scores(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yield a line for each kind."""
    by_kind = defaultdict(list)
    for outcome in outcomes:
        by_kind[outcome.kind].append(outcome)
    for kind, found in by_kind.items():
        for title, caught in (
            ("quick", sum(outcome.quick for outcome in found)),
            ("whole", sum(outcome.whole for outcome in found)),
        ):
            low, high = wilson(caught, len(found))
            share = f"{caught} of {len(found)}: {caught / len(found):.1%}"
            yield f"{kind:12} {title:6} {share:24} 95 %: {low:.1%} to {high:.1%}"


def main() -> int:
    """Measure, and print; returns 1 where anything lives that was not judged."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--share", type=int, default=1, help="each N-th server of a kind")
    parser.add_argument("--only", choices=KINDS, action="append")
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_args()
    names = options.names
    for kind in () if names else options.only or KINDS:
        found = servers(kind)
        names = names + random.Random(SEED).sample(found, -(-len(found) // options.share))
    outcomes = []
    with ProcessPoolExecutor(options.workers) as pool:
        for outcome in pool.map(measure, names):
            outcomes.append(outcome)
            how = "quick" if outcome.quick else "whole" if outcome.whole else "LIVES"
            print(f"{how} | {outcome.kind} | {outcome.name} | {outcome.case}", flush=True)
    print(*scores(outcomes), sep="\n")
    return any(not each.whole and each.name not in judged()["lives"] for each in outcomes)


if __name__ == "__main__":
    sys.exit(main())
