"""The suite's options: how they are declared to pytest and read into settings."""

import math
from argparse import ArgumentTypeError
from dataclasses import dataclass
from pathlib import Path

import pytest

from conformance.bus.errors import BusNotOpened
from conformance.bus.opening import BusSettings
from conformance.device.deny import PERMISSIONS, PermissionNameError, parse_permission
from conformance.device.description import Description, KnownDeviation, read_description
from conformance.device.eds import read_eds
from conformance.device.files import FileError
from conformance.device.listing import Listing
from conformance.device.objects import ObjectNameError, parse_object
from conformance.device.permits import NotPermitted, Permits
from conformance.faults.catalogue import UnknownServer, find_deviation, lacking
from conformance.faults.listing import reference_listing, reference_permits
from conformance.run.bench import (
    DEFAULT_RESPONSE_TIMEOUT,
    DEFAULT_SEED,
    RunSettings,
    private_channel,
)
from conformance.sdo.cob_id import HIGHEST_NODE_ID, ChannelError, ChannelIds

SELF_TEST_NODE = 5


@dataclass(frozen=True, slots=True)
class Options:
    """What the command line said."""

    run: RunSettings
    self_test: bool
    server: str | None
    report_dir: Path
    strict: bool
    simulated: bool
    deviations: tuple[KnownDeviation, ...] = ()


def add_options(parser: pytest.Parser) -> None:
    """Declare the options. ``--strict`` is pytest's own; the suite listens to it."""
    group = parser.getgroup("conformance", "CANopen SDO conformance")
    group.addoption(
        "--node-id",
        metavar="N",
        type=_node_ids,
        help="node-ID of the device under test, 1 to 127; a list like 1-4,9 for several",
    )
    group.addoption(
        "--device",
        metavar="FILE.toml",
        dest="device_description",
        help="the description of the device: node-ID, bus, EDS, what may be written and more; "
        "options override it",
    )
    group.addoption(
        "--eds",
        metavar="FILE",
        help="the EDS or DCF of the device: adds cases for every object that it lists",
    )
    group.addoption(
        "--scan",
        action="store_true",
        help="read all indices as well, 65535 of them, and tell what the EDS does not list",
    )
    group.addoption("--can-interface", metavar="NAME", help="python-can interface (socketcan)")
    group.addoption("--can-channel", metavar="NAME", help="channel of the interface (can0)")
    group.addoption(
        "--can-bitrate",
        metavar="BIT/S",
        type=int,
        help="bit rate for interfaces that set it; SocketCAN's is set with 'ip link'",
    )
    group.addoption(
        "--response-timeout",
        metavar="SECONDS",
        type=_seconds,
        help=f"time within which a response has to come ({DEFAULT_RESPONSE_TIMEOUT})",
    )
    group.addoption(
        "--server-timeout",
        metavar="SECONDS",
        type=_seconds,
        help="time after which the device itself gives up a transfer whose client is silent, if "
        "it does: is tested then (the built-in server gets one)",
    )
    group.addoption(
        "--object",
        metavar="INDEX[:SUB][=TYPE[,ACCESS]]",
        type=_object,
        action="append",
        default=[],
        dest="conformance_objects",
        help="an object that may be written (and is restored), as 2001 or 2010:01=unsigned16; "
        "with access wo or ro one that cannot be read or written; may be repeated",
    )
    group.addoption(
        "--sdo-channel",
        metavar="REQUEST:RESPONSE",
        type=_channel,
        help="test the device on another SDO channel than the default one: its CAN-IDs in "
        "hexadecimal, as in 640:5C0; more than 3 digits are 29-bit CAN-IDs",
    )
    group.addoption(
        "--allow",
        metavar="NAME",
        type=_permission,
        action="append",
        default=[],
        dest="conformance_permissions",
        help="permit what is not done otherwise: nmt (commands to the device, which is left "
        "Pre-operational, and 1017h), sdo-parameters (1200h to 12FFh, restored afterwards), or "
        "another of the names in the README; may be repeated",
    )
    group.addoption(
        "--self-test",
        action="store_true",
        help="test the built-in reference server on a virtual bus: no hardware, no device",
    )
    group.addoption(
        "--fault",
        metavar="NAME",
        help="with --self-test: a faulty or unusual server instead ('conformance faults' lists)",
    )
    group.addoption(
        "--simulated",
        action="store_true",
        help="with --self-test: the server answers within the call that sends; nothing ever waits",
    )
    group.addoption(
        "--report-dir",
        metavar="DIR",
        default="reports",
        help="where each run leaves a folder with its reports (%(default)s)",
    )
    group.addoption(
        "--seed",
        metavar="N",
        type=int,
        default=DEFAULT_SEED,
        help="decides on the bytes that cases write (%(default)s)",
    )


def read_options(config: pytest.Config) -> Options | None:
    """Return the options, or None when neither a device nor the self-test is asked for.

    Raises pytest.UsageError with a sentence.
    """
    self_test = bool(config.getoption("self_test"))
    server = config.getoption("fault")
    if server is not None and not self_test:
        raise pytest.UsageError(f"--fault={server} goes with --self-test.")
    simulated = bool(config.getoption("simulated"))
    if simulated and not self_test:
        raise pytest.UsageError("--simulated goes with --self-test: a real device takes its time.")
    description = _description(config, self_test=self_test)
    node_ids = _wanted_nodes(config, description)
    if not self_test and node_ids is None:
        return None
    if config.getoption("dist", default="no") != "no":
        raise pytest.UsageError(
            "Cases run one after another in one process: leave out -n (pytest-xdist). Several "
            "devices are tested in turn: --node-id=1-4."
        )
    node_ids = node_ids or [SELF_TEST_NODE]
    sdo_channel = config.getoption("sdo_channel")
    if sdo_channel is not None and (self_test or len(node_ids) > 1):
        raise pytest.UsageError("--sdo-channel goes with one device: --node-id=N.")
    try:
        find_deviation(server)
        run = RunSettings(
            node_ids,
            _bus(config, description, self_test=self_test, simulated=simulated),
            config.getoption("response_timeout")
            or description.response
            or DEFAULT_RESPONSE_TIMEOUT,
            config.getoption("seed"),
            config.getoption("server_timeout") or description.server_timeout,
            sdo_channel,
            _listings(config, description, node_ids, self_test=self_test),
            _permits(config, description, self_test=self_test),
            config.getoption("scan"),
        )
    except (UnknownServer, BusNotOpened, FileError, NotPermitted) as error:
        raise pytest.UsageError(str(error)) from error
    report_dir = config.invocation_params.dir / config.getoption("report_dir")
    return Options(
        run, self_test, server, report_dir, _strict(config), simulated, description.deviations
    )


def _description(config: pytest.Config, *, self_test: bool) -> Description:
    name = config.getoption("device_description")
    if name is None:
        return Description()
    if self_test:
        raise pytest.UsageError(f"--device={name} describes a device: leave out --self-test.")
    try:
        return read_description(config.invocation_params.dir / name)
    except FileError as error:
        raise pytest.UsageError(str(error)) from error


def _wanted_nodes(config: pytest.Config, description: Description) -> list[int] | None:
    node_ids: list[int] | None = config.getoption("node_id")
    if node_ids is not None:
        return node_ids
    if description.node_id is not None:
        return [description.node_id]
    for option, dest in (("--device", "device_description"), ("--eds", "eds")):
        name = config.getoption(dest)
        if name is not None and not config.getoption("self_test"):
            raise pytest.UsageError(
                f"{option}={name} does not say which node it is: add --node-id=N, or node-id = N "
                "to device.toml."
            )
    return None


def _bus(
    config: pytest.Config, description: Description, *, self_test: bool, simulated: bool
) -> BusSettings:
    if self_test:
        return BusSettings("simulated" if simulated else "virtual", private_channel())
    return BusSettings(
        config.getoption("can_interface") or description.interface,
        config.getoption("can_channel") or description.channel,
        config.getoption("can_bitrate") or description.bitrate,
    ).resolve()


def _listings(
    config: pytest.Config, description: Description, node_ids: list[int], *, self_test: bool
) -> dict[int, Listing]:
    name = config.getoption("eds")
    path = config.invocation_params.dir / name if name is not None else description.eds
    if path is not None:
        return {node_id: read_eds(path, node_id) for node_id in node_ids}
    if self_test and not config.getoption("conformance_objects"):
        without = lacking(config.getoption("fault"))
        return {node_id: reference_listing(node_id, without) for node_id in node_ids}
    return {}


def _permits(config: pytest.Config, description: Description, *, self_test: bool) -> Permits:
    named = list(config.getoption("conformance_objects"))
    if self_test and not named:
        return reference_permits(lacking(config.getoption("fault")))
    permissions = description.permissions | frozenset(config.getoption("conformance_permissions"))
    if self_test:
        permissions = PERMISSIONS  # the device is our own
    overridden = {known.mux for known in named}
    named += [known for known in description.writable if known.mux not in overridden]
    permits = Permits(
        tuple(named),
        description.all_rw,
        description.large,
        description.never,
        permissions,
        description.at_defaults,
    )
    permits.check()
    return permits


def _strict(config: pytest.Config) -> bool:
    # Up to pytest 8 --strict is a flag, from 9 on it overrides an ini option.
    overridden = config.getoption("override_ini", default=None) or []
    return config.getoption("strict", default=False) is True or "strict=true" in overridden


def _node_ids(text: str) -> list[int]:
    found: dict[int, None] = {}
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        try:
            low = int(first, 0)
            high = int(last, 0) if dash else low
        except ValueError:
            raise ArgumentTypeError(
                f"{part!r} is no node-ID: write a number or a range, as in 1-4,9"
            ) from None
        if not 1 <= low <= high <= HIGHEST_NODE_ID:
            raise ArgumentTypeError(f"{part!r}: node-IDs go from 1 to {HIGHEST_NODE_ID}")
        found.update(dict.fromkeys(range(low, high + 1)))
    return list(found)


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise ArgumentTypeError(f"{text!r} is no time: write seconds, as in 0.5")
    return value


def _channel(text: str) -> ChannelIds:
    try:
        return ChannelIds.parse(text)
    except ChannelError as error:
        raise ArgumentTypeError(str(error)) from None


def _permission(text: str) -> str:
    try:
        return parse_permission(text)
    except PermissionNameError as error:
        raise ArgumentTypeError(str(error)) from None


def _object(text: str) -> object:
    try:
        return parse_object(text)
    except ObjectNameError as error:
        raise ArgumentTypeError(str(error)) from None
