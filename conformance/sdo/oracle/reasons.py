"""Why a server may refuse a transfer, or has to: existence, access, size, value (7.2.4.3.17)."""

from collections.abc import Iterable
from dataclasses import dataclass

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import TEXT_TYPES, Access, DataType, Entry
from conformance.sdo.oracle.answers import Codes, DueAbort
from conformance.sdo.oracle.knowledge import Facts, Presence
from conformance.sdo.rules import (
    MISSING_REFUSED,
    NOT_REFUSED,
    Rule,
    accepted,
    block_download,
    idle,
    segmented_download,
    sizes,
)
from conformance.sdo.rules import download_initiates as initiates


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a transfer may be refused.

    ``only`` and ``tolerate`` are as in the refusal. ``binding``: it has to be refused, at once or,
    where ``late``, at its end at the latest.
    """

    rule: Rule
    only: Codes | None = None
    tolerate: Codes | None = None
    binding: bool = True
    late: bool = False

    def refusal(self, mux: Multiplexer) -> DueAbort:
        """Return the abort that is due for this reason."""
        return DueAbort(self.rule, (mux,), self.only, self.tolerate)


Reasons = tuple[Reason, ...]
# There may be no room for what is sent of a value of any length.
TOO_FULL: Reasons = (Reason(sizes.VARIABLE_LENGTH, accepted.NO_ROOM, binding=False, late=True),)


def must_refuse_now(reasons: Iterable[Reason]) -> bool:
    """Say whether a positive answer to an initiate is out of the question."""
    return any(reason.binding and not reason.late for reason in reasons)


def must_refuse(reasons: Iterable[Reason]) -> bool:
    """Say whether a transfer must not be completed."""
    return any(reason.binding for reason in reasons)


def presence_reasons(facts: Facts, codes: Codes) -> Iterable[Reason]:
    """Yield why an initiate is refused: there is no such object, or nothing is known of it.

    ``codes`` are those of a refusal then.
    """
    if facts.presence is Presence.NO_OBJECT:
        yield Reason(MISSING_REFUSED)
    elif facts.presence is Presence.NO_SUB_INDEX:
        yield Reason(idle.SUB_INDEX_MISSING)
    elif facts.presence is Presence.FORBIDDEN:
        # The object may be missing as well, or may not be had in the present state.
        yield Reason(idle.SUB_INDEX_MISSING, accepted.ABOUT_OBJECTS)
    elif facts.presence is Presence.OPEN:
        yield Reason(NOT_REFUSED, codes, binding=False, late=True)


def read_reasons(facts: Facts, value: bytes | None) -> Reasons:
    """Return why an upload is refused."""
    reasons = list(presence_reasons(facts, accepted.OF_UNKNOWN_READ))
    if facts.access is Access.WO:
        reasons.append(Reason(idle.WRITE_ONLY))
    if facts.varies and not value:
        # The general error says as much of an empty entry, which this need not be.
        reasons.append(Reason(idle.NO_DATA, (AbortCode.NO_DATA,), binding=False))
    return tuple(reasons)


def write_reasons(facts: Facts) -> Reasons:
    """Return why a download is refused whatever it carries; the access may be checked late."""
    reasons = list(presence_reasons(facts, accepted.OF_UNKNOWN_WRITTEN))
    if facts.access in (Access.RO, Access.CONST):
        reasons.append(Reason(facts.read_only, late=True))
    return tuple(reasons)


def announced_reasons(facts: Facts, size: int | None, *, block: bool) -> Reasons:
    """Return why a download is refused for the size that its initiate announces."""
    if size is None:
        return ()
    length = facts.length
    if length is None:
        return _variable_reasons(facts, size, block=block)
    if size == length:
        return ()
    if block:
        codes = accepted.TOO_LONG if size > length else accepted.TOO_SHORT
        return (Reason(initiates.BLOCK_NUMBER_LENGTH, codes, accepted.GENERAL, late=True),)
    too_short = initiates.NUMBER_TOO_SHORT if size else initiates.NUMBER_EMPTY
    return (Reason(initiates.NUMBER_TOO_LONG if size > length else too_short, late=True),)


def _variable_reasons(facts: Facts, size: int, *, block: bool) -> Reasons:
    reasons = []
    if size == 0:
        empty = block_download.EMPTY if block else segmented_download.EMPTY
        reasons.append(Reason(empty, binding=False, late=True))
    if facts.capacity is None:
        reasons.append(Reason(sizes.VARIABLE_LENGTH, binding=False, late=True))
    elif size > facts.capacity:
        reasons += TOO_FULL
    elif facts.data_type not in TEXT_TYPES:
        # What takes n + 1 bytes need not take n.
        codes = accepted.WRONG_LENGTH
        reasons.append(Reason(sizes.VARIABLE_LENGTH, codes, binding=False, late=True))
    if facts.data_type is DataType.UNICODE_STRING and size % 2:
        reasons.append(Reason(sizes.UNICODE, binding=False, late=True))
    return tuple(reasons)


def excess_reasons(facts: Facts, announced: int | None, count: int, too_many: Rule) -> Reasons:
    """Return why ``count`` bytes are too many: more than announced, or than there is room for."""
    length = facts.length
    if announced is not None and count > announced:
        return (Reason(too_many, accepted.TOO_LONG, accepted.GENERAL, late=True),)
    if length is not None and count > length:
        return (Reason(too_many, accepted.TOO_LONG, accepted.GENERAL, late=True),)
    if length is None and (facts.capacity is None or count > facts.capacity):
        return TOO_FULL
    return ()


def distinct(reasons: Iterable[Reason]) -> Reasons:
    """Leave out what is there already. They are few, and soon compared; hashed they are not."""
    found: list[Reason] = []
    for reason in reasons:
        if reason not in found:
            found.append(reason)
    return tuple(found)


def final_reasons(
    facts: Facts, announced: int | None, data: bytes, too_few: Rule, *, block: bool
) -> Reasons:
    """Return why a download of these bytes, now complete, is refused."""
    count = len(data)
    reasons: Reasons = ()
    if count < (announced or 0) or count < (facts.length or 0):
        reasons += (Reason(too_few, accepted.TOO_SHORT),)
    if facts.varies:
        reasons += _variable_reasons(facts, count, block=block)
    return reasons + value_reasons(facts, data)


def value_reasons(facts: Facts, data: bytes) -> Reasons:
    """Return why a value is refused: its limits (CiA 306-1), or what only the device knows."""
    if facts.data_type is not None and facts.length == len(data):
        number = Entry(data, facts.data_type).number(data)
        too_high = facts.high is not None and number > facts.high
        too_low = facts.low is not None and number < facts.low
        if too_high or too_low:
            return (Reason(initiates.LIMITS),)
        if facts.takes is not None and data not in facts.takes:
            return (Reason(facts.takes_by),)
    if facts.any_value and not (facts.data_type is DataType.BOOLEAN and max(data, default=0) > 1):
        return ()
    return (Reason(NOT_REFUSED, accepted.OF_ITS_OWN, binding=False),)
