"""The kinds of values that options take: read from an argument, and from ``device.toml``."""

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, Generic, TypeVar

from conformance.bus.bit_rate import EXAMPLE as BIT_RATE_EXAMPLE
from conformance.bus.bit_rate import parse_bit_rate
from conformance.device.files import shown
from conformance.device.known_deviations import KnownDeviation, deviations_in
from conformance.device.known_objects import KnownObject, ObjectNameError, parse_object
from conformance.device.named_objects import NamedObject
from conformance.device.programs import words
from conformance.device.protected_objects import PERMISSIONS, parse_permission
from conformance.device.toml_tables import Table, anything, text_of
from conformance.sdo.cob_id import HIGHEST_NODE_ID, ChannelError, ChannelIds
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nearest import did_you_mean

ALL_RW = "all-rw"
MOST = 1_000_000_000
MOST_LISTED = 2_000
LONGEST = 86_400
_NODE_IDS = f"node-IDs go from 1 to {HIGHEST_NODE_ID}"
_NUMBER = r"(\d+(?:\.\d+)?)"
_DURATION = re.compile(f"(?:{_NUMBER}h)?(?:{_NUMBER}min)?(?:{_NUMBER}s?)?", re.ASCII)
_UNITS = (3600, 60, 1)
# SDO client parameters.
CLIENT_RECORDS = range(0x1280, 0x1300)
_RECORD = re.compile(r"(?:0x)?([0-9a-f]{4})h?", re.IGNORECASE)

Value = TypeVar("Value")
Value_co = TypeVar("Value_co", covariant=True)


@dataclass(frozen=True, slots=True)
class ClientRecord:
    """An SDO client parameter record, and the EDS or DCF of the client that has it."""

    path: Path
    index: int


class Action(Enum):
    """How often an option is given, in the terms of argparse."""

    ONCE = "store"
    OFTEN = "append"
    FLAG = "store_true"


def _no_key(table: Table, key: str) -> None:
    """Read nothing: such values stand in no device.toml."""
    del table, key


@dataclass(frozen=True)
class Kind(Generic[Value_co]):
    """How an option is read.

    ``parse`` takes one argument of the command line; it raises ValueError with a sentence.
    ``read_key`` reads a key of device.toml, None where it is missing; it raises FileError.
    """

    metavar: str = ""
    parse: Callable[[str], object] = str
    read_key: Callable[[Table, str], Value_co | None] = field(default=_no_key)
    action: Action = Action.ONCE


def _by(convert: Callable[[Any], Value], wanted: str) -> Callable[[Table, str], Value | None]:
    """Return a reader of device.toml; ``convert`` raises ValueError or TypeError."""

    def read(table: Table, key: str) -> Value | None:
        return table.read(key, convert, wanted, None)

    return read


# One argument of the command line


def _number(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"{text!r} is no number: write 1, 2 or the like") from None


def _examples(text: str) -> int:
    if not text.isdecimal():
        raise ValueError(f"{text!r} is no number of examples: write 0, 100 or the like")
    return int(text)


def _node_id(text: str) -> int:
    try:
        number = int(text, 0)
    except ValueError:
        raise ValueError(f"{text!r} is no node-ID: write a number") from None
    if not 1 <= number <= HIGHEST_NODE_ID:
        raise ValueError(f"{text!r}: {_NODE_IDS}")
    return number


def _node_ids(text: str) -> list[int]:
    found: dict[int, None] = {}
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        try:
            low = int(first, 0)
            high = int(last, 0) if dash else low
        except ValueError:
            raise ValueError(
                f"{part!r} is no node-ID: write a number or a range, as in 1-4,9"
            ) from None
        if dash and low > high:
            raise ValueError(f"{part!r} counts down: write the lower node-ID first")
        if not 1 <= low <= high <= HIGHEST_NODE_ID:
            raise ValueError(f"{part!r}: {_NODE_IDS}")
        found.update(dict.fromkeys(range(low, high + 1)))
    return list(found)


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise ValueError(f"{text!r} is no time: write seconds, as in 0.5")
    return value


def duration(text: str) -> float:
    """Return the seconds of a time such as 5min, 2min30s or 300; raises ValueError."""
    found = _DURATION.fullmatch(text)
    parts = found.groups(default="0") if found else ("0", "0", "0")
    seconds = sum(float(part) * unit for part, unit in zip(parts, _UNITS, strict=True))
    if not seconds:
        raise ValueError(f"{text!r} is no time: write 5min, 2min30s, 1h or seconds")
    return seconds


def _named_value(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals or not name.strip().isidentifier():
        raise ValueError(f"{text!r} is no setting: write NAME=VALUE, as in port=29536")
    return name.strip(), value


def parse_channel(text: str) -> ChannelIds | ClientRecord:
    """Read ``REQUEST:RESPONSE``, two CAN-IDs, or ``FILE:RECORD``; whatever has a dot is a file.

    >>> f"{parse_channel('plc.dcf:1280').index:X}h"
    '1280h'

    Raises ChannelError.
    """
    if "." not in text:
        return ChannelIds.parse(text)
    name, colon, record = text.rpartition(":")
    if "." in record or not colon:
        raise ChannelError(f"{text!r} does not say which record of the file: write {text}:1280")
    match = _RECORD.fullmatch(record.strip())
    index = int(match[1], 16) if match else 0
    if index not in CLIENT_RECORDS:
        raise ChannelError(
            f"{record!r} is no SDO client parameter record: write 1280 to 12FF, as in plc.dcf:1280"
        )
    return ClientRecord(Path(name), index)


def _command(text: str) -> tuple[str, ...]:
    try:
        parts = words(text)
    except ValueError as error:
        raise ValueError(f"{text!r} is no command: {error}") from None
    if not parts:
        raise ValueError("an empty text is no command")
    return tuple(parts)


# One value of device.toml: each raises ValueError or TypeError


def _flag_of(value: object) -> bool:
    if not isinstance(value, bool):
        raise TypeError
    return value


def _count_of(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= MOST:
        raise ValueError
    return value


def _bit_rate_of(value: object) -> int:
    return parse_bit_rate(str(_count_of(value) if isinstance(value, int) else text_of(value)))


def _node_id_of(value: object) -> list[int]:
    number = _count_of(value)
    if number > HIGHEST_NODE_ID:
        raise ValueError
    return [number]


def _path_of(value: object) -> Path:
    return Path(text_of(value))


def _seconds_of(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError
    if not 0 < value <= LONGEST:
        raise ValueError
    return float(value)


def _object_of(value: object) -> KnownObject:
    return parse_object(text_of(value))


def _listed(value: object) -> Iterable[object]:
    if not isinstance(value, list):
        raise TypeError
    if len(value) > MOST_LISTED:
        raise ObjectNameError(f"a list of {len(value)}: at most {MOST_LISTED} can be read.")
    return value


def _objects_of(value: object) -> tuple[NamedObject, ...]:
    if value == ALL_RW:
        return ()
    return tuple(NamedObject.parse(text_of(one)) for one in _listed(value) if one != ALL_RW)


def _has_all_rw(value: object) -> bool:
    return value == ALL_RW or (isinstance(value, list) and ALL_RW in value)


def _multiplexers_of(value: object) -> frozenset[Multiplexer]:
    """Return the listed entries; without a sub-index, all 256 of an object."""
    found: set[Multiplexer] = set()
    for one in _listed(value):
        index = _object_of(one).mux.index
        whole = ":" not in text_of(one)
        found |= {Multiplexer(index, sub) for sub in range(256)} if whole else {_object_of(one).mux}
    return frozenset(found)


def _named_values_of(value: object) -> tuple[tuple[str, str], ...]:
    """Return a table as texts; python-can converts numbers itself."""
    if not isinstance(value, dict):
        raise TypeError
    for one in value.values():
        if not isinstance(one, str | int | float):
            raise TypeError
    return tuple((name, str(one)) for name, one in value.items())


def _command_of(value: object) -> tuple[str, ...]:
    """Return the words of a command; a text is split as a shell splits it."""
    if isinstance(value, str):
        return tuple(words(text_of(value)))
    listed = tuple(text_of(one) for one in _listed(value))
    if not listed:
        raise ValueError
    return listed


def _permissions(table: Table, key: str) -> tuple[str, ...] | None:
    """Return the names in a list, or those that are true in a table."""
    value: Any = table.read(key, anything, "", [])
    names = sorted(PERMISSIONS)
    if isinstance(value, dict):
        inner = table.inner(key)
        wanted = "write true or false"
        given = [name for name in names if inner.read(name, _flag_of, wanted, False)]
        inner.finish()
        return tuple(given) or None
    listed = value if isinstance(value, list) else [value]
    for name in listed:
        if not isinstance(name, str) or name not in PERMISSIONS:
            nearest = did_you_mean(name if isinstance(name, str) else "", names)
            raise table.error(key, f"there is no permission {shown(name)}. {nearest}")
    return tuple(listed) or None


def _deviations(table: Table, key: str) -> tuple[KnownDeviation, ...] | None:
    del key  # it is the one of a file of deviations
    return deviations_in(table) or None


_TIME = "write seconds, as in 0.5"
_WRITABLE = f'write a list, as in ["2001", "2010:01=unsigned16"], or "{ALL_RW}"'

FLAG = Kind[bool](read_key=_by(_flag_of, "write true or false"), action=Action.FLAG)
TEXT = Kind[str]("NAME", str, _by(text_of, "write a text"))
TEXTS = Kind[tuple[str, ...]]("WHAT", str, action=Action.OFTEN)
NUMBER = Kind[int]("N", _number)
EXAMPLES = Kind[int]("N", _examples)
SECONDS = Kind[float]("SECONDS", _seconds, _by(_seconds_of, _TIME))
DURATION = Kind[float]("TIME", duration)
FILE = Kind[Path]("FILE", Path, _by(_path_of, "write the name of a file"))
FOLDER = Kind[Path]("DIR", Path)
NODE_ID = Kind[int]("N", _node_id)
NODE_IDS = Kind[list[int]]("N", _node_ids, _by(_node_id_of, _NODE_IDS))
INTERFACE = Kind[str]("NAME", str, _by(text_of, 'write a name, as in "socketcan"'))
CHANNEL = Kind[str]("NAME", str, _by(text_of, 'write a name, as in "can0"'))
BIT_RATE = Kind[int]("BIT/S", parse_bit_rate, _by(_bit_rate_of, BIT_RATE_EXAMPLE))
NAMED_VALUES = Kind[tuple[tuple[str, str], ...]](
    "NAME=VALUE",
    _named_value,
    _by(_named_values_of, "write a table, as in {port = 29536}"),
    Action.OFTEN,
)
OBJECT = Kind[KnownObject](
    read_key=_by(_object_of, 'write an object, as in "2020=domain"'),
)
OBJECTS = Kind[tuple[NamedObject, ...]](
    "INDEX[:SUB][=TYPE[,ACCESS]]", NamedObject.parse, _by(_objects_of, _WRITABLE), Action.OFTEN
)
HAS_ALL_RW = Kind[bool](read_key=_by(_has_all_rw, ""))
ENTRIES = Kind[frozenset[Multiplexer]](
    read_key=_by(_multiplexers_of, 'write a list, as in ["2100"]')
)
SDO_CHANNEL = Kind[ChannelIds | ClientRecord]("REQUEST:RESPONSE|FILE:RECORD", parse_channel)
PROGRAM = Kind[tuple[str, ...]](
    "COMMAND", _command, _by(_command_of, 'write a list, as in ["./my_server"]')
)
COMMAND = Kind[tuple[str, ...]](
    "COMMAND", _command, _by(_command_of, 'write a command, as in "./cycle.sh"')
)
GRANTED = Kind[tuple[str, ...]]("NAME", parse_permission, _permissions, Action.OFTEN)
DEVIATIONS = Kind[tuple[KnownDeviation, ...]](read_key=_deviations)
