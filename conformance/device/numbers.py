"""Numbers of a data type as bytes on the wire and back (CiA 301, 7.1)."""

import struct

from conformance.sdo.objects import DataType

Number = int | float
_FLOATS = {DataType.REAL32: "<f", DataType.REAL64: "<d"}


def is_number(data_type: DataType | None) -> bool:
    """Whether values of the type are numbers, which can be compared with limits."""
    return data_type is not None and (
        data_type in _FLOATS or data_type is DataType.BOOLEAN or _is_integer(data_type)
    )


def encode_number(data_type: DataType, value: Number) -> bytes:
    """Return the bytes of a number; raises OverflowError when the type does not hold it."""
    if data_type in _FLOATS:
        return struct.pack(_FLOATS[data_type], float(value))
    length = data_type.length
    if length is None or not isinstance(value, int):
        raise OverflowError(f"{value} is no {data_type.name}")
    low, high = bounds(data_type)
    if _is_signed(data_type) and high < value < 1 << 8 * length:
        value -= 1 << 8 * length  # files write negative numbers as FFh, too
    if not low <= value <= high:
        raise OverflowError(f"{data_type.name} goes from {low} to {high}")
    return value.to_bytes(length, "little", signed=_is_signed(data_type))


def decode_number(data_type: DataType, data: bytes) -> Number:
    """Return the number that the bytes of a value stand for; they are as many as the type has."""
    if data_type in _FLOATS:
        return float(struct.unpack(_FLOATS[data_type], data)[0])
    return int.from_bytes(data, "little", signed=_is_signed(data_type))


def bounds(data_type: DataType) -> tuple[int, int]:
    """Return the lowest and the highest number that an integer type holds."""
    bits = 8 * (data_type.length or 0)
    if _is_signed(data_type):
        return -(1 << bits - 1), (1 << bits - 1) - 1
    return 0, (1 << bits) - 1


def beyond(data_type: DataType, limit: Number, direction: int) -> bytes | None:
    """Return a value just above (1) or below (-1) a limit; None where the type holds none."""
    step = max(1.0, abs(limit)) if data_type in _FLOATS else 1
    value = limit + direction * step
    if data_type not in _FLOATS:
        low, high = bounds(data_type)
        if not low <= value <= high:
            return None
    try:
        return encode_number(data_type, value)
    except OverflowError:
        return None


def _is_integer(data_type: DataType) -> bool:
    return data_type.name.startswith(("INTEGER", "UNSIGNED"))


def _is_signed(data_type: DataType) -> bool:
    return data_type.name.startswith("INTEGER")
