"""``conformance serve``: the reference server on a bus, until it is stopped."""

import argparse
import signal
from types import FrameType

from conformance.bus.opening import BusSettings, open_bus
from conformance.commands.options import NODE_ID, add_bus_options, add_option, bus_settings
from conformance.commands.status import DONE
from conformance.device.options import ANSWER_DELAY, EDS, FAULT, SERVER_TIMEOUT
from conformance.eds.reading import read_eds
from conformance.faults.catalogue import build_node
from conformance.reference.host import NodeHost

HELP = "run the reference server, or a faulty one, on a bus until Ctrl-C or SIGTERM"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_option(
        parser,
        NODE_ID,
        required=True,
        help="node-ID of the server, 1 to 127: its SDO channel is 600h + N and 580h + N",
    )
    add_bus_options(parser)
    add_option(
        parser,
        EDS,
        help="serve the objects of an EDS or DCF with their default values and limits, instead of "
        "those of the built-in device",
    )
    add_option(
        parser,
        FAULT,
        help="a server that deviates from the reference server: 'conformance faults' lists them; "
        "NAME+NAME deviates in both ways",
    )
    add_option(parser, ANSWER_DELAY, help="seconds between a request and its answer")
    add_option(
        parser,
        SERVER_TIMEOUT,
        help="seconds after which the server aborts the transfer of a silent client; a run takes "
        "the same as --sdo-server-timeout",
        without="never",
    )


def run(options: argparse.Namespace) -> int:
    """Serve until SIGTERM or SIGINT."""
    listing = read_eds(options.eds, options.node_id) if options.eds else None
    node = build_node(
        options.fault, options.node_id, listing, server_timeout=options.server_timeout
    )
    settings = bus_settings(options, BusSettings())
    host = NodeHost(open_bus(settings), node, options.answer_delay)

    def stop(number: int, frame: FrameType | None) -> None:
        del number, frame
        host.stop()

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, stop)
    print(f"serving node {options.node_id} on {settings}", flush=True)
    host.run()
    return DONE
