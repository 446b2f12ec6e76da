"""The built-in device on a bus: what the self-test talks to."""

from collections.abc import Iterable

import can

from conformance.faults.catalogue import build_node
from conformance.reference.host import NodeHost
from conformance.reference.simulated_bus import RealClock, SimulatedBus


def virtual_host(
    channel: str,
    node_id: int,
    server: str | None,
    delay: float = 0.0,
    *,
    server_timeout: float | None = None,
) -> NodeHost:
    """Return a host for the reference server, or the faulty or unusual one of that name.

    ``delay`` is the time in seconds that it takes for an answer, ``server_timeout`` that after
    which it gives up a silent client, None for never. Raises UnknownServer.
    """
    node = build_node(server, node_id, server_timeout=server_timeout)
    return NodeHost(can.Bus(interface="virtual", channel=channel), node, delay)


def simulated_bus(
    node_ids: Iterable[int],
    server: str | None,
    delay: float = 0.0,
    *,
    server_timeout: float | None = None,
) -> SimulatedBus:
    """Return a bus with such servers on it, which answer within the call that sends.

    With a ``delay`` in seconds an answer arrives that much later; time passes as it does then.
    Raises UnknownServer.
    """
    nodes = (build_node(server, node_id, server_timeout=server_timeout) for node_id in node_ids)
    return SimulatedBus(nodes, delay, RealClock() if delay else None)
