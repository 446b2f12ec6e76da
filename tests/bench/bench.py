"""What transfers and runs cost, beside the least that they can cost, in one table: ``make bench``.

    python tests/bench/bench.py [--size BYTES] [--expedited COUNT] [--rounds COUNT] [PART ...]

All of it is a matter of ten minutes, on two processors however many there are. ``!`` stands where
something is more than it may be. ``cpu s`` is what all threads and processes computed: on a machine
that others use, compare that.
"""

import argparse
import os
from collections.abc import Iterator

from bench_rows import HEADING, Row
from bench_runs import collection, delayed, self_tests
from bench_transfers import transfer_rows

PROCESSORS = 2
PARTS = ("transfers", "collection", "self-test", "devices")


def main() -> None:
    """Print a row for each thing that is measured."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--size", type=int, default=10_000, help="bytes of a segmented transfer")
    parser.add_argument("--expedited", type=int, default=1500, help="number of short transfers")
    parser.add_argument("--rounds", type=int, default=30, help="how often a transfer is measured")
    parser.add_argument("--transfer", default="", help="such as 'block' or 'upload'")
    parser.add_argument("--cases", default="not random", help="as -k of pytest")
    parser.add_argument("--devices", type=int, default=16, help="how many at once")
    parser.add_argument("part", nargs="*", help=f"{', '.join(PARTS)}; all if left out")
    options = parser.parse_args()
    for part in options.part:
        if part not in PARTS:
            parser.error(f"there is no part {part!r}: {', '.join(PARTS)}")
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:PROCESSORS])
    print(HEADING)
    for part in options.part or PARTS:
        for row in _rows(part, options):
            print(row, flush=True)


def _rows(part: str, options: argparse.Namespace) -> Iterator[Row | str]:
    match part:
        case "transfers":
            return transfer_rows(options.transfer, options.size, options.expedited, options.rounds)
        case "collection":
            return collection()
        case "self-test":
            return self_tests(options.cases)
        case _:
            return delayed(options.cases, options.devices)


if __name__ == "__main__":
    main()
