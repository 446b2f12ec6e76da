"""The worth of cases: the known faults that each catches, and its requests.

The table is made by ``tests/faults/worth.py``, and has its own order: first the case with the most
faults per request that no case before it catches, and so on; then the same for a second case that
catches each fault, and so on. A run begins with a tenth of its requests in this order.
"""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from conformance.device.effort import REQUESTS_IN_HASTE, REQUESTS_OF_SMALL_CASE
from conformance.run.risks import Kind

# Any client may send these; a server may never have received frames of other kinds.
FAMILIAR = (Kind.ORDINARY, Kind.LOST_SEGMENT)
# The key by which the cases of a device are sorted.
Place = tuple[bool, Kind, int]
FIRST: Place = (False, Kind.ORDINARY, 0)
_PATH = Path(__file__).with_suffix(".json")


@dataclass(frozen=True, slots=True)
class Worth:
    """The ``faults`` that a case catches, by name, and the ``requests`` that it sends.

    ``place`` is its number in the order; the first cases are ``early``. A case that ``writes``
    needs an object that may be written. The ``quick`` cases catch most together within the
    requests of a quick run.
    """

    place: int
    early: bool
    requests: int
    writes: bool
    quick: bool
    faults: frozenset[str]


@cache
def _read() -> dict[str, Any]:
    """Return what is kept.

    ``beside`` are the requests of a quick run that belong to no case, such as those of the
    discovery; ``early`` are those of the early cases in a whole run.
    """
    found: dict[str, Any] = json.loads(_PATH.read_text(encoding="utf-8"))
    return found


def forget() -> None:
    """Read the table anew when it is asked for: it was made again."""
    _read.cache_clear()
    table.cache_clear()


@cache
def table() -> dict[str, Worth]:
    """Return the cases by their ids, in their order."""
    found = _read()
    names = found["faults"]
    cases = {}
    for place, (case, row) in enumerate(found["cases"].items()):
        requests, writes, quick, early, faults = row
        caught = frozenset(names[number] for number in faults)
        cases[case] = Worth(place, bool(early), requests, bool(writes), bool(quick), caught)
    return cases


def place_in_run(case_id: str, risk: Kind) -> Place:
    """Return the key by which a case is sorted; ``risk`` is the kind of its riskiest frame.

    Early cases come first, unless they send frames that no client sends. Among the early and among
    the other cases, the risky ones come last. Cases without an entry keep the order of the files.
    """
    worth = table().get(case_id)
    late = worth is None or not worth.early or risk not in FAMILIAR
    return late, risk, len(table()) if worth is None else worth.place


def quick_choice(services: dict[str, str], *, writes: bool) -> set[str]:
    """Choose the cases of a quick run, from those of a device.

    ``services`` says what each case is about: each has a case if one of few requests is known.
    Where nothing may be written, ``writes`` is False, and others take the places of cases that do.
    """
    usable = {
        case: worth
        for case, worth in table().items()
        if case in services and (writes or not worth.writes)
    }
    taken: set[str] = set()
    caught: set[str] = set()
    left = REQUESTS_IN_HASTE - _read()["beside"]
    for case, worth in sorted(usable.items(), key=lambda item: not item[1].quick):
        if worth.requests <= left and (worth.quick or not worth.faults <= caught):
            taken.add(case)
            caught |= worth.faults
            left -= worth.requests
    present = {services[case] for case in taken}
    cheapest: dict[str, str] = {}
    for case in sorted(usable, key=lambda case: usable[case].requests):
        if usable[case].requests <= REQUESTS_OF_SMALL_CASE and services[case] not in present:
            cheapest.setdefault(services[case], case)
    return taken | set(cheapest.values())
