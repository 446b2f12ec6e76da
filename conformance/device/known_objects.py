"""The objects of a device as the suite knows them, and how users name them on a command line."""

import re
from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass

from conformance.device.numbers import Number
from conformance.device.type_names import TypeNameError, parse_type
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nearest import did_you_mean
from conformance.sdo.objects import AS_WRITTEN, Access, DataType, Habits

_NAMED = re.compile(
    r"(?:0x)?(?P<index>[0-9a-f]{4})h?(?::(?:0x)?(?P<sub>[0-9a-f]{1,2})h?)?"
    r"(?:=(?P<type>[a-z_0-9]+)(?:,(?P<access>[a-z]+))?)?",
    re.IGNORECASE,
)
# What an object is called that changes who the device is, or what nobody could restore.
_DELICATE = re.compile(
    r"node.?id|baud|bit.?rate|cob.?id|can.?id|passw|firmware|boot|flash|calibrat|reset|serial|unlock"
    r"|program|download|updat|upgrad|eeprom|eras|factory|licen[cs]e|restor|\bstor(?:e|age)\b",
    re.IGNORECASE,
)
# From there on are the objects of device profiles: drives and outputs move when they are written.
FIRST_OF_PROFILE = 0x6000
EXAMPLE = "2001, 2010:01, 2010:01=unsigned16 or 2020=visible_string,rw"


class ObjectNameError(ValueError):
    """An object on the command line that cannot be read."""


@dataclass(frozen=True, slots=True)
class KnownObject:
    """One entry of the device's object dictionary; a type of None is not known.

    The rest is what an EDS says of it: limits, both included; the value after the defaults were
    loaded, and the one that a DCF configures; the ObjFlags; whether it is ``mappable`` to a PDO,
    None where the EDS leaves that out. An entry ``floats`` when the device itself changes it
    (access rwr). Its ``habits`` are what the device was seen to do with it.
    """

    mux: Multiplexer
    data_type: DataType | None = None
    access: Access = Access.RW
    _: KW_ONLY
    name: str = ""
    low: Number | None = None
    high: Number | None = None
    default: bytes | None = None
    configured: bytes | None = None
    flags: int = 0
    mappable: bool | None = None
    floats: bool = False
    habits: Habits = AS_WRITTEN

    @property
    def length(self) -> int | None:
        """The bytes of a value; None when they vary or the type is not known."""
        return self.data_type.length if self.data_type is not None else None

    @property
    def stated(self) -> bytes | None:
        """The value that a DCF configures, else the default; None where neither is stated."""
        return self.default if self.configured is None else self.configured

    @property
    def is_steady(self) -> bool:
        """Whether the value stays until the suite writes it; a ro value may be measured."""
        return self.access in (Access.RW, Access.CONST) and not self.floats

    @property
    def is_limited(self) -> bool:
        """Whether there are limits to what may be written."""
        return self.low is not None or self.high is not None

    @property
    def refuses_download(self) -> bool:
        """Whether the EDS asks tools not to write it (ObjFlags, bit 0)."""
        return bool(self.flags & 1)

    @property
    def refuses_scan(self) -> bool:
        """Whether the EDS asks tools not to read it when they read everything (bit 1)."""
        return bool(self.flags & 2)

    @property
    def varies(self) -> bool:
        """Whether values of different lengths can be written: strings and domains."""
        return self.data_type is not None and self.data_type.length is None

    @property
    def is_delicate(self) -> bool:
        """Whether its name is that of something which decides who the device is, or is lost."""
        return _DELICATE.search(self.name) is not None

    @property
    def may_do_harm(self) -> bool:
        """Whether nobody should be advised to let it be written: by its name, or by its profile."""
        return self.is_delicate or self.mux.index >= FIRST_OF_PROFILE

    @property
    def named(self) -> str:
        """The object as --sdo-object and device.toml name it."""
        if self.data_type is None:
            return name_of(self.mux)
        access = "" if self.access is Access.RW else f",{self.access}"
        return f"{name_of(self.mux)}={self.data_type.name.lower()}{access}"

    @property
    def title(self) -> str:
        """The multiplexer and, where it is known, the name."""
        return f"{self.mux} ({self.name})" if self.name else str(self.mux)

    def __str__(self) -> str:
        return str(self.mux)


def by_multiplexer(objects: Iterable[KnownObject]) -> dict[Multiplexer, KnownObject]:
    """Return objects in a way that each is found at once, in the same order."""
    return {known.mux: known for known in objects}


def name_of(mux: Multiplexer) -> str:
    """Write a multiplexer as users do; one without a sub-index is the first of its object."""
    return f"{mux.index:04X}" + (f":{mux.sub_index:02X}" if mux.sub_index else "")


def parse_object(text: str) -> KnownObject:
    """Read ``INDEX[:SUB][=TYPE[,ACCESS]]``, index and sub-index in hexadecimal.

    >>> str(parse_object("2010:01=unsigned16"))
    '2010h:01'

    Raises ObjectNameError with the nearest known name.
    """
    match = _NAMED.fullmatch(text.strip())
    if match is None:
        raise ObjectNameError(
            f"{text!r} does not name an object: write INDEX[:SUB][=TYPE[,ACCESS]] in hexadecimal, "
            f"for example {EXAMPLE}."
        )
    mux = Multiplexer(int(match["index"], 16), int(match["sub"] or "0", 16))
    try:
        data_type = parse_type(match["type"]) if match["type"] else None
    except TypeNameError as error:
        raise ObjectNameError(f"There is no type in {text!r} {error}") from None
    accesses = {access.value: access for access in Access}
    name = match["access"] or "rw"
    if name.lower() not in accesses:
        raise ObjectNameError(
            f"There is no access in {text!r} called {name!r}. {did_you_mean(name, accesses)}"
        )
    return KnownObject(mux, data_type, accesses[name.lower()])
