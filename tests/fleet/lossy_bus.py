"""A bus that loses frames: two virtual channels, and a relay that chooses what passes between them.

What is lost is decided frame by frame, from what went before: a run loses the same as the next.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from threading import Lock

import can

from conformance.sdo.cob_id import REQUEST_BASE
from conformance.sdo.frames import Request, Response
from conformance.sdo.line import Line

RELAY_POLL = 0.05
Loses = Callable[[Request | Response], bool]


@dataclass
class Relay:
    """Hands SDO frames on in both directions unless ``loses`` says otherwise; counts the lost."""

    node_id: int
    loses: Loses = lambda message: False
    lost: list[Request | Response] = field(default_factory=list)
    line: Line = field(default_factory=Line)
    lock: Lock = field(default_factory=Lock)

    def hand_on(self, other: can.BusABC, message: can.Message) -> None:
        """Send to the other bus what came from one."""
        with self.lock:
            requested = message.arbitration_id == REQUEST_BASE + self.node_id
            follow = self.line.request if requested else self.line.response
            decoded = follow(bytes(message.data))
            if self.loses(decoded):
                self.lost.append(decoded)
                return
            other.send(message)


@contextmanager
def relayed(client_channel: str, server_channel: str, node_id: int) -> Iterator[Relay]:
    """Join two channels of the virtual bus for the SDO of one node."""
    relay = Relay(node_id)
    with ExitStack() as stack:
        ends = []
        for channel in (client_channel, server_channel):
            ends.append(can.Bus(interface="virtual", channel=channel))
            stack.callback(ends[-1].shutdown)
        for here, there in (ends, reversed(ends)):
            notifier = can.Notifier(here, [], timeout=RELAY_POLL)
            notifier.add_listener(partial(relay.hand_on, there))
            stack.callback(notifier.stop)
        yield relay
