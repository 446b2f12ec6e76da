"""``device.toml``: what a user says of a device, once, instead of on every command line."""

import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from conformance.device.deny import PERMISSIONS
from conformance.device.files import FileError, did_you_mean, read_text, shortened
from conformance.device.objects import KnownObject, ObjectNameError, parse_object
from conformance.sdo.layout import Multiplexer

Read = TypeVar("Read")
LARGEST = 64 * 1024
# What tomllib needs for a key of many parts grows with their square.
LONGEST_LINE = 4096
HIGHEST_NODE_ID = 127
ALL_RW = "all-rw"


@dataclass(frozen=True, slots=True)
class KnownDeviation:
    """A case, or the beginning of the ids of several, that fails for a known reason."""

    case: str
    reason: str


@dataclass(frozen=True, slots=True)
class Description:
    """What device.toml says; None and empty stand for what it does not say.

    Times are in seconds. ``all_rw`` allows writes to everything that the EDS calls rw from 2000h
    on; ``at_defaults`` says that the defaults were loaded before the run. The ``command`` is
    started for the run in ``folder``, ``recover`` when the device is lost.
    """

    folder: Path = Path()
    node_id: int | None = None
    eds: Path | None = None
    interface: str | None = None
    channel: str | None = None
    bitrate: int | None = None
    writable: tuple[KnownObject, ...] = ()
    all_rw: bool = False
    large: KnownObject | None = None
    never: frozenset[Multiplexer] = frozenset()
    at_defaults: bool = False
    response: float | None = None
    server_timeout: float | None = None
    command: tuple[str, ...] = ()
    recover: tuple[str, ...] = ()
    permissions: frozenset[str] = frozenset()
    deviations: tuple[KnownDeviation, ...] = ()


class _Table:
    """One table of the file: keys are read one by one, and what is left over is a typo."""

    def __init__(self, file: "_File", name: str, values: object, position: int = 0) -> None:
        self._file = file
        self._name = name
        self._position = position
        self._known: list[str] = []
        if not isinstance(values, dict):
            raise file.error(f"{name} has to be a table: write [{name}].", "", name)
        self._values: Mapping[str, Any] = values

    def read(self, key: str, convert: Callable[[Any], Read], wanted: str, missing: Read) -> Read:
        """Return what stands behind a key; ``convert`` raises ValueError for what is wrong."""
        self._known.append(key)
        if key not in self._values:
            return missing
        value = self._values[key]
        try:
            return convert(value)
        except ObjectNameError as error:
            raise self._error(key, str(error)) from None
        except (ValueError, TypeError):
            raise self._error(key, f"{key} = {shortened(str(value))}: {wanted}.") from None

    def finish(self) -> None:
        """Raise FileError for a key that nobody has read."""
        for key in self._values:
            if key not in self._known:
                where = f" in [{self._name}]" if self._name else ""
                raise self._error(
                    key,
                    f"there is no key {shortened(key)}{where}. {did_you_mean(key, self._known)}",
                )

    def _error(self, key: str, sentence: str) -> FileError:
        return self._file.error(sentence, self._name, key, self._position)


@dataclass(frozen=True, slots=True)
class _File:
    path: Path
    text: str

    def error(self, sentence: str, table: str, key: str, position: int = 0) -> FileError:
        """Build an error with the line of a key, as far as it can be found."""
        return FileError(self.path, self._line(table, key, position), sentence)

    def _line(self, table: str, key: str, position: int) -> int | None:
        """Look for a key in its table, the ``position``-th of that name; tomllib keeps no lines."""
        header = re.compile(r"\s*\[\[?\s*([^\]]*?)\s*\]")
        written = re.compile(rf"\s*([\"']?){re.escape(key)}\1\s*[=.]")
        # A table may also be written in a line, or by keys with a dot.
        inline = re.compile(rf"\s*{re.escape(table)}\s*[=.]")
        current, seen, found = "", -1, None
        for number, line in enumerate(self.text.split("\n"), 1):
            if match := header.match(line):
                current = match[1].strip("\"'")
                seen += current == table
                if current in (table, key) and seen in (position, -1):
                    found = found or number
            elif current == table and max(seen, 0) == position and written.match(line):
                return number
            elif not current and table and inline.match(line):
                found = found or number
        return found


def read_description(path: Path) -> Description:
    """Read a device.toml; raises FileError with the line and the nearest known key."""
    text = read_text(path, limit=LARGEST, encodings=("utf-8-sig",))
    file = _File(path, text)
    top = _Table(file, "", _parsed(path, text))
    can = _Table(file, "can", top.read("can", _any, "", {}))
    objects = _Table(file, "objects", top.read("objects", _any, "", {}))
    timing = _Table(file, "timing", top.read("timing", _any, "", {}))
    process = _Table(file, "process", top.read("process", _any, "", {}))
    folder = path.parent
    description = Description(
        folder=folder,
        node_id=top.read("node-id", _node_id, f"node-IDs go from 1 to {HIGHEST_NODE_ID}", None),
        eds=top.read("eds", lambda name: folder / _text(name), "write the name of a file", None),
        interface=can.read("interface", _text, 'write a name, as in "socketcan"', None),
        channel=can.read("channel", _text, 'write a name, as in "can0"', None),
        bitrate=can.read("bitrate", _count, "write a number of bit/s, as in 500000", None),
        writable=objects.read("writable", _objects, _WRITABLE, ()),
        all_rw=objects.read("writable", _has_all_rw, "", False),
        large=objects.read("large", _object, 'write an object, as in "2020=domain"', None),
        never=objects.read("never", _multiplexers, 'write a list, as in ["2100"]', frozenset()),
        at_defaults=objects.read("at-defaults", _flag, "write true or false", False),
        response=timing.read("response", _seconds, _TIME, None),
        server_timeout=timing.read("server-timeout", _seconds, _TIME, None),
        command=process.read("command", _command, 'write a list, as in ["./my_server"]', ()),
        recover=process.read("recover", _command, 'write a command, as in "./cycle.sh"', ()),
        permissions=_permissions(file, top),
        deviations=_deviations(file, top),
    )
    for table in (can, objects, timing, process, top):
        table.finish()
    return description


_TIME = "write seconds, as in 0.5"
_WRITABLE = f'write a list, as in ["2001", "2010:01=unsigned16"], or "{ALL_RW}"'


def _parsed(path: Path, text: str) -> dict[str, Any]:
    for number, line in enumerate(text.split("\n"), 1):
        if len(line) > LONGEST_LINE:
            raise FileError(path, number, f"a line of {len(line)} characters: break it.")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        what, _, where = str(error).partition(" (at ")
        match = re.match(r"line (\d+)", where)
        last = int(match[1]) if match else text.count("\n") + 1
        raise FileError(path, last, f"no TOML: {what}.") from None
    except (ValueError, RecursionError) as error:
        # Numbers of thousands of digits, arrays in arrays in arrays.
        deep = isinstance(error, RecursionError)
        what = "values lie too deep in each other" if deep else str(error)
        raise FileError(path, None, f"no TOML: {what}.") from None


def _permissions(file: _File, top: _Table) -> frozenset[str]:
    """Return the names in a list, or those that are true in a table."""
    value: Any = top.read("permissions", _any, "", [])
    if isinstance(value, dict):
        table = _Table(file, "permissions", value)
        names = sorted(PERMISSIONS)
        given = {name for name in names if table.read(name, _flag, "write true or false", False)}
        table.finish()
        return frozenset(given)
    names = value if isinstance(value, list) else [value]
    for name in names:
        if not isinstance(name, str) or name not in PERMISSIONS:
            raise file.error(
                f"there is no permission {shortened(str(name))}. "
                f"{did_you_mean(str(name), sorted(PERMISSIONS))}",
                "",
                "permissions",
            )
    return frozenset(names)


def _deviations(file: _File, top: _Table) -> tuple[KnownDeviation, ...]:
    value: Any = top.read("deviations", _any, "", [])
    if not isinstance(value, list):
        raise file.error("write [[deviations]], in double brackets.", "", "deviations")
    found = []
    for position, entry in enumerate(value):
        table = _Table(file, "deviations", entry, position)
        wanted = "write a text that is not empty"
        case = table.read("case", _text, wanted, "")
        reason = table.read("reason", _text, wanted, "")
        table.finish()
        if not case or not reason:
            raise file.error(
                "a deviation needs a case and a reason, which says why it is excused.",
                "deviations",
                "case" if case else "reason",
                position,
            )
        found.append(KnownDeviation(case, reason))
    return tuple(found)


# Converters: each raises ValueError or TypeError for a value that is not as it should be


def _any(value: object) -> Any:
    return value


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise TypeError
    return value


def _text(value: object) -> str:
    if not isinstance(value, str) or not value.strip() or "\0" in value:
        raise ValueError
    return value


def _count(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ValueError
    return value


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
    return parse_object(_text(value))


def _listed(value: object) -> Iterable[object]:
    if not isinstance(value, list):
        raise TypeError
    return value


def _objects(value: object) -> tuple[KnownObject, ...]:
    if value == ALL_RW:
        return ()
    return tuple(_object(one) for one in _listed(value) if one != ALL_RW)


def _has_all_rw(value: object) -> bool:
    return value == ALL_RW or (isinstance(value, list) and ALL_RW in value)


def _multiplexers(value: object) -> frozenset[Multiplexer]:
    """Return what is listed; without a sub-index an object is meant with all of them."""
    found: set[Multiplexer] = set()
    for one in _listed(value):
        index = _object(one).mux.index
        whole = ":" not in _text(one)
        found |= {Multiplexer(index, sub) for sub in range(256)} if whole else {_object(one).mux}
    return frozenset(found)


def _command(value: object) -> tuple[str, ...]:
    if isinstance(value, str):
        return (_text(value),)
    words = tuple(_text(one) for one in _listed(value))
    if not words:
        raise ValueError
    return words
