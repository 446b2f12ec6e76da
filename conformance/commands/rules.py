"""``conformance rules``: the requirements for a server, with their cases."""

import argparse

from conformance.commands.status import DONE
from conformance.reporting.rule_listing import rule_lines

HELP = "list the requirements for a server, with their cases"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "names",
        nargs="*",
        metavar="RULE",
        help="only these, by id or by step of the official test",
    )


def run(options: argparse.Namespace) -> int:
    """Print the rules; raises UnknownRule."""
    for line in rule_lines(options.names):
        print(line)
    return DONE
