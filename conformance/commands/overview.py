"""``conformance overview``: the runs of a lab as a table."""

import argparse
from pathlib import Path

from conformance.commands.notes import tell
from conformance.commands.status import DONE
from conformance.reporting.overview.page import write_overview
from conformance.reporting.overview.runs import read_overview
from conformance.reporting.overview.text import overview_lines
from conformance.sdo.printable_text import inert

HELP = "show which device was tested when, and how it ended, of a folder of many runs"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("folder", type=Path, help="the folder with the report folders, as reports/")
    parser.add_argument("--page", type=Path, metavar="FILE", help="write it as a page as well")


def run(options: argparse.Namespace) -> int:
    """Print a table, and write it as a page with ``--page``."""
    overview = read_overview(options.folder)
    if options.page:  # before a reader such as ``head`` closes the pipe
        write_overview(options.page, overview)
    for line in overview_lines(overview):
        print(inert(line))
    tell(overview.notes)
    if options.page:
        print(f"written: {options.page}")
    return DONE
