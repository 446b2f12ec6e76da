"""The suite's options: how they are declared to pytest and read into settings."""

import math
from argparse import ArgumentTypeError
from dataclasses import dataclass
from pathlib import Path

import pytest

from conformance.bus.errors import BusNotOpened
from conformance.bus.opening import BusSettings
from conformance.device.objects import KnownObject, ObjectNameError, parse_object
from conformance.device.safety import (
    ALL_PERMISSIONS,
    Permission,
    PermissionNameError,
    how_to_permit,
    is_protected,
    parse_permission,
    permission_for,
)
from conformance.faults.catalogue import UnknownServer, find_deviation
from conformance.faults.device import REFERENCE_OBJECTS
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


def add_options(parser: pytest.Parser) -> None:
    """Declare the options. ``--strict`` is pytest's own; the suite listens to it."""
    group = parser.getgroup("conformance", "CANopen SDO conformance")
    group.addoption(
        "--node-id",
        metavar="N",
        type=_node_ids,
        help="node-ID of the device under test, 1 to 127; a list like 1-4,9 for several",
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
        default=DEFAULT_RESPONSE_TIMEOUT,
        help="time within which a response has to come (%(default)s)",
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
        "Pre-operational, and 1017h), sdo-parameters (1200h to 12FFh, restored afterwards); "
        "may be repeated",
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
    node_ids = config.getoption("node_id")
    server = config.getoption("fault")
    if server is not None and not self_test:
        raise pytest.UsageError(f"--fault={server} goes with --self-test.")
    simulated = bool(config.getoption("simulated"))
    if simulated and not self_test:
        raise pytest.UsageError("--simulated goes with --self-test: a real device takes its time.")
    if not self_test and node_ids is None:
        return None
    if config.getoption("dist", default="no") != "no":
        raise pytest.UsageError(
            "Cases run one after another in one process: leave out -n (pytest-xdist). Several "
            "devices are tested in turn: --node-id=1-4."
        )
    try:
        find_deviation(server)
    except UnknownServer as error:
        raise pytest.UsageError(str(error)) from error
    objects = list(config.getoption("conformance_objects"))
    permissions = frozenset(config.getoption("conformance_permissions"))
    sdo_channel = config.getoption("sdo_channel")
    if sdo_channel is not None and (self_test or len(node_ids) > 1):
        raise pytest.UsageError("--sdo-channel goes with one device: --node-id=N.")
    if self_test:
        permissions = ALL_PERMISSIONS  # the device is our own
        bus = BusSettings("simulated" if simulated else "virtual", private_channel())
        objects = objects or list(REFERENCE_OBJECTS)
    else:
        bus = BusSettings(
            config.getoption("can_interface"),
            config.getoption("can_channel"),
            config.getoption("can_bitrate"),
        )
        try:
            bus = bus.resolve()
        except BusNotOpened as error:
            raise pytest.UsageError(str(error)) from error
    _check_objects(objects, permissions)
    run = RunSettings(
        node_ids or [SELF_TEST_NODE],
        bus,
        config.getoption("response_timeout"),
        objects,
        config.getoption("seed"),
        config.getoption("server_timeout"),
        permissions,
        sdo_channel,
    )
    report_dir = config.invocation_params.dir / config.getoption("report_dir")
    return Options(run, self_test, server, report_dir, _strict(config), simulated)


def _check_objects(objects: list[KnownObject], permissions: frozenset[Permission]) -> None:
    for known in objects:
        index = known.mux.index
        if not known.access.writable or not is_protected(index):
            continue
        if permission_for(index) not in permissions:
            raise pytest.UsageError(
                f"--object={index:04X} may not be written. {how_to_permit(index)} To have it read "
                "only, name it with its type and the access ro."
            )


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


def _permission(text: str) -> Permission:
    try:
        return parse_permission(text)
    except PermissionNameError as error:
        raise ArgumentTypeError(str(error)) from None


def _object(text: str) -> object:
    try:
        return parse_object(text)
    except ObjectNameError as error:
        raise ArgumentTypeError(str(error)) from None
