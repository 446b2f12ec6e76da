"""Runs the cases against servers that are unusual in two ways at a time: each has to pass.

    python tests/faults/unusual_pairs.py [--quick] [--workers N] [--draw N] [--seed N] [PAIR ...]

Pairs are drawn at random with a fixed seed, from those that can be put together: each server still
does all that it is named for. Fails when a pair fails a case; with a server that misses a SHOULD
alone, only what breaks a MUST counts. PAIRs are two names with a + between them.

A pair meets all cases. With ``--quick`` few pairs are drawn, and each meets one in eight of the
scripts, the others in turn.
"""

import argparse
import os
import random
import sys
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import combinations, islice

from case_runs import Choice, Run, run_cases
from detection import HUGE, QUICK_SHARE, problem_with, scripts

from conformance.faults.catalogue import build_node, find_deviation, unusual
from conformance.faults.registry import Deviation, acts_beside
from conformance.sdo.objects import Refusal

DRAWN, DRAWN_QUICKLY = 20, 4
SEED = 1
NODE_ID = 5


def name_of(pair: Iterable[Deviation]) -> str:
    """Return the name of two servers in one."""
    return "+".join(each.name for each in pair)


def possible_pairs() -> list[str]:
    """Return the pairs of unusual servers of which each acts beside the other.

    Not those that wait by the clock, which stands still on a simulated bus.
    """
    servers = [each for each in unusual() if not each.timed]
    return [name_of(pair) for pair in combinations(servers, 2) if acts_beside(*pair)]


def can_be_built(name: str) -> bool:
    """Say whether neither server lacks an object that the other one alters."""
    try:
        build_node(name, NODE_ID)
    except Refusal:
        return False
    return True


def drawn(count: int, seed: int) -> list[str]:
    """Draw some of the pairs."""
    names = possible_pairs()
    random.Random(seed).shuffle(names)
    return list(islice(filter(can_be_built, names), count))


def run_pair(name: str, turn: int, *, quick: bool) -> Run:
    """Run the cases against a pair."""
    if not quick:
        return run_cases(name)
    choice = Choice(share=QUICK_SHARE, turn=turn)
    return run_cases(name, *scripts(), "-k", f"not {HUGE}", plugins=[choice])


def problem_with_pair(run: Run) -> str:
    """Say what a right server failed; empty where nothing is."""
    deviation = find_deviation(run.name)
    assert deviation is not None
    if not run.verdicts:
        return f"NO CASES: exit code {run.exit_code}"
    return problem_with(deviation, run)


def run_all(names: Sequence[str], *, workers: int, quick: bool) -> Iterator[Run]:
    """Run the cases against several pairs at a time."""
    with ProcessPoolExecutor(workers) as pool:
        running = [
            pool.submit(run_pair, name, turn, quick=quick) for turn, name in enumerate(names)
        ]
        for run in running:
            yield run.result()


def main() -> int:
    """Print the table; returns 1 when a pair fails."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--quick", action="store_true", help="fewer cases and pairs, see above")
    parser.add_argument("--draw", type=int, help="how many pairs")
    parser.add_argument("--seed", type=int, default=SEED, help="of the draw (%(default)s)")
    parser.add_argument("names", nargs="*", metavar="PAIR")
    options = parser.parse_args()
    count = options.draw or (DRAWN_QUICKLY if options.quick else DRAWN)
    names = options.names or drawn(count, options.seed)
    problems = 0
    for run in run_all(names, workers=options.workers, quick=options.quick):
        problem = problem_with_pair(run)
        problems += bool(problem)
        print(f"{run.name:96} {run.seconds:6.1f} s  {problem or 'ok'}", flush=True)
        for case_id in run.failed() if problem else ():
            print(f"    {case_id}: {run.causes.get(case_id, '')}")
    print(f"{len(names) - problems} of {len(names)} pairs pass")
    return bool(problems)


if __name__ == "__main__":
    sys.exit(main())
