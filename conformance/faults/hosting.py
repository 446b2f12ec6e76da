"""The built-in device on python-can's virtual bus: what the self-test talks to."""

import can

from conformance.bus.host import NodeHost
from conformance.faults.catalogue import build_node


def virtual_host(
    channel: str, node_id: int, server: str | None, *, server_timeout: float | None = None
) -> NodeHost:
    """Return a host for the reference server, or the fault or variant of that name.

    ``server_timeout`` is the time in seconds after which it gives up a silent client, None for
    never. Raises UnknownServer.
    """
    node = build_node(server, node_id, server_timeout=server_timeout)
    return NodeHost(can.Bus(interface="virtual", channel=channel), node)
