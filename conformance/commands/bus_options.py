"""The options with which commands find the bus."""

import argparse

from conformance.bus.arguments import bit_rate, named_value
from conformance.bus.opening import BusSettings


def add_bus_options(parser: argparse.ArgumentParser, interface: str, channel: str) -> None:
    """Add the options; the texts say what is taken without them."""
    parser.add_argument(
        "--can-interface",
        metavar="NAME",
        help=f"interface as python-can calls it, such as pcan or udp_multicast ({interface})",
    )
    parser.add_argument(
        "--can-channel",
        metavar="NAME",
        help=f"channel of the interface, such as vcan0 or PCAN_USBBUS1 ({channel})",
    )
    parser.add_argument(
        "--can-bitrate",
        type=bit_rate,
        metavar="BIT/S",
        help="bit rate for interfaces that set it, such as 500k or 1M; SocketCAN's is set with "
        "'ip link'",
    )
    parser.add_argument(
        "--can-option",
        metavar="NAME=VALUE",
        type=named_value,
        action="append",
        default=[],
        help="a further setting of the interface, such as port=29536; may be repeated",
    )


def add_response_timeout(parser: argparse.ArgumentParser) -> None:
    """Add the option of commands that wait for responses."""
    parser.add_argument(
        "--response-timeout",
        metavar="SECONDS",
        type=float,
        default=1.0,
        help="time within which a response has to come (1.0)",
    )


def bus_settings(options: argparse.Namespace, default: BusSettings) -> BusSettings:
    """Return the bus that the options name, completed by the default one."""
    return BusSettings(
        options.can_interface or default.interface,
        options.can_channel or default.channel,
        options.can_bitrate or default.bitrate,
        tuple((dict(default.options) | dict(options.can_option)).items()),
    ).resolve()
