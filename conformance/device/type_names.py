"""The names that users have for data types: those of CiA 301, and those of their languages."""

import re

from conformance.sdo.nearest import did_you_mean
from conformance.sdo.objects import DataType

_CODE = re.compile(r"0x([0-9a-f]{1,4})|([0-9a-f]{1,4})h|(00[0-9a-f]{2})")
# The rest of "uint8", "uint8_t" and "u8" for an UNSIGNED8, and of "int8" and "i8".
_SIZED = re.compile(r"(?:(?P<unsigned>uint|u)|(?P<signed>sint|int|i|s))(?P<bits>\d{1,2})t?")
# Other names of C, Python, IEC 61131-3 and the tools of the field.
_ALIASES = {
    "bool": DataType.BOOLEAN,
    "byte": DataType.UNSIGNED8,
    "usint": DataType.UNSIGNED8,
    "sint": DataType.INTEGER8,
    "udint": DataType.UNSIGNED32,
    "dint": DataType.INTEGER32,
    "ulint": DataType.UNSIGNED64,
    "lint": DataType.INTEGER64,
    "float": DataType.REAL32,
    "float32": DataType.REAL32,
    "f32": DataType.REAL32,
    "double": DataType.REAL64,
    "float64": DataType.REAL64,
    "f64": DataType.REAL64,
    "lreal": DataType.REAL64,
    "string": DataType.VISIBLE_STRING,
    "vstring": DataType.VISIBLE_STRING,
    "octets": DataType.OCTET_STRING,
    "unicode": DataType.UNICODE_STRING,
}
# Of other lengths in some of these languages than in others.
_UNSIZED = {
    "unsigned": "unsigned8, unsigned16, unsigned32 or unsigned64",
    "integer": "integer8, integer16, integer32 or integer64",
    "real": "real32 or real64",
}
_UNSIZED |= {
    "uint": _UNSIZED["unsigned"],
    "word": _UNSIZED["unsigned"],
    "dword": _UNSIZED["unsigned"],
    "int": _UNSIZED["integer"],
}
_BY_NAME = {data_type.name.lower(): data_type for data_type in DataType}
_PLAIN = {name.replace("_", ""): data_type for name, data_type in _BY_NAME.items()}


class TypeNameError(ValueError):
    """A text names no data type; it says which may have been meant."""


def parse_type(text: str) -> DataType:
    """Return the data type of a name or of a code; raises TypeNameError.

    >>> parse_type("uint16").name, parse_type("0x0009").name
    ('UNSIGNED16', 'VISIBLE_STRING')
    """
    lower = text.lower()
    plain = lower.replace("_", "")
    found = _PLAIN.get(plain) or _ALIASES.get(plain) or _sized(plain) or _coded(lower)
    if found is not None:
        return found
    if plain in _UNSIZED:
        raise TypeNameError(
            f"called {text!r}: its length is not the same everywhere. Write {_UNSIZED[plain]}."
        )
    raise TypeNameError(f"called {text!r}. {did_you_mean(text, _BY_NAME)}")


def _sized(plain: str) -> DataType | None:
    match = _SIZED.fullmatch(plain)
    if match is None:
        return None
    return _PLAIN.get(("unsigned" if match["unsigned"] else "integer") + match["bits"])


def _coded(lower: str) -> DataType | None:
    match = _CODE.fullmatch(lower)
    code = int(match[match.lastindex or 0], 16) if match else 0
    return DataType(code) if code in frozenset(DataType) else None
