"""Guards: the conditions under which a guarded fault shows, as data."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from functools import cache, partial

from conformance.faults.situation import Ended, Situation
from conformance.sdo.nmt import NmtState
from conformance.sdo.objects import DataType

OBJECTS = (0x1008, 0x1017, 0x1018, 0x2004, 0x2010, 0x2011)
PLACES = (127, 255, 889, 65_535)
FIRST_OF_MANY = 101
ENDS = {
    "client-abort": (Ended.BY_CLIENT, "an abort of the client"),
    "server-abort": (Ended.BY_SERVER, "an abort of the server"),
    "time-out": (Ended.BY_TIME_OUT, "a time-out"),
}


class Factor(StrEnum):
    """The subject of a condition."""

    STATE = "NMT state"
    CHANNEL = "channel"
    TYPE = "data type"
    OBJECT = "object"
    SUB_INDEX = "sub-index"
    PLACE = "place in the transfer"
    SUB_BLOCK = "sub-block"
    SIZE = "indication of the size"
    BEFORE = "the transfer before"
    COUNT = "number of transfers"
    REFUSAL = "refusal"


@dataclass(frozen=True, slots=True)
class Guard:
    """A condition under which a fault shows; ``sentence`` follows "Only"."""

    factor: Factor
    name: str
    sentence: str
    holds: Callable[[Situation], bool]


@cache
def guards() -> dict[str, Guard]:
    """Return all guards by name."""
    return {guard.name: guard for guard in _guards()}


def _guards() -> Iterator[Guard]:
    yield Guard(Factor.STATE, "operational", "in NMT state Operational", _operational)
    yield Guard(Factor.CHANNEL, "further-channel", "on a further channel", _further_channel)
    for each in DataType:
        name = each.name.lower().replace("_", "-")
        yield Guard(Factor.TYPE, name, f"for type {each.name}", partial(_typed, each))
    for index in OBJECTS:
        yield Guard(Factor.OBJECT, f"{index:04x}h", f"for {index:04X}h", partial(_about, index))
    yield Guard(Factor.SUB_INDEX, "sub-index", "for sub-indices above 00h", _above_0)
    yield Guard(Factor.SUB_INDEX, "last-sub-index", "for the last sub-index", _last_sub_index)
    for place in PLACES:
        behind = f"beyond byte {place:,}"
        yield Guard(Factor.PLACE, f"beyond-{place}", behind, partial(_beyond, place))
    for number, name in ((2, "second"), (3, "third")):
        within = f"in the {name} sub-block"
        yield Guard(Factor.SUB_BLOCK, f"{name}-sub-block", within, partial(_sub_block, number))
    yield Guard(Factor.SIZE, "unsized", "in downloads that do not indicate a size", _unsized)
    for name, (ended, words) in ENDS.items():
        yield Guard(Factor.BEFORE, f"behind-{name}", f"behind {words}", partial(_behind, ended))
    yield Guard(Factor.BEFORE, "behind-other-service", "behind another service", _changed)
    yield Guard(Factor.BEFORE, "behind-stray-segment", "behind a segment of no transfer", _stray)
    many = f"from transfer {FIRST_OF_MANY} on"
    yield Guard(Factor.COUNT, f"from-{FIRST_OF_MANY}th-transfer", many, _many)
    yield Guard(Factor.REFUSAL, "refused", "where a refusal is due", _refused)


def _operational(now: Situation) -> bool:
    return now.node.state is NmtState.OPERATIONAL


def _further_channel(now: Situation) -> bool:
    return now.channel > 0


def _typed(data_type: DataType, now: Situation) -> bool:
    return now.entry is not None and now.entry.data_type is data_type


def _about(index: int, now: Situation) -> bool:
    return now.mux is not None and now.mux.index == index


def _above_0(now: Situation) -> bool:
    return now.mux is not None and now.mux.sub_index > 0


def _last_sub_index(now: Situation) -> bool:
    mux = now.mux
    if mux is None or not mux.sub_index or now.entry is None:
        return False
    siblings = (each for each, _ in now.node.objects.items() if each.index == mux.index)
    return mux == max(siblings)


def _beyond(place: int, now: Situation) -> bool:
    return now.reach > place


def _sub_block(number: int, now: Situation) -> bool:
    return now.past.sub_block == number


def _unsized(now: Situation) -> bool:
    return now.size_unsaid


def _behind(ended: Ended, now: Situation) -> bool:
    return now.past.before is ended


def _changed(now: Situation) -> bool:
    return now.past.service_before not in ("", now.past.service)


def _stray(now: Situation) -> bool:
    return now.past.behind_stray


def _many(now: Situation) -> bool:
    return now.past.transfers >= FIRST_OF_MANY


def _refused(now: Situation) -> bool:
    return now.is_refused
