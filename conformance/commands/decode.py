"""``conformance decode``: a bus log, or a bus, in words."""

import argparse
import sys
from contextlib import ExitStack

from conformance.bus.opening import BusSettings, open_bus
from conformance.commands.notes import tell
from conformance.commands.options import NODE_ID, add_bus_options, add_option, bus_settings
from conformance.commands.status import DONE, NOT_ALLOWED
from conformance.device.eds_listing import Listing
from conformance.device.options import EDS
from conformance.eds.reading import read_eds
from conformance.logs.decoded_lines import Judgement, decoded, judged
from conformance.logs.live import LiveLog
from conformance.logs.object_names import ObjectNames
from conformance.logs.reading import RecordedLog

HELP = "show a bus log, or a bus, in words"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "log",
        nargs="?",
        help="a file of 'candump -L' or the bus.log of a run, also packed with gzip; - for the "
        "standard input; as candump shows it; .asc, .blf, .csv, .trc and what python-can reads",
    )
    add_option(parser, NODE_ID, help="show this node only")
    parser.add_argument(
        "--judge",
        action="store_true",
        help="show the responses that were not allowed, and their rules; exit status 3 if any",
    )
    add_option(parser, EDS, help="show the names of objects from an EDS or DCF")
    add_bus_options(parser, "instead of a log", "instead of a log; nothing is sent there")


def run(options: argparse.Namespace) -> int:
    """Print each frame in words, or only the breaches."""
    is_live = bool(options.can_interface or options.can_channel)
    if is_live == bool(options.log):
        raise ValueError("decode takes either a log, or a bus that --can-channel names")
    listing = read_eds(options.eds, options.node_id or 1) if options.eds else Listing()
    names = ObjectNames(listing)
    with ExitStack() as stack:
        log = stack.enter_context(_live(options)) if is_live else RecordedLog(options.log)
        judgement = Judgement(log.unit, options.node_id)
        for line in judged(log, judgement) if options.judge else decoded(log, options.node_id):
            print(names.in_line(line), flush=is_live)
    if isinstance(log, RecordedLog):
        tell(log.notes)
    return NOT_ALLOWED if judgement.failures else DONE


def _live(options: argparse.Namespace) -> LiveLog:
    settings = bus_settings(options, BusSettings())
    log = LiveLog(open_bus(settings), settings.channel or str(settings))
    print(f"listening on {settings} until Ctrl-C", file=sys.stderr, flush=True)
    return log
