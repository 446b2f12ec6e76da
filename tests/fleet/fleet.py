"""Builds the foreign servers, runs the suite against each, and compares what it finds.

    python tests/fleet/fleet.py [--folder DIR] [--vcan NAME] [SERVER ...] [-- PYTEST-OPTION ...]

Where a server cannot be built, for want of cargo or npm say, that is told and the others go on.
They run over a stand-in for SocketCAN that needs no kernel, or with ``--vcan`` over a real
interface. The exit status is 1 when the suite finds what ``server.toml`` does not list, does not
find what it lists, or keeps more than 5 % of the cases from what they are about.
"""

import argparse
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path

from fleet_results import Comparison, Row, outcomes
from fleet_run import ROOT, Bus, run_suite, socketcan, stand_in
from fleet_servers import ForeignServer, Unavailable, foreign_servers

ENOUGH = 0.95


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the fleet; return the exit status."""
    known = {server.name: server for server in foreign_servers()}
    parser = argparse.ArgumentParser(description="Run the suite against servers that others wrote.")
    parser.add_argument("servers", nargs="*", metavar="SERVER", help=f"{', '.join(known)} (all)")
    parser.add_argument("--folder", type=Path, default=ROOT / ".fleet", help="for what is built")
    parser.add_argument("--vcan", metavar="NAME", help="a CAN interface of the kernel")
    own, options = _split(sys.argv[1:] if arguments is None else arguments)
    chosen = parser.parse_args(own)
    if unknown := set(chosen.servers) - set(known):
        parser.error(f"no such server: {', '.join(sorted(unknown))}")
    folder = chosen.folder.absolute()
    rows, complaints = [], []
    for name in chosen.servers or known:
        server = known[name]
        bus = socketcan(chosen.vcan) if chosen.vcan else stand_in(folder / "vcan")
        try:
            row, comparison = run(server, folder / name, bus, options)
        except Unavailable as reason:
            print(f"{server.title}: {reason}; left out", flush=True)
            continue
        print(Row.HEADER, row, *comparison.lines(), sep="\n", flush=True)
        rows.append(row)
        if not comparison.right:
            complaints.append(f"{name}: other causes than judged right")
        if row.share < ENOUGH:
            complaints.append(f"{name}: {row.share:.0%} of the cases reach their point")
    print("", Row.HEADER, *rows, "", *complaints, sep="\n")
    return 1 if complaints or not rows else 0


def _split(given: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return what stands before -- and what stands behind it."""
    words = list(given)
    place = words.index("--") if "--" in words else len(words)
    return words[:place], words[place + 1 :]


def run(
    server: ForeignServer,
    folder: Path,
    opened: AbstractContextManager[Bus],
    options: Sequence[str],
) -> tuple[Row, Comparison]:
    """Build a server, run the suite against it and judge what was found."""
    print(f"{server.title}: in {folder}", flush=True)
    server.prepare(folder)
    with opened as bus:
        done = run_suite(server, folder, bus, options)
    if not done.junit.exists():
        raise Unavailable(f"the run ended with {done.status}: {done.folder / 'output.txt'}")
    results = list(outcomes(done.junit))
    return Row.of(server.name, results, done.seconds, server.causes), Comparison.of(
        results, server.causes
    )


if __name__ == "__main__":
    sys.exit(main())
