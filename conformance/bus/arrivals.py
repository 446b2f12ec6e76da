"""What python-can tells of when frames arrived, and how to look at those that have."""

import time

import can
from can.interfaces.socketcan import SocketcanBus
from can.interfaces.udp_multicast import UdpMulticastBus
from can.interfaces.virtual import VirtualBus

# Where python-can filters in software it would, given no time, look at one frame only.
SHORTEST_LOOK = 0.001
# What these pass on is filtered already, or not at all: a look at what is there takes no time.
EXACT = (SocketcanBus, VirtualBus)
# What these say of when a frame arrived is by the clock of this machine.
STAMPED = (SocketcanBus, UdpMulticastBus, VirtualBus)
# A frame that has waited for longer than this many seconds was stamped by another clock.
LONGEST_WAIT = 60.0


def shortest_look(bus: can.BusABC) -> float:
    """Return the seconds that a look takes at least to find what has arrived."""
    return 0.0 if isinstance(bus, EXACT) else SHORTEST_LOOK


def arrival(bus: can.BusABC, message: can.Message) -> float:
    """Return when a frame that was just taken arrived, in seconds of the monotonic clock.

    Where the bus does not tell, it is the time at which the frame was taken.
    """
    now = time.monotonic()
    if isinstance(bus, STAMPED):
        waited = time.time() - message.timestamp
        if 0 < waited < LONGEST_WAIT:
            return now - waited
    return now
