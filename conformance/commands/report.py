"""``conformance report``: the reports of a run, made of its record once more."""

import argparse
from pathlib import Path

from conformance.commands.status import DONE
from conformance.reporting.archive import write_archive
from conformance.reporting.recorded import read_run
from conformance.reporting.report import write_reports
from conformance.reporting.summary import verdict_counts
from conformance.sdo.printable_text import inert

HELP = "write the reports of a run again, even if it was killed"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("folder", type=Path, help="the report folder, which contains results.jsonl")
    parser.add_argument(
        "--zip", action="store_true", help="pack the folder into a file beside it, with checksums"
    )


def run(options: argparse.Namespace) -> int:
    """Write the reports, and print the summary of the run."""
    recorded = read_run(options.folder)
    paths = write_reports(options.folder, recorded)
    for line in (*verdict_counts(recorded.results), *recorded.troubles):
        print(inert(line))
    if options.zip:
        paths.append(write_archive(options.folder))
    for path in paths:
        print(f"written: {path}")
    return DONE
