"""What a network interface counts of the frames that it has lost (SocketCAN)."""

from collections.abc import Mapping
from pathlib import Path

from conformance.bus.opening import BusSettings

INTERFACES = Path("/sys/class/net")
LOSSES = (
    "rx_dropped",
    "rx_missed_errors",
    "rx_over_errors",
    "rx_fifo_errors",
    "rx_crc_errors",
    "rx_frame_errors",
    "rx_errors",
    "tx_dropped",
    "tx_fifo_errors",
    "tx_aborted_errors",
    "tx_carrier_errors",
    "tx_errors",
)


def read_counters(settings: BusSettings, interfaces: Path = INTERFACES) -> dict[str, int]:
    """Return what an interface has counted up to now; nothing where the platform does not tell."""
    if settings.interface != "socketcan" or not settings.channel:
        return {}
    folder = interfaces / settings.channel / "statistics"
    found = {}
    for name in LOSSES:
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
