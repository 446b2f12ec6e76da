"""``device.toml``, which describes a device once; and the value of each option of a run."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from conformance.device.options import OPTIONS, Option
from conformance.device.toml_tables import TomlFile

Value = TypeVar("Value")


@dataclass(frozen=True, slots=True)
class Description:
    """The options that a device.toml in this ``folder`` gives."""

    folder: Path = Path()
    values: Mapping[Option[Any], Any] = field(default_factory=dict)

    def __getitem__(self, option: Option[Value]) -> Value:
        """Return the value of an option, or its default."""
        value: Value = self.values.get(option, option.default)
        return value


def read_description(path: Path) -> Description:
    """Read a device.toml; raises FileError with the line and the nearest known key.

    Paths are relative to it.
    """
    top = TomlFile.read(path).top()
    described = [(option, *option.key.rpartition(".")[::2]) for option in OPTIONS if option.key]
    tables = {name: top.inner(name) for _, name, _ in described if name} | {"": top}
    values: dict[Option[Any], Any] = {}
    for option, name, key in described:
        value = option.kind.read_key(tables[name], key)
        if value is not None:
            values[option] = path.parent / value if isinstance(value, Path) else value
    for table in tables.values():
        table.finish()
    return Description(path.parent, values)


@dataclass(frozen=True, slots=True)
class Given:
    """The options of a run: ``named`` in arguments, else in the ``description``, else by default.

    ``named`` takes the destination of an option, and returns None where no argument names it.
    Arguments are relative to ``folder``.
    """

    named: Callable[[str], Any]
    folder: Path
    description: Description = field(default_factory=Description)

    def __getitem__(self, option: Option[Value]) -> Value:
        """Return the value of an option."""
        named = self.argument(option)
        value: Any = self.description[option] if named is None else named
        if isinstance(value, Path):
            value = self.folder / value
        given: Value = value
        return given

    def argument(self, option: Option[Value]) -> Value | None:
        """Return the value in the arguments, None if there is none."""
        value: Any = self.named(option.destination) if option.name else None
        if isinstance(value, list) and option.is_repeated:
            value = tuple(value)
        return None if value is False else value
