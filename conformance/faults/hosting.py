"""The built-in device on python-can's virtual bus: what the self-test talks to."""

import can

from conformance.bus.host import NodeHost
from conformance.faults.catalogue import build_node


def virtual_host(channel: str, node_id: int, server: str | None, delay: float = 0.0) -> NodeHost:
    """Return a host for the reference server, or the fault or variant of that name.

    ``delay`` is the time in seconds that it takes for an answer.

    Raises UnknownServer.
    """
    node = build_node(server, node_id)
    return NodeHost(can.Bus(interface="virtual", channel=channel), node, delay)
