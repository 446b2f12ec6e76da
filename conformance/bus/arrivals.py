"""What python-can tells of when frames arrived, and how to look at those that have."""

import time
from collections.abc import Callable

import can
from can.interfaces.socketcan import SocketcanBus
from can.interfaces.udp_multicast import UdpMulticastBus
from can.interfaces.virtual import VirtualBus

# Where python-can filters in software it would, given no time, look at one frame only.
SHORTEST_LOOK = 0.001
# What these pass on is filtered already, or not at all: a look at what is there takes no time. A
# bus of another package that ``filters_nothing`` says so.
EXACT = (SocketcanBus, VirtualBus)
# What these say of when a frame arrived is by the clock of this machine.
STAMPED = (SocketcanBus, UdpMulticastBus, VirtualBus)
# A frame that has waited for longer than this many seconds was stamped by another clock.
LONGEST_WAIT = 60.0


def shortest_look(bus: can.BusABC) -> float:
    """Return the seconds that a look takes at least to find what has arrived."""
    exact = isinstance(bus, EXACT) or getattr(bus, "filters_nothing", False)
    return 0.0 if exact else SHORTEST_LOOK


def own_clock(bus: can.BusABC) -> Callable[[], float] | None:
    """Return the clock of a bus that has its own, as a simulated one has; None if it has none."""
    clock: Callable[[], float] | None = getattr(bus, "now", None)
    return clock


def arrivals(bus: can.BusABC) -> Callable[[can.Message], float]:
    """Return what says when a frame that was just taken arrived, in seconds, by the bus's clock.

    Where the bus has none, that is the monotonic one; where it does not tell, the frame arrived
    when it was taken.
    """
    own = own_clock(bus)
    if own is not None:
        return lambda message: own()
    return _stamped if isinstance(bus, STAMPED) else _taken


def _stamped(message: can.Message) -> float:
    now = time.monotonic()
    waited = time.time() - message.timestamp
    return now - waited if 0 < waited < LONGEST_WAIT else now


def _taken(message: can.Message) -> float:
    del message
    return time.monotonic()
