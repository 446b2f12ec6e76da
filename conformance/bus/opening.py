"""Opening the bus: the options, else python-can's own configuration, else SocketCAN on can0."""

import socket
from configparser import Error as ConfigError
from dataclasses import dataclass
from typing import Any

import can
from can.util import load_config, load_environment_config, load_file_config

from conformance.bus.connection import Connection
from conformance.bus.drivers import WITHOUT_SOCKETCAN, unknown_interface, what_it_needs
from conformance.bus.errors import BusNotOpened, InterfaceLost, advice

DEFAULT_INTERFACE = "socketcan"
DEFAULT_CHANNEL = "can0"
# Nothing outside of the process is on these.
PRIVATE = ("simulated", "virtual")

# As often a bus with traffic is opened: most openings fall between two frames.
SOCKETCAND_OPENINGS = 20
FRAME_OF_SOCKETCAND = "< frame "


@dataclass(frozen=True, slots=True)
class BusSettings:
    """Which bus: what is None comes from python-can's files or environment variables.

    ``bitrate`` is in bits per second; with SocketCAN the interface has its own. ``options`` are
    names and values of whatever else the interface takes; python-can knows their types.
    """

    interface: str | None = None
    channel: str | None = None
    bitrate: int | None = None
    options: tuple[tuple[str, str], ...] = ()

    def resolve(self) -> "BusSettings":
        """Fill in what python-can's own configuration says, then the defaults."""
        given = {
            key: value
            for key, value in (
                ("interface", self.interface),
                ("channel", self.channel),
                ("bitrate", self.bitrate),
                *self.options,
            )
            if value is not None
        }
        try:
            found: dict[str, Any] = load_file_config() | load_environment_config() | can.rc | given
            if not found.get("interface") and not found.get("bustype"):
                found["interface"] = DEFAULT_INTERFACE
            found = dict(load_config(config=found))
            bitrate = None if found.get("bitrate") is None else int(found["bitrate"])
        except can.CanInterfaceNotImplementedError as error:
            raise BusNotOpened(unknown_interface(str(found["interface"]))) from error
        except (can.CanInitializationError, ConfigError, ValueError) as error:
            raise BusNotOpened(f"python-can's configuration cannot be read: {error}") from error
        channel = found.get("channel")
        if channel is None and found["interface"] == DEFAULT_INTERFACE:
            channel = DEFAULT_CHANNEL
        channel = None if channel is None else str(channel)
        return BusSettings(found["interface"], channel, bitrate, self.options)

    @property
    def arguments(self) -> list[str]:
        """The options that name this bus; none for that of a self-test, which ends with it."""
        if self.interface in PRIVATE:
            return []
        named = [f"--can-interface={self.interface}"] if self.interface else []
        named += [f"--can-channel={self.channel}"] if self.channel else []
        named += [f"--can-bitrate={self.bitrate}"] if self.bitrate else []
        return named + [f"--can-option={name}={value}" for name, value in self.options]

    def __str__(self) -> str:
        rate = f", {self.bitrate} bit/s" if self.bitrate else ""
        options = "".join(f", {name}={value}" for name, value in self.options)
        name = f"{self.interface or DEFAULT_INTERFACE} {self.channel or ''}".rstrip()
        return name + rate + options


def connection_of(settings: BusSettings) -> Connection | None:
    """Return what a bus is reached over, where that is known and can be looked at."""
    options = dict(settings.options)
    host, port = options.get("host"), options.get("port", "")
    if settings.interface != "socketcand" or not host or not port.isdigit():
        return None
    return Connection(host, int(port))


def open_bus(settings: BusSettings) -> can.BusABC:
    """Open a bus that was resolved; raises BusNotOpened with what to do."""
    if settings.interface == "socketcan" and not hasattr(socket, "AF_CAN"):
        raise BusNotOpened(f"{settings} cannot be opened: {WITHOUT_SOCKETCAN}")
    connection = connection_of(settings)
    if connection is not None:
        try:
            connection.check()  # python-can would wait for its greeting for ever
        except InterfaceLost as error:
            raise BusNotOpened(f"{settings} cannot be opened: {error}") from error
    arguments: dict[str, Any] = {"interface": settings.interface, **dict(settings.options)}
    if settings.channel is not None:
        arguments["channel"] = settings.channel
    if settings.bitrate is not None and settings.interface not in ("socketcan", "virtual"):
        arguments["bitrate"] = settings.bitrate
    if settings.interface == "socketcan":
        # Echoes could not be told from frames that other processes send.
        arguments["receive_own_messages"] = False
    needed = what_it_needs(settings.interface or DEFAULT_INTERFACE)
    try:
        return _bus(arguments)
    except can.CanInterfaceNotImplementedError as error:
        raise BusNotOpened(
            f"The interface {settings.interface!r} cannot be used: {_sentence(error)}{needed}"
        ) from error
    except TypeError as error:
        raise BusNotOpened(
            f"{settings} cannot be opened: {error}. Name what is missing: the channel with "
            "--can-channel=NAME, other settings with --can-option=NAME=VALUE."
        ) from error
    except (can.CanError, OSError) as error:
        raise BusNotOpened(
            f"{settings} cannot be opened: {_sentence(error)} {advice(error)}{needed}"
        ) from error
    # A driver is code of others, and raises what it comes to: kvaser a NameError without its
    # library, others AttributeError, KeyError or struct.error. No list of them would be whole.
    except Exception as error:
        raise BusNotOpened(
            f"{settings} cannot be opened: {type(error).__name__}: {_sentence(error)} "
            f"{advice(error)}{needed}"
        ) from error


def _bus(arguments: dict[str, Any]) -> can.BusABC:
    """Open a bus; again where a frame of the bus came with the answer of a socketcand daemon.

    python-can takes whatever one reading of the connection brings for the daemon's answer, so a
    frame close behind it ends the opening, although nothing is wrong with the bus.
    """
    for _ in range(SOCKETCAND_OPENINGS - 1):
        try:
            return can.Bus(**arguments)
        except can.CanError as error:
            if arguments["interface"] != "socketcand" or FRAME_OF_SOCKETCAND not in str(error):
                raise
    return can.Bus(**arguments)


def _sentence(error: Exception) -> str:
    return f"{str(error).rstrip('. ')}."
