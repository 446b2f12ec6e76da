"""``device.toml``: what a user says of a device, once, instead of on every command line."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from conformance.bus.bit_rate import EXAMPLE as BIT_RATE
from conformance.bus.bit_rate import parse_bit_rate
from conformance.device.files import shown
from conformance.device.known_deviations import KnownDeviation, deviations_in
from conformance.device.known_objects import KnownObject, ObjectNameError, parse_object
from conformance.device.named_objects import NamedObject
from conformance.device.programs import words
from conformance.device.protected_objects import PERMISSIONS
from conformance.device.toml_tables import Table, TomlFile, anything, text_of
from conformance.sdo.cob_id import HIGHEST_NODE_ID
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nearest import did_you_mean

ALL_RW = "all-rw"
MOST = 1_000_000_000
MOST_LISTED = 2_000


@dataclass(frozen=True, slots=True)
class Description:
    """What device.toml says; None and empty stand for what it does not say.

    Times are in seconds. ``all_rw`` allows writes to everything that the EDS calls rw from 2000h
    on; ``at_defaults`` says that the defaults were loaded before the run. ``can_options`` are names
    and values of what else the interface takes. The ``command`` is started for the run in
    ``folder``, ``recover`` when the device is lost. Within ``storage`` the device stores its
    parameters or restores their defaults.
    """

    folder: Path = Path()
    node_id: int | None = None
    eds: Path | None = None
    interface: str | None = None
    channel: str | None = None
    bitrate: int | None = None
    can_options: tuple[tuple[str, str], ...] = ()
    writable: tuple[NamedObject, ...] = ()
    all_rw: bool = False
    large: KnownObject | None = None
    never: frozenset[Multiplexer] = frozenset()
    at_defaults: bool = False
    response: float | None = None
    server_timeout: float | None = None
    storage: float | None = None
    command: tuple[str, ...] = ()
    recover: tuple[str, ...] = ()
    permissions: frozenset[str] = frozenset()
    deviations: tuple[KnownDeviation, ...] = ()


def read_description(path: Path) -> Description:
    """Read a device.toml; raises FileError with the line and the nearest known key."""
    file = TomlFile.read(path)
    top = file.top()
    can = Table(file, "can", top.read("can", anything, "", {}))
    objects = Table(file, "objects", top.read("objects", anything, "", {}))
    timing = Table(file, "timing", top.read("timing", anything, "", {}))
    process = Table(file, "process", top.read("process", anything, "", {}))
    folder = path.parent
    description = Description(
        folder=folder,
        node_id=top.read("node-id", _node_id, f"node-IDs go from 1 to {HIGHEST_NODE_ID}", None),
        eds=top.read("eds", lambda name: folder / text_of(name), "write the name of a file", None),
        interface=can.read("interface", text_of, 'write a name, as in "socketcan"', None),
        channel=can.read("channel", text_of, 'write a name, as in "can0"', None),
        bitrate=can.read("bitrate", _bit_rate, BIT_RATE, None),
        can_options=can.read("options", _settings, "write a table, as in {port = 29536}", ()),
        writable=objects.read("writable", _objects, _WRITABLE, ()),
        all_rw=objects.read("writable", _has_all_rw, "", False),
        large=objects.read("large", _object, 'write an object, as in "2020=domain"', None),
        never=objects.read("never", _multiplexers, 'write a list, as in ["2100"]', frozenset()),
        at_defaults=objects.read("at-defaults", _flag, "write true or false", False),
        response=timing.read("response", _seconds, _TIME, None),
        server_timeout=timing.read("server-timeout", _seconds, _TIME, None),
        storage=timing.read("storage", _seconds, _TIME, None),
        command=process.read("command", _command, 'write a list, as in ["./my_server"]', ()),
        recover=process.read("recover", _command, 'write a command, as in "./cycle.sh"', ()),
        permissions=_permissions(file, top),
        deviations=deviations_in(file, top),
    )
    for table in (can, objects, timing, process, top):
        table.finish()
    return description


_TIME = "write seconds, as in 0.5"
_WRITABLE = f'write a list, as in ["2001", "2010:01=unsigned16"], or "{ALL_RW}"'


def _permissions(file: TomlFile, top: Table) -> frozenset[str]:
    """Return the names in a list, or those that are true in a table."""
    value: Any = top.read("permissions", anything, "", [])
    if isinstance(value, dict):
        table = Table(file, "permissions", value)
        names = sorted(PERMISSIONS)
        given = {name for name in names if table.read(name, _flag, "write true or false", False)}
        table.finish()
        return frozenset(given)
    names = value if isinstance(value, list) else [value]
    for name in names:
        if not isinstance(name, str) or name not in PERMISSIONS:
            raise file.error(
                f"there is no permission {shown(name)}. "
                f"{did_you_mean(name if isinstance(name, str) else '', sorted(PERMISSIONS))}",
                "",
                "permissions",
            )
    return frozenset(names)


# Converters: each raises ValueError or TypeError for a value that is not as it should be


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise TypeError
    return value


def _count(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= MOST:
        raise ValueError
    return value


def _bit_rate(value: object) -> int:
    return parse_bit_rate(str(_count(value) if isinstance(value, int) else text_of(value)))


def _node_id(value: object) -> int:
    number = _count(value)
    if number > HIGHEST_NODE_ID:
        raise ValueError
    return number


def _seconds(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError
    if not 0 < value <= 86_400:
        raise ValueError
    return float(value)


def _object(value: object) -> KnownObject:
    return parse_object(text_of(value))


def _listed(value: object) -> Iterable[object]:
    if not isinstance(value, list):
        raise TypeError
    if len(value) > MOST_LISTED:
        raise ObjectNameError(f"a list of {len(value)}: at most {MOST_LISTED} can be read.")
    return value


def _objects(value: object) -> tuple[NamedObject, ...]:
    if value == ALL_RW:
        return ()
    return tuple(NamedObject.parse(text_of(one)) for one in _listed(value) if one != ALL_RW)


def _has_all_rw(value: object) -> bool:
    return value == ALL_RW or (isinstance(value, list) and ALL_RW in value)


def _multiplexers(value: object) -> frozenset[Multiplexer]:
    """Return what is listed; without a sub-index an object is meant with all of them."""
    found: set[Multiplexer] = set()
    for one in _listed(value):
        index = _object(one).mux.index
        whole = ":" not in text_of(one)
        found |= {Multiplexer(index, sub) for sub in range(256)} if whole else {_object(one).mux}
    return frozenset(found)


def _settings(value: object) -> tuple[tuple[str, str], ...]:
    """Return the table as texts, which python-can makes numbers of where it should."""
    if not isinstance(value, dict):
        raise TypeError
    for one in value.values():
        if not isinstance(one, str | int | float):
            raise TypeError
    return tuple((name, str(one)) for name, one in value.items())


def _command(value: object) -> tuple[str, ...]:
    """Return a command in words; a text is read as a shell reads it."""
    if isinstance(value, str):
        return tuple(words(text_of(value)))
    listed = tuple(text_of(one) for one in _listed(value))
    if not listed:
        raise ValueError
    return listed
