"""The suite's options: how they are declared to pytest and read into settings."""

import math
import shlex
from argparse import ArgumentTypeError
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from conformance.bus.errors import BusNotOpened
from conformance.bus.opening import BusSettings
from conformance.device.known_deviations import Deviation, DeviationsError, read_deviations
from conformance.device.objects import ObjectNameError, parse_object
from conformance.device.process import NODE_ID, ProcessSettings
from conformance.faults.catalogue import UnknownServer, find_deviation
from conformance.faults.device import REFERENCE_OBJECTS
from conformance.run.bench import (
    DEFAULT_RESPONSE_TIMEOUT,
    DEFAULT_SEED,
    RunSettings,
    private_channel,
)
from conformance.workers import Share, share_of

SELF_TEST_NODE = 5
HIGHEST_NODE_ID = 127


@dataclass(frozen=True, slots=True)
class Options:
    """What the command line said.

    ``node_ids`` are all devices of the run, ``run.node_ids`` those that this process tests.
    ``answer_delay`` is in seconds. ``draft`` is where the known deviations are drafted.
    """

    run: RunSettings
    self_test: bool
    server: str | None
    report_dir: Path
    strict: bool
    node_ids: list[int]
    share: Share
    answer_delay: float
    deviations: list[Deviation] = field(default_factory=list)
    draft: Path | None = None


def add_options(parser: pytest.Parser) -> None:
    """Declare the options. ``--strict`` is pytest's own; the suite listens to it."""
    group = parser.getgroup("conformance", "CANopen SDO conformance")
    group.addoption(
        "--node-id",
        metavar="N",
        type=_node_ids,
        help="node-ID of the device under test, 1 to 127; a list like 1-4,9 for several, which "
        "are tested in turn, or at once with -n of pytest-xdist",
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
        "--can-option",
        metavar="NAME=VALUE",
        type=named_value,
        action="append",
        default=[],
        dest="can_options",
        help="anything else that the interface takes in python-can, as host=10.0.0.7 and "
        "port=29536 of socketcand; may be repeated",
    )
    group.addoption(
        "--response-timeout",
        metavar="SECONDS",
        type=_seconds,
        default=DEFAULT_RESPONSE_TIMEOUT,
        help="time within which a response has to come (%(default)s)",
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
        "--answer-delay",
        metavar="SECONDS",
        type=_seconds,
        default=0.0,
        help="with --self-test: the time that the device takes for each answer (none)",
    )
    group.addoption(
        "--process",
        metavar="COMMAND",
        type=_command,
        help="the device as a program: started for the run, stopped afterwards, started again "
        "when lost; {node_id} stands for the node-ID",
    )
    group.addoption(
        "--recover",
        metavar="COMMAND",
        type=_command,
        help="what brings a device on the bench back that was lost, as ./power-cycle.sh",
    )
    group.addoption(
        "--deviations",
        metavar="FILE",
        help="TOML with known deviations: [[deviations]] tables of case and reason; a case that "
        "is listed may fail, and must not pass",
    )
    group.addoption(
        "--write-deviations",
        metavar="FILE",
        help="draft such a list from what fails in this run",
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
    if config.getoption("answer_delay") and not self_test:
        raise pytest.UsageError("--answer-delay goes with --self-test.")
    if not self_test and node_ids is None:
        return None
    try:
        find_deviation(server)
    except UnknownServer as error:
        raise pytest.UsageError(str(error)) from error
    objects = list(config.getoption("conformance_objects"))
    if self_test:
        bus = BusSettings("virtual", private_channel())
        objects = objects or list(REFERENCE_OBJECTS)
    else:
        bus = BusSettings(
            config.getoption("can_interface"),
            config.getoption("can_channel"),
            config.getoption("can_bitrate"),
            tuple(config.getoption("can_options")),
        )
        try:
            bus = bus.resolve()
        except BusNotOpened as error:
            raise pytest.UsageError(str(error)) from error
    node_ids = node_ids or [SELF_TEST_NODE]
    share = share_of(config, node_ids)
    # Workers of a self-test have a bus each; on a real one they meet.
    neighbours = frozenset() if self_test else frozenset(node_ids) - frozenset(share.node_ids)
    run = RunSettings(
        share.node_ids,
        bus,
        config.getoption("response_timeout"),
        objects,
        config.getoption("seed"),
        neighbours,
        _process(config, node_ids),
    )
    report_dir = config.invocation_params.dir / config.getoption("report_dir")
    return Options(
        run,
        self_test,
        server,
        report_dir,
        _strict(config),
        node_ids,
        share,
        config.getoption("answer_delay"),
        _deviations(config),
        _path(config, "write_deviations"),
    )


def _process(config: pytest.Config, node_ids: list[int]) -> ProcessSettings | None:
    command, recover = config.getoption("process"), config.getoption("recover")
    if command is None and recover is None:
        return None
    if config.getoption("self_test"):
        raise pytest.UsageError("--process and --recover go with a device, not with --self-test.")
    settings = ProcessSettings(command or [], None if recover is None else shlex.join(recover))
    if len(node_ids) > 1 and settings.command and not settings.names_node_id:
        raise pytest.UsageError(
            f"--process starts one program for each device: say with {NODE_ID} where the node-ID "
            f"goes, as in --process='./my_server vcan0 {NODE_ID}'."
        )
    return settings


def _path(config: pytest.Config, option: str) -> Path | None:
    name = config.getoption(option)
    return None if name is None else config.invocation_params.dir / str(name)


def _deviations(config: pytest.Config) -> list[Deviation]:
    path = _path(config, "deviations")
    try:
        return [] if path is None else read_deviations(path)
    except DeviationsError as error:
        raise pytest.UsageError(str(error)) from error


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


def named_value(text: str) -> tuple[str, str]:
    """Read NAME=VALUE; raises ArgumentTypeError."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip().isidentifier():
        raise ArgumentTypeError(f"{text!r} is no setting: write NAME=VALUE, as in port=29536")
    return name.strip(), value


def _command(text: str) -> list[str]:
    try:
        parts = shlex.split(text)
    except ValueError as error:
        raise ArgumentTypeError(f"{text!r} is no command: {error}") from None
    if not parts:
        raise ArgumentTypeError("an empty text is no command")
    return parts


def _object(text: str) -> object:
    try:
        return parse_object(text)
    except ObjectNameError as error:
        raise ArgumentTypeError(str(error)) from None
