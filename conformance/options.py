"""The suite's options: how they are declared to pytest and read into settings."""

import math
from argparse import ArgumentTypeError
from dataclasses import dataclass
from pathlib import Path

import pytest

from conformance.bus.errors import BusNotOpened
from conformance.bus.opening import BusSettings
from conformance.device.objects import ObjectNameError, parse_object
from conformance.faults.catalogue import UnknownServer, find_deviation
from conformance.faults.device import REFERENCE_OBJECTS
from conformance.run.bench import (
    DEFAULT_RESPONSE_TIMEOUT,
    DEFAULT_SEED,
    RunSettings,
    private_channel,
)

SELF_TEST_NODE = 5
HIGHEST_NODE_ID = 127
DEFAULT_EXAMPLES = 20


@dataclass(frozen=True, slots=True)
class Options:
    """What the command line said."""

    run: RunSettings
    self_test: bool
    server: str | None
    report_dir: Path
    strict: bool
    simulated: bool
    examples: int = DEFAULT_EXAMPLES


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
        help="decides on the bytes that cases write, and on random conversations (%(default)s)",
    )
    group.addoption(
        "--examples",
        metavar="N",
        type=_count,
        default=DEFAULT_EXAMPLES,
        help="random conversations that each case random.* tries (%(default)s); 0 for none",
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
    if self_test:
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
    run = RunSettings(
        node_ids or [SELF_TEST_NODE],
        bus,
        config.getoption("response_timeout"),
        objects,
        config.getoption("seed"),
    )
    report_dir = config.invocation_params.dir / config.getoption("report_dir")
    examples = config.getoption("examples")
    return Options(run, self_test, server, report_dir, _strict(config), simulated, examples)


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


def _count(text: str) -> int:
    if not text.isdecimal():
        raise ArgumentTypeError(f"{text!r} is no number of examples: write 0, 100 or the like")
    return int(text)


def _object(text: str) -> object:
    try:
        return parse_object(text)
    except ObjectNameError as error:
        raise ArgumentTypeError(str(error)) from None
