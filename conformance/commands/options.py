"""Options of the table that commands take, too: without ``sdo-`` in their names."""

import argparse
from dataclasses import replace
from typing import Any

from conformance.bus.opening import BusSettings
from conformance.device import option_kinds
from conformance.device import options as table
from conformance.device.options import Option

# Commands talk to one device.
NODE_ID = Option[int | None](table.NODE_ID.name, option_kinds.NODE_ID, None, "")


def add_option(
    parser: argparse.ArgumentParser,
    option: Option[Any],
    *,
    help: str = "",  # noqa: A002 - as argparse calls it
    without: str = "",
    required: bool = False,
) -> None:
    """Add an option of the table.

    The command may have its own ``help``; ``without`` is its value without the option.
    """
    own = replace(option, help=help or option.help)
    parser.add_argument(
        own.name.replace("--sdo-", "--"),
        required=required,
        default=[*own.default] if own.is_repeated else own.default,
        **own.argument(without),
    )


def add_bus_options(
    parser: argparse.ArgumentParser, interface: str = "", channel: str = ""
) -> None:
    """Add the options of the bus; the texts name the values without them."""
    add_option(parser, table.INTERFACE, without=interface)
    add_option(parser, table.CHANNEL, without=channel)
    add_option(parser, table.BIT_RATE)
    add_option(parser, table.CAN_OPTIONS)


def bus_settings(options: argparse.Namespace, default: BusSettings) -> BusSettings:
    """Return the bus that the options name, completed by the default one."""
    return BusSettings(
        options.can_interface or default.interface,
        options.can_channel or default.channel,
        options.can_bitrate or default.bitrate,
        tuple((dict(default.options) | dict(options.can_option)).items()),
    ).resolve()
