"""``conformance faults``: the servers against which the suite itself is tested."""

import argparse

from conformance.commands.status import DONE
from conformance.faults.catalogue import faults, unusual

HELP = "list the faulty and the unusual servers"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add nothing: the command has no options."""
    del parser


def run(options: argparse.Namespace) -> int:
    """Print each server with a sentence."""
    del options
    for title, deviations in (("faulty", faults()), ("unusual, but right", unusual())):
        print(f"{title}:")
        for deviation in deviations:
            marks = f" [{deviation.defect}]" if deviation.defect else ""
            soft = " (SHOULD)" if deviation.soft else ""
            print(f"  {deviation.name}{marks}{soft}\n      {deviation.sentence}")
    return DONE
