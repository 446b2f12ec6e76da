"""``conformance compare``: the changes between two runs."""

import argparse
from pathlib import Path

from conformance.commands.status import DONE, NOT_ALLOWED
from conformance.reporting.comparison.comparison import Comparison
from conformance.reporting.comparison.page import write_comparison
from conformance.reporting.comparison.sides import Side
from conformance.reporting.comparison.text import comparison_lines
from conformance.sdo.printable_text import inert

HELP = "show what has changed between two runs; exit status 3 if it got worse"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("old", type=Path, help="the report folder of a run")
    parser.add_argument("new", type=Path, help="that of a later run")
    parser.add_argument("--page", type=Path, metavar="FILE", help="write it as a page as well")


def run(options: argparse.Namespace) -> int:
    """Print the differences, and write them as a page with ``--page``."""
    comparison = Comparison(Side.read(options.old), Side.read(options.new))
    for line in comparison_lines(comparison):
        print(inert(line))
    if options.page:
        write_comparison(options.page, comparison)
        print(f"written: {options.page}")
    return NOT_ALLOWED if comparison.worse else DONE
