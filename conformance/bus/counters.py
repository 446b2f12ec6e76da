"""What a network interface counts of frames that were lost or disturbed (SocketCAN)."""

from collections.abc import Mapping
from pathlib import Path

from conformance.bus.opening import BusSettings

INTERFACES = Path("/sys/class/net")
# Frames that are gone: no room for them in the controller or in the kernel, or never sent.
LOSSES = (
    "rx_dropped",
    "rx_missed_errors",
    "rx_over_errors",
    "rx_fifo_errors",
    "tx_dropped",
    "tx_fifo_errors",
    "tx_aborted_errors",
)
# Errors on the bus: a CAN controller sends a frame again until it is received (ISO 11898-1).
REPEATED = (
    "rx_crc_errors",
    "rx_frame_errors",
    "rx_errors",
    "tx_carrier_errors",
    "tx_errors",
)


def read_counters(settings: BusSettings, interfaces: Path = INTERFACES) -> dict[str, int]:
    """Return what an interface has counted up to now; nothing where the platform does not tell."""
    if settings.interface != "socketcan" or not settings.channel:
        return {}
    folder = interfaces / settings.channel / "statistics"
    found = {}
    for name in (*LOSSES, *REPEATED):
        try:
            found[name] = int((folder / name).read_text(encoding="ascii"))
        except (OSError, ValueError):
            continue  # not every driver has each of them, and the interface may be gone
    return found


def counted_since(before: Mapping[str, int], now: Mapping[str, int]) -> dict[str, int]:
    """Return the counters that have grown, and by how much."""
    return {
        name: count - before[name]
        for name, count in now.items()
        if name in before and count > before[name]
    }


def lost_frames(counted: Mapping[str, int]) -> int:
    """Return how many frames are gone, by counters that have grown.

    >>> lost_frames({"rx_dropped": 2, "rx_errors": 30})
    2
    """
    return sum(count for name, count in counted.items() if name in LOSSES)
