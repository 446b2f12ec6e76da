"""``conformance restore``: the values that a stopped run has left changed."""

import argparse
import sys
from pathlib import Path

from conformance.bus.channel import Channel
from conformance.bus.link import Link
from conformance.bus.opening import open_bus
from conformance.commands.options import add_bus_options, add_option, bus_settings
from conformance.commands.status import BROKEN_BENCH, DONE, NOT_THERE
from conformance.device.options import RESPONSE_TIMEOUT
from conformance.reporting.journal import bus_of, journals, put_back_left, read_journal
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.printable_text import inert

HELP = "restore the values that a run left changed, from its report folder"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "folder", type=Path, help="the report folder of the run, or the journal in it"
    )
    add_bus_options(parser, "that of the run", "that of the run")
    add_option(parser, RESPONSE_TIMEOUT)


def run(options: argparse.Namespace) -> int:
    """Write the values back, and say which could not be."""
    folder: Path = options.folder
    if not folder.exists():
        print(f"conformance: {inert(str(folder))} does not exist", file=sys.stderr)
        return NOT_THERE
    paths = [folder] if folder.is_file() else journals(folder)
    pending = 0
    for path in paths:
        about, left = read_journal(path)
        if about["self_test"]:
            print(f"{path}: nothing to restore after a self-test, whose server has ended")
            continue
        settings = bus_settings(options, bus_of(about))
        link = Link(open_bus(settings), str(settings))
        try:
            for each in left:
                ids = ChannelIds.parse(each.channel)
                channel = Channel(link, each.node_id, options.response_timeout, ids)
                for line in put_back_left(channel, each):
                    print(inert(line))
                pending += not each.is_all_back
        finally:
            link.close()
    if not paths:
        print(f"{folder} has no values to restore")
    return BROKEN_BENCH if pending else DONE
