"""Plain values as one text and back: what is read is data only, never code.

JSON has no tuples and no keys but texts, so both are marked. It is a third of the work that execnet
has with them, value by value. pickle would be a quarter of this, and would run what a worker on
another machine puts in.
"""

import json
from typing import Any

_TUPLE, _PAIRS = "()", "{}"


def pack(values: object) -> str:
    """Return plain values as a text; raises TypeError for any others."""
    return _ENCODER.encode(_marked(values))


def unpack(text: str) -> Any:
    """Return what ``pack`` was given; raises ValueError or TypeError for another text."""
    return _DECODER.decode(text)


def _marked(value: object) -> object:
    if value is None or isinstance(value, str | int | float):
        return value
    if type(value) is list:
        return [_marked(each) for each in value]
    if type(value) is tuple:
        return {_TUPLE: [_marked(each) for each in value]}
    if type(value) is not dict:
        raise TypeError(f"no plain value: {value!r}")
    if _TUPLE in value or _PAIRS in value or not all(type(key) is str for key in value):
        return {_PAIRS: [[_marked(key), _marked(each)] for key, each in value.items()]}
    return {key: _marked(each) for key, each in value.items()}


def _unmarked(found: dict[str, Any]) -> object:
    if len(found) == 1:
        if _TUPLE in found:
            return tuple(found[_TUPLE])
        if _PAIRS in found:
            return dict(found[_PAIRS])
    return found


_ENCODER = json.JSONEncoder(check_circular=False)
_DECODER = json.JSONDecoder(object_hook=_unmarked)
