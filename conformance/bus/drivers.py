"""What python-can's interfaces need beside it, and what to install where that is missing."""

import re
from dataclasses import dataclass
from importlib.util import find_spec

import can

from conformance.sdo.nearest import did_you_mean


@dataclass(frozen=True, slots=True)
class Driver:
    """A Python ``package`` with its ``module`` and the suite's ``extra`` for it, and what else.

    Each may be empty.
    """

    package: str = ""
    module: str = ""
    extra: str = ""
    other: str = ""


_SERIAL = Driver("pyserial", "serial", "serial", "a serial port that this user may open")
DRIVERS = {
    "canalystii": Driver("canalystii", "canalystii", "canalystii", "access to the USB device"),
    "cantact": Driver("cantact", "cantact", "cantact", "access to the USB device"),
    "gs_usb": Driver("gs-usb", "gs_usb", "gs-usb", "access to the USB device"),
    "ixxat": Driver(other="the VCI driver of the adapter's maker, which is for Windows"),
    "kvaser": Driver(other="Kvaser's CANlib (on Linux the package linuxcan or kvlibsdk)"),
    "neovi": Driver("python-ics", "ics", "neovi", "the driver of Intrepid Control Systems"),
    "nican": Driver(other="the NI-CAN driver of National Instruments, which is for Windows"),
    "nixnet": Driver("nixnet", "nixnet", "nixnet", "the NI-XNET driver of National Instruments"),
    "pcan": Driver(other="the PCAN-Basic library of PEAK-System (on Linux libpcanbasic.so)"),
    "robotell": _SERIAL,
    "seeedstudio": _SERIAL,
    "serial": _SERIAL,
    "slcan": _SERIAL,
    "socketcand": Driver(
        other="a socketcand daemon that runs at that host and port, and serves that channel"
    ),
    "systec": Driver(other="the USB-CANmodul driver of SYS TEC, which is for Windows"),
    "udp_multicast": Driver(
        "msgpack", "msgpack", "udp", "a multicast address as its channel, such as 239.74.163.2"
    ),
    "usb2can": Driver(other="the CAL library of 8devices, which is for Windows"),
    "vector": Driver(other="the XL Driver Library of Vector, which is for Windows"),
}
# Interfaces that come with a package of their own, and names of which others are known.
_PLUGINS = {
    "candle": "python-can-candle",
    "canine": "python-can-canine",
    "remote": "python-can-remote",
    "sontheim": "python-can-sontheim",
    "zlgcan": "zlgcan",
}
_CALLED = {
    "canable": "'gs_usb' or, with its serial firmware, 'slcan'",
    "candlelight": "'gs_usb'",
    "peak": "'pcan'",
}
WITHOUT_SOCKETCAN = (
    "only Linux has SocketCAN. Name the interface of your adapter: --can-interface=pcan "
    "--can-channel=PCAN_USBBUS1, --can-interface=kvaser --can-channel=0, --can-interface=gs_usb "
    "--can-channel=0, or --can-interface=slcan --can-channel=COM3 (on macOS /dev/tty.usbmodem1), "
    "each with --can-bitrate=500k or that of your bus."
)
_CHANNEL = re.compile(r"(v|sl)?can\d+")


def what_it_needs(interface: str) -> str:
    """Say what an interface needs and how to get what is missing, with a blank before it.

    Empty where that is not known.
    """
    driver = DRIVERS.get(interface)
    if driver is None:
        return ""
    if driver.package and find_spec(driver.module) is None:
        return (
            f" Install its Python package: 'python -m pip install {driver.package}' (or this suite "
            f"with the extra {driver.extra!r}). Besides it needs {driver.other}."
        )
    return f" It needs {driver.other}."


def unknown_interface(name: str) -> str:
    """Say that python-can has no interface of that name, and what may have been meant."""
    said = f"python-can has no interface called {name!r}."
    lower = name.lower()
    if lower in _PLUGINS:
        return f"{said} It comes with a package: 'python -m pip install {_PLUGINS[lower]}'."
    if lower in _CALLED:
        return f"{said} Write {_CALLED[lower]}."
    if _CHANNEL.fullmatch(lower):
        return f"{said} That is a channel of socketcan: write --can-channel={name}."
    return f"{said} {did_you_mean(name, sorted(can.VALID_INTERFACES))}"
