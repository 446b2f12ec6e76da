"""TOML files that users write: read key by key; each error names its line."""

import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from conformance.device.files import FileError, read_text, shortened, shown
from conformance.device.known_objects import ObjectNameError
from conformance.sdo.nearest import did_you_mean

Read = TypeVar("Read")
# A list of known deviations may name thousands of cases.
LARGEST = 1024 * 1024
# The time of tomllib grows with the square of the parts of a key: this square takes a second.
LONGEST_LINE = 4096
MOST_SQUARED_DOTS = 1_000_000


class Table:
    """One table of the file: keys are read one by one; a key that is left over is a typo."""

    def __init__(self, file: "TomlFile", name: str, values: object, position: int = 0) -> None:
        """Raise FileError if ``values`` is no table; it is the ``position``-th of its name."""
        self.file = file
        self._name = name
        self._position = position
        self._known: list[str] = []
        if not isinstance(values, dict):
            raise file.error(f"{name} has to be a table: write [{name}].", "", name)
        self._values: Mapping[str, Any] = values

    def read(self, key: str, convert: Callable[[Any], Read], wanted: str, missing: Read) -> Read:
        """Return the value of a key; ``convert`` raises ValueError for a wrong one."""
        self._known.append(key)
        if key not in self._values:
            return missing
        value = self._values[key]
        try:
            return convert(value)
        except ObjectNameError as error:
            raise self.error(key, str(error)) from None
        except (ValueError, TypeError):
            raise self.error(key, f"{key} = {shown(value)}: {wanted}.") from None

    def inner(self, key: str) -> "Table":
        """Return the table behind a key, an empty one if it is missing."""
        return Table(self.file, key, self.read(key, anything, "", {}))

    def finish(self) -> None:
        """Raise FileError for a key that was not read."""
        for key in self._values:
            if key not in self._known:
                where = f" in [{self._name}]" if self._name else ""
                raise self.error(
                    key,
                    f"there is no key {shortened(key)}{where}. {did_you_mean(key, self._known)}",
                )

    def error(self, key: str, sentence: str) -> FileError:
        """Build an error with the line of a key."""
        return self.file.error(sentence, self._name, key, self._position)


@dataclass(frozen=True, slots=True)
class TomlFile:
    """A file and its text, which finds the lines that tomllib does not keep."""

    path: Path
    text: str

    @classmethod
    def read(cls, path: Path) -> "TomlFile":
        """Read a file; raises FileError."""
        return cls(path, read_text(path, limit=LARGEST))

    def top(self) -> Table:
        """Return the table of the whole file; raises FileError if it is no TOML."""
        return Table(self, "", _parsed(self.path, self.text))

    def error(self, sentence: str, table: str, key: str, position: int = 0) -> FileError:
        """Build an error with the line of a key, as far as it can be found."""
        return FileError(self.path, self._line(table, key, position), sentence)

    def _line(self, table: str, key: str, position: int) -> int | None:
        """Look for a key in its table, the ``position``-th of that name; tomllib keeps no lines."""
        written = re.compile(rf"\s*([\"']?){re.escape(key)}\1\s*[=.]")
        # A table may also be written in a line, or by keys with a dot.
        inline = re.compile(rf"\s*{re.escape(table)}\s*[=.]")
        current, seen, found = "", -1, None
        for number, line in enumerate(self.text.split("\n"), 1):
            if line.lstrip().startswith("[") and "]" in line:
                current = line.strip().lstrip("[").partition("]")[0].strip().strip("\"'")
                seen += current == table
                if current in (table, key) and seen in (position, -1):
                    found = found or number
            elif current == table and max(seen, 0) == position and written.match(line):
                return number
            elif not current and table and inline.match(line):
                found = found or number
        return found


def _parsed(path: Path, text: str) -> dict[str, Any]:
    dots = 0
    for number, line in enumerate(text.split("\n"), 1):
        if len(line) > LONGEST_LINE:
            raise FileError(path, number, f"a line of {len(line)} characters: break it.")
        dots += line.count(".") ** 2
        if dots > MOST_SQUARED_DOTS:
            raise FileError(path, number, "too many keys with dots in them: write [tables].")
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


# Converters: each raises ValueError or TypeError for a wrong value


def anything(value: object) -> Any:
    """Take a value as it is: its reader checks it."""
    return value


def text_of(value: object) -> str:
    """Take a text that is not empty."""
    if not isinstance(value, str) or not value.strip() or "\0" in value:
        raise ValueError
    return value
