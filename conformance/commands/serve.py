"""``conformance serve``: the reference server on a bus, until it is stopped."""

import argparse
import math
import signal
from pathlib import Path
from types import FrameType

from conformance.bus.opening import BusSettings, open_bus
from conformance.commands.bus_options import add_bus_options, bus_settings
from conformance.commands.status import DONE
from conformance.eds.reading import read_eds
from conformance.faults.catalogue import build_node
from conformance.reference.host import NodeHost
from conformance.sdo.cob_id import HIGHEST_NODE_ID

HELP = "run the reference server, or a faulty one, on a bus until Ctrl-C or SIGTERM"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "--node-id",
        type=int,
        required=True,
        metavar="N",
        help="node-ID of the server, 1 to 127: its SDO channel is 600h + N and 580h + N",
    )
    add_bus_options(parser, "socketcan", "can0")
    parser.add_argument(
        "--eds",
        metavar="FILE",
        help="serve the objects of an EDS or DCF with their default values and limits, instead of "
        "those of the built-in device",
    )
    parser.add_argument(
        "--fault",
        metavar="NAME",
        help="a server that deviates from the reference server: 'conformance faults' lists them; "
        "NAME+NAME deviates in both ways",
    )
    parser.add_argument(
        "--answer-delay",
        metavar="SECONDS",
        type=float,
        default=0.0,
        help="seconds between a request and its answer (0)",
    )
    parser.add_argument(
        "--server-timeout",
        type=float,
        metavar="SECONDS",
        help="seconds after which the server aborts the transfer of a silent client (never); a "
        "run takes the same as --sdo-server-timeout",
    )


def run(options: argparse.Namespace) -> int:
    """Serve until SIGTERM or SIGINT."""
    if not 1 <= options.node_id <= HIGHEST_NODE_ID:
        raise ValueError(f"node-IDs go from 1 to {HIGHEST_NODE_ID}, not {options.node_id}")
    if options.server_timeout is not None and not 0 < options.server_timeout < math.inf:
        raise ValueError(f"--server-timeout takes seconds, as in 0.5, not {options.server_timeout}")
    listing = read_eds(Path(options.eds), options.node_id) if options.eds else None
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
