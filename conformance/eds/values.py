"""Numbers and values as descriptions write them, and as the makers of tools do (clause 6.3)."""

import math
import re
import struct
from dataclasses import dataclass
from functools import lru_cache

from conformance.device.files import shortened
from conformance.device.numbers import Number, bounds, decode_number, encode_number, is_number
from conformance.eds import rules
from conformance.eds.findings import EdsRule
from conformance.sdo.objects import DataType

_REALS = {DataType.REAL32: "<I", DataType.REAL64: "<Q"}
_TERM = re.compile(
    r"(?P<sign>[+-]?)(?:(?P<node>\$?NODEID)|(?P<hex>0X[0-9A-F]+|[0-9][0-9A-F]*H(?![0-9A-F]))"
    r"|(?P<digits>[0-9]+))(?P<suffix>[UL]{0,3})"
)
_FRACTION = re.compile(r"[+-]?[0-9]+[.,][0-9]*(?:E[+-]?[0-9]{1,2})?")
_MOST_TERMS = 4
_LONGEST = 60


@dataclass(frozen=True, slots=True)
class Written:
    """A number of a file.

    ``is_pattern``: it is hexadecimal, so for a signed type the bits of a value. ``odd`` says in
    what it is not written as CiA 306-1 has it.
    """

    number: int
    is_pattern: bool = False
    odd: str = ""


@dataclass(frozen=True, slots=True)
class Reading:
    """A value of a file as the bytes of its type, and what is wrong with it by which rule.

    ``data`` of None cannot be read.
    """

    data: bytes | None
    rule: EdsRule | None = None
    wrong: str = ""


def parse_number(text: str, node_id: int) -> Written | None:
    """Return a number; None for what is none. A formula is for the node of this ID.

    >>> parse_number("$NODEID+0x600", 5).number == 0x605
    True
    """
    return _parsed(text, node_id) if len(text) <= _LONGEST else None


def _parse(text: str, node_id: int) -> Written | None:
    compact = "".join(text.split()).upper()
    if _FRACTION.fullmatch(compact):
        value = float(compact.replace(",", "."))
        return Written(int(value), odd="a fraction") if value.is_integer() else None
    inner_sign = "0X-" in compact  # as canopen's exporter writes negative numbers
    compact = compact.replace("0X-", "-0X")
    terms: list[re.Match[str]] = []
    end = 0
    while end < len(compact):
        term = _TERM.match(compact, end)
        if term is None or (terms and not term["sign"]) or len(terms) == _MOST_TERMS:
            return None
        terms.append(term)
        end = term.end()
    if not terms:
        return None
    total, odd = 0, "a sign behind 0x" if inner_sign else ""
    for term in terms:
        number, why = _term(term, node_id)
        total += -number if term["sign"] == "-" else number
        odd = odd or why
    is_formula = any(term["node"] for term in terms)
    if is_formula and not (terms[0]["node"] and all(term["sign"] != "-" for term in terms)):
        odd = odd or "a formula that is no $NODEID+number"
    if not is_formula and len(terms) > 1:
        odd = odd or "a sum"
    return Written(total, any(term["hex"] for term in terms) and total >= 0, odd)


def _term(term: re.Match[str], node_id: int) -> tuple[int, str]:
    """Return a term, and in what it is not written as CiA 306-1 has it."""
    odd = f"a suffix {term['suffix']}" if term["suffix"] else ""
    if term["node"]:
        return node_id, odd or ("" if term["node"].startswith("$") else "NODEID without $")
    if term["hex"]:
        if term["hex"].startswith("0X"):
            return int(term["hex"], 16), odd
        return int(term["hex"][:-1], 16), "an h in the place of 0x"
    digits = term["digits"]
    if len(digits) > 1 and digits.startswith("0"):
        if set(digits) <= set("01234567"):
            return int(digits, 8), odd
        return int(digits), "8 or 9 in an octal number"
    return int(digits), odd


# The same few numbers stand in all objects.
_parsed = lru_cache(maxsize=4096)(_parse)


def read_value(data_type: DataType, text: str, node_id: int) -> Reading:
    """Return a value of a type."""
    if data_type in _REALS:
        return _read_real(data_type, text)
    if data_type.length is not None:
        return _read_integer(data_type, text, node_id)
    if data_type is DataType.UNICODE_STRING:
        return Reading(text.encode("utf-16-le", "replace"))
    if data_type is DataType.VISIBLE_STRING:
        if text.isascii():
            return Reading(text.encode("ascii"))
        return Reading(
            None, rules.VALUE_TYPE, "is no VISIBLE_STRING: its characters are 20h to 7Eh"
        )
    try:
        return Reading(bytes.fromhex(text.removeprefix("0x").removeprefix("0X")))
    except ValueError:
        if data_type is DataType.DOMAIN:
            return Reading(None)  # what a domain holds, no file says
        return Reading(None, rules.VALUE_TYPE, "is no OCTET_STRING: write bytes as 0A1B2C")


def _read_integer(data_type: DataType, text: str, node_id: int) -> Reading:
    if data_type is DataType.BOOLEAN and text.lower() in ("true", "false"):
        data = bytes([text.lower() == "true"])
        return Reading(data, rules.NUMBER_STYLE, "is a word, and no 0 or 1")
    written = parse_number(text, node_id)
    if written is None:
        return Reading(None, rules.NUMBER, f"is no {data_type.name}")
    low, high = bounds(data_type) if data_type is not DataType.BOOLEAN else (0, 1)
    number, size = written.number, 1 << 8 * (data_type.length or 0)
    if low < 0 and high < number < size:
        if not written.is_pattern:
            data = encode_number(data_type, number - size)
            return Reading(data, rules.SIGN, f"is above the highest {data_type.name}, {high}")
        number -= size
    elif low == 0 and high > 1 and -size // 2 <= number < 0:
        data = encode_number(data_type, number + size)
        return Reading(data, rules.SIGN, f"is negative, and {data_type.name} has no sign")
    if not low <= number <= high:
        wrong = f"is no {data_type.name}, which goes from {low} to {high}"
        return Reading(None, rules.VALUE_TYPE, wrong)
    data = encode_number(data_type, number)
    if written.odd:
        return Reading(data, rules.NUMBER_STYLE, f"is written with {written.odd}")
    return Reading(data)


def _read_real(data_type: DataType, text: str) -> Reading:
    compact = "".join(text.split()).lower()
    wrong = ""
    if re.fullmatch(r"0x[0-9a-f]{1,16}", compact):
        number = int(compact, 16)
        if number < 1 << 8 * (data_type.length or 0):
            data = struct.pack(_REALS[data_type], number)
            wrong = f"is hexadecimal, the bits of a {data_type.name}" if number else ""
            return Reading(data, rules.NUMBER_STYLE if wrong else None, wrong)
    if compact.endswith(("f", "l")) and not compact.endswith("inf"):
        compact, wrong = compact[:-1], "is written with a suffix"
    if "," in compact:
        compact, wrong = compact.replace(",", ".", 1), "is written with a comma"
    try:
        value = float(compact.replace("_", "?"))
        if math.isnan(value):
            raise ValueError
        data = encode_number(data_type, value)
    except ValueError:
        return Reading(None, rules.NUMBER, f"is no {data_type.name}")
    except OverflowError:
        return Reading(None, rules.VALUE_TYPE, f"is beyond what a {data_type.name} holds")
    if math.isinf(value):
        return Reading(None, rules.VALUE_TYPE, "is infinite")
    return Reading(data, rules.NUMBER_STYLE if wrong else None, wrong)


def number_of(data_type: DataType | None, data: bytes | None) -> Number | None:
    """Return the number that a value stands for; None where there is none, or of other types."""
    if data is None or data_type is None or not is_number(data_type):
        return None
    return decode_number(data_type, data)


def quoted(key: str, text: str) -> str:
    """Return a keyword and its value as they stand in a sentence."""
    return f"{key}={shortened(text)[1:-1]}"
