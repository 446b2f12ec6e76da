"""The command line that the foreign devices share: serve until SIGTERM or SIGINT."""

import argparse
import signal
from collections.abc import Callable
from contextlib import AbstractContextManager

import can

from conformance.bus.errors import BusNotOpened
from conformance.bus.opening import BusSettings, open_bus

STOPPING = (signal.SIGINT, signal.SIGTERM)


def serve(
    description: str, device: Callable[[can.BusABC, int], AbstractContextManager[object]]
) -> None:
    """Run a device on the bus that the command line names; say so in one line when it is ready."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--node-id", type=int, default=5, metavar="N", help="(%(default)s)")
    parser.add_argument("--can-interface", metavar="NAME", help="python-can interface (socketcan)")
    parser.add_argument("--can-channel", metavar="NAME", help="channel of the interface (can0)")
    arguments = parser.parse_args()
    # Blocked before a thread starts, so that no thread but this one is told to stop.
    signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
    try:
        settings = BusSettings(arguments.can_interface, arguments.can_channel).resolve()
        bus = open_bus(settings)
    except BusNotOpened as error:
        parser.error(str(error))
    with device(bus, arguments.node_id):
        print(f"serving node {arguments.node_id} on {settings}", flush=True)
        signal.sigwait(STOPPING)
