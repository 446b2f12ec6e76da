"""Which of very many listed objects are tried first, and which a run may have to leave out.

What a server gets wrong with one object it gets wrong with others of the kind, mostly. So the first
are of all kinds, from all parts of the dictionary.
"""

from collections import Counter
from collections.abc import Mapping

from conformance.device.eds_listing import ListedObject
from conformance.device.known_objects import KnownObject
from conformance.sdo.layout import Multiplexer

# So many objects each case is tried on, whatever that costs.
ENOUGH = 100


def further(chosen: Mapping[str, object]) -> dict[str, int]:
    """Return what is beyond the first of the objects that were chosen for a case, by its labels.

    They are counted from 1, in the order in which they are tried.

    >>> chosen = {str(place): Multiplexer(0x2000 + place) for place in range(ENOUGH + 1)}
    >>> further(chosen)
    {'100': 1}
    """
    return {label: place for place, label in enumerate(in_turn(chosen)[ENOUGH:], start=1)}


def in_turn(chosen: Mapping[str, object]) -> list[str]:
    """Return the labels of objects, those of all kinds in turn if they are very many."""
    if len(chosen) <= ENOUGH:
        return list(chosen)
    of_kind = Counter[object]()
    turns: dict[str, int] = {}
    for label, value in chosen.items():
        kind = _kind(value)
        turns[label] = of_kind[kind]
        of_kind[kind] += 1
    return sorted(turns, key=lambda label: turns[label])


def _kind(value: object) -> object:
    match value:
        case KnownObject():
            return _part(value.mux.index), value.data_type, value.access, value.is_limited
        case ListedObject():
            return _part(value.index), value.object_type, value.type_code
        case Multiplexer():
            return _part(value.index)
        case _:
            return None


def _part(index: int) -> int:
    return index >> 8
