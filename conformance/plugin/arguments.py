"""The suite's options: how they are declared to pytest, and what each of them takes."""

import math
import re
from argparse import ArgumentTypeError
from collections.abc import Iterable

import pytest

from conformance.bus.arguments import bit_rate, named_value
from conformance.device.effort import EXAMPLES, EXAMPLES_WHEN_THOROUGH, REQUESTS_IN_HASTE
from conformance.device.known_objects import ObjectNameError
from conformance.device.named_objects import NamedObject
from conformance.device.programs import words
from conformance.device.protected_objects import PermissionNameError, parse_permission
from conformance.eds.client_channel import ClientRecord, parse_channel
from conformance.plugin.settings import DEFAULT_REPORT_DIR
from conformance.reporting.requirements import (
    Requirement,
    RequirementError,
    parse_requirement,
)
from conformance.run.bench import DEFAULT_RESPONSE_TIMEOUT, DEFAULT_SEED
from conformance.sdo.cob_id import HIGHEST_NODE_ID, ChannelError, ChannelIds
from conformance.sdo.nearest import nearest

# How our options begin, and those that begin otherwise.
PREFIXES, OTHERS = ("--sdo-", "--can-"), ("--node-id", "--self-test")
_NUMBER = r"(\d+(?:\.\d+)?)"
_DURATION = re.compile(f"(?:{_NUMBER}h)?(?:{_NUMBER}min)?(?:{_NUMBER}s?)?", re.ASCII)
_UNITS = (3600, 60, 1)


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
    group.addoption(
        "--sdo-device",
        metavar="FILE.toml",
        help="the description of the device: node-ID, bus, EDS, what may be written and more; "
        "options override it",
    )
    group.addoption(
        "--sdo-eds",
        metavar="FILE",
        help="the EDS or DCF of the device: adds cases for every object that it lists",
    )
    group.addoption(
        "--sdo-scan",
        action="store_true",
        help="read all 65535 indices as well, and list those that are not in the EDS",
    )
    group.addoption("--can-interface", metavar="NAME", help="python-can interface (socketcan)")
    group.addoption("--can-channel", metavar="NAME", help="channel of the interface (can0)")
    group.addoption(
        "--can-bitrate",
        metavar="BIT/S",
        type=bit_rate,
        help="bit rate for interfaces that set it, such as 500k or 1M; SocketCAN's is set with "
        "'ip link'",
    )
    group.addoption(
        "--can-option",
        metavar="NAME=VALUE",
        type=named_value,
        action="append",
        default=[],
        help="a further setting of the interface in python-can, such as host=10.0.0.7 or "
        "port=29536 of socketcand; may be repeated",
    )
    group.addoption(
        "--sdo-response-timeout",
        metavar="SECONDS",
        type=_seconds,
        help=f"time within which a response has to come ({DEFAULT_RESPONSE_TIMEOUT})",
    )
    group.addoption(
        "--sdo-server-timeout",
        metavar="SECONDS",
        type=_seconds,
        help="time after which the device aborts the transfer of a silent client, if it does; adds "
        "the cases that test this (the built-in server gets such a time-out)",
    )
    group.addoption(
        "--sdo-object",
        metavar="INDEX[:SUB][=TYPE[,ACCESS]]",
        type=_object,
        action="append",
        default=[],
        help="an object that may be written (and is restored), such as 2001 or 2010:01=unsigned16; "
        "access wo or ro: an object that cannot be read or written; may be repeated",
    )
    group.addoption(
        "--sdo-channel",
        metavar="REQUEST:RESPONSE|FILE:RECORD",
        type=_channel,
        help="test the device on another SDO channel than the default one: its CAN-IDs in "
        "hexadecimal, as in 640:5C0 (more than 3 digits are 29-bit CAN-IDs), or an SDO client "
        "parameter in the EDS or DCF of its client, as in plc.dcf:1280",
    )
    group.addoption(
        "--sdo-allow",
        metavar="NAME",
        type=_permission,
        action="append",
        default=[],
        help="a permission: nmt (NMT commands to the device, which the run leaves Pre-operational, "
        "and 1017h), sdo-parameters (1200h to 12FFh, restored afterwards), or another name of "
        "docs/device.md; may be repeated",
    )
    group.addoption(
        "--self-test",
        action="store_true",
        help="test the built-in reference server on a virtual bus: no hardware, no device",
    )
    group.addoption(
        "--sdo-fault",
        metavar="NAME",
        help="with --self-test: a faulty or unusual server instead ('conformance faults' lists)",
    )
    group.addoption(
        "--sdo-simulated",
        action="store_true",
        help="with --self-test: simulated time, so that no case has to wait",
    )
    group.addoption(
        "--sdo-answer-delay",
        metavar="SECONDS",
        type=_seconds,
        default=0.0,
        help="with --self-test: the response time of the server (none)",
    )
    group.addoption(
        "--sdo-process",
        metavar="COMMAND",
        type=_command,
        help="the device as a program: started for the run, stopped afterwards, started again "
        "when lost; {node_id} stands for the node-ID",
    )
    group.addoption(
        "--sdo-recover",
        metavar="COMMAND",
        type=_command,
        help="command that brings a lost device back, such as ./power-cycle.sh",
    )
    group.addoption(
        "--sdo-deviations",
        metavar="FILE",
        help="TOML file of known deviations: [[deviations]] tables of case and reason; a listed "
        "case may fail, and must not pass",
    )
    group.addoption(
        "--sdo-write-deviations",
        metavar="FILE",
        help="write a draft of such a file, from the failures of this run",
    )
    group.addoption(
        "--sdo-report-dir",
        metavar="DIR",
        help=f"where each run leaves a folder with its reports ({DEFAULT_REPORT_DIR})",
    )
    group.addoption(
        "--sdo-no-page",
        action="store_true",
        help="write no report.html, which takes some seconds after a run of many frames; "
        "'conformance report DIR' writes it later",
    )
    group.addoption(
        "--sdo-restore",
        action="store_true",
        help="first restore the values that an earlier, killed run left changed on the device",
    )
    group.addoption(
        "--sdo-seed",
        metavar="N",
        type=int,
        default=DEFAULT_SEED,
        help="seed for the bytes that cases write, and for random conversations (%(default)s)",
    )
    group.addoption(
        "--sdo-examples",
        metavar="N",
        type=_count,
        help=f"random conversations that each case random.* tries ({EXAMPLES}); 0 for none",
    )
    group.addoption(
        "--sdo-require",
        metavar="WHAT",
        type=_requirement,
        action="append",
        default=[],
        help="what the run has to have tested to be green: a share of its cases (90%%), a service "
        "(block, segmented upload), a rule (block.crc) or an official step ('SDO 09'); else the "
        "run says what to add, and its exit status is 14; may be repeated",
    )
    group.addoption(
        "--sdo-budget",
        metavar="TIME",
        type=duration,
        help="how long the run may take, such as 5min, 2min30s or 300: the cases that show most in "
        "the shortest time come first, the others are 'not run'",
    )
    group.addoption(
        "--sdo-quick",
        action="store_true",
        help=f"only the cases that show most in {REQUESTS_IN_HASTE} requests; says what it leaves "
        "out",
    )
    group.addoption(
        "--sdo-thorough",
        action="store_true",
        help=f"{EXAMPLES_WHEN_THOROUGH} random conversations for each case random.*, and every "
        "pair of states, the cases pairs.*",
    )


def check_names(unknown: Iterable[str], options: Iterable[str]) -> None:
    """Raise pytest.UsageError for an ``unknown`` argument that is nearly one of our ``options``.

    pytest itself would say that it does not know it, and not what is called nearly the same. Other
    unknown arguments are left to pytest.
    """
    names = [name for name in options if name.startswith(PREFIXES) or name in OTHERS]
    for name in (argument.partition("=")[0] for argument in unknown):
        if not name.startswith("--"):
            continue
        near = " or ".join(nearest(name, names))
        if near:
            raise pytest.UsageError(f"There is no option {name}. Did you mean {near}?")
        if name.startswith(PREFIXES):
            raise pytest.UsageError(f"There is no option {name}. pytest --help lists them.")


def _count(text: str) -> int:
    if not text.isdecimal():
        raise ArgumentTypeError(f"{text!r} is no number of examples: write 0, 100 or the like")
    return int(text)


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
        if dash and low > high:
            raise ArgumentTypeError(f"{part!r} counts down: write the lower node-ID first")
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


def duration(text: str) -> float:
    """Return the seconds of a time such as 5min, 2min30s or 300; raises ArgumentTypeError."""
    found = _DURATION.fullmatch(text)
    parts = found.groups(default="0") if found else ("0", "0", "0")
    seconds = sum(float(part) * unit for part, unit in zip(parts, _UNITS, strict=True))
    if not seconds:
        raise ArgumentTypeError(f"{text!r} is no time: write 5min, 2min30s, 1h or seconds")
    return seconds


def _channel(text: str) -> ChannelIds | ClientRecord:
    try:
        return parse_channel(text)
    except ChannelError as error:
        raise ArgumentTypeError(str(error)) from None


def _permission(text: str) -> str:
    try:
        return parse_permission(text)
    except PermissionNameError as error:
        raise ArgumentTypeError(str(error)) from None


def _requirement(text: str) -> Requirement:
    try:
        return parse_requirement(text)
    except RequirementError as error:
        raise ArgumentTypeError(str(error)) from None


def _command(text: str) -> list[str]:
    try:
        parts = words(text)
    except ValueError as error:
        raise ArgumentTypeError(f"{text!r} is no command: {error}") from None
    if not parts:
        raise ArgumentTypeError("an empty text is no command")
    return parts


def _object(text: str) -> object:
    try:
        return NamedObject.parse(text)
    except ObjectNameError as error:
        raise ArgumentTypeError(str(error)) from None
