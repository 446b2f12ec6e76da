"""``conformance replay``: the requests of a log once more, and the answers judged anew."""

import argparse

from conformance.bus.link import Link
from conformance.bus.opening import BusSettings, open_bus
from conformance.commands.notes import tell
from conformance.commands.options import NODE_ID, add_bus_options, add_option, bus_settings
from conformance.commands.status import BROKEN_BENCH, DONE, NOT_ALLOWED
from conformance.device.options import RESPONSE_TIMEOUT
from conformance.logs.reading import RecordedLog
from conformance.logs.replay_plan import read_plan
from conformance.logs.replayed_lines import Replayed
from conformance.logs.replaying import Replay

HELP = "send the requests of a log to a device again, and judge the answers"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "log", help="a log as decode reads it, such as one in the folder reproduce of a run"
    )
    add_bus_options(parser)
    add_option(parser, NODE_ID, help="only the requests to this node")
    parser.add_argument(
        "--writes",
        action="store_true",
        help="send downloads and NMT commands too, which change the device",
    )
    add_option(parser, RESPONSE_TIMEOUT)


def run(options: argparse.Namespace) -> int:
    """Send the requests, and print the answers."""
    log = RecordedLog(options.log)
    plan = read_plan(log, options.node_id)
    plan.check(writes=options.writes)
    tell([*log.notes, *plan.notes])
    settings = bus_settings(options, BusSettings())
    link = Link(open_bus(settings), str(settings))
    with Replay(link, settings.channel or "bus", plan, options.response_timeout) as replay:
        replayed = Replayed(replay)
        for line in replayed.lines():
            print(line)
    if replayed.failures:
        return NOT_ALLOWED
    return BROKEN_BENCH if replay.stopped else DONE
