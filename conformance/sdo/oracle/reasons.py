"""Why a server may refuse a transfer, or has to: existence, access, size, value (7.2.4.3.17)."""

from collections.abc import Iterable
from dataclasses import dataclass

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import TEXT_TYPES, Access, DataType, Entry
from conformance.sdo.oracle.answers import GENERAL, Codes, Refusal
from conformance.sdo.oracle.knowledge import Facts, Presence
from conformance.sdo.rules import (
    MISSING_REFUSED,
    NOT_REFUSED,
    Rule,
    block_download,
    idle,
    segmented_download,
    sizes,
)
from conformance.sdo.rules import download_initiates as initiates

TOO_LONG: Codes = (AbortCode.LENGTH_TOO_HIGH, AbortCode.LENGTH_MISMATCH)
TOO_SHORT: Codes = (AbortCode.LENGTH_TOO_LOW, AbortCode.LENGTH_MISMATCH)
LENGTHS: Codes = (
    AbortCode.LENGTH_MISMATCH,
    AbortCode.LENGTH_TOO_HIGH,
    AbortCode.LENGTH_TOO_LOW,
)
NO_ROOM: Codes = (*TOO_LONG, AbortCode.OUT_OF_MEMORY, AbortCode.NOT_TRANSFERABLE)
# What a string or domain may say that has, for all that is known, one length only.
ANY_LENGTH: Codes = (*NO_ROOM, AbortCode.LENGTH_TOO_LOW)
EMPTY: Codes = (
    *TOO_SHORT,
    AbortCode.NOT_TRANSFERABLE,
    AbortCode.INTERNALLY_INCOMPATIBLE,
    AbortCode.OUT_OF_MEMORY,
)
VALUE: Codes = (AbortCode.VALUE_INVALID, AbortCode.VALUE_TOO_HIGH, AbortCode.VALUE_TOO_LOW)
# What a device may say about a value that the suite knows nothing against.
NOT_NOW: Codes = (
    *VALUE,
    AbortCode.MAXIMUM_BELOW_MINIMUM,
    AbortCode.PARAMETER_INCOMPATIBLE,
    AbortCode.INTERNALLY_INCOMPATIBLE,
    AbortCode.NOT_MAPPABLE,
    AbortCode.MAPPING_TOO_LONG,
    AbortCode.HARDWARE_ERROR,
    AbortCode.NOT_TRANSFERABLE,
    AbortCode.LOCAL_CONTROL,
    AbortCode.DEVICE_STATE,
)
# What a device may say about an object of which nothing is known.
ABOUT_OBJECTS: Codes = (
    AbortCode.OUT_OF_MEMORY,
    *(code for code in AbortCode if code >= AbortCode.UNSUPPORTED_ACCESS),
)
LARGEST_BLOCK = 127


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a transfer may be refused.

    ``binding``: it has to be, at once or, where ``late``, at its end at the latest. ``tolerated``
    codes are breaches of a SHOULD.
    """

    rule: Rule
    codes: Codes
    binding: bool = True
    late: bool = False
    tolerated: Codes = GENERAL

    def refusal(self, mux: Multiplexer) -> Refusal:
        """Return the abort that is due for this reason."""
        return Refusal(self.rule, self.codes, (mux,), self.tolerated)


Reasons = tuple[Reason, ...]
# There may be no room for what is sent of a value of any length.
TOO_FULL: Reasons = (Reason(initiates.HUGE_SIZE, NO_ROOM, binding=False, late=True),)


def must_refuse_now(reasons: Iterable[Reason]) -> bool:
    """Say whether a positive answer to an initiate is out of the question."""
    return any(reason.binding and not reason.late for reason in reasons)


def must_refuse(reasons: Iterable[Reason]) -> bool:
    """Say whether a transfer must not be completed."""
    return any(reason.binding for reason in reasons)


def presence_reasons(facts: Facts) -> Iterable[Reason]:
    """Yield why an initiate of any service is refused: there is no such object."""
    if facts.presence is Presence.NO_OBJECT:
        yield Reason(MISSING_REFUSED, (AbortCode.OBJECT_MISSING,))
    elif facts.presence is Presence.NO_SUB_INDEX:
        yield Reason(idle.SUB_INDEX_MISSING, (AbortCode.SUB_INDEX_MISSING,))
    elif facts.presence is Presence.OPEN:
        yield Reason(NOT_REFUSED, ABOUT_OBJECTS, binding=False, late=True)


def read_reasons(facts: Facts, value: bytes | None) -> Reasons:
    """Return why an upload is refused."""
    reasons = list(presence_reasons(facts))
    if facts.access is Access.WO:
        reasons.append(
            Reason(idle.WRITE_ONLY, (AbortCode.READ_OF_WRITE_ONLY, AbortCode.UNSUPPORTED_ACCESS))
        )
    if facts.varies and not value:
        reasons.append(Reason(idle.NO_DATA, (AbortCode.NO_DATA,), binding=False))
    return tuple(reasons)


def write_reasons(facts: Facts) -> Reasons:
    """Return why a download is refused whatever it carries; the access may be checked late."""
    reasons = list(presence_reasons(facts))
    if facts.access in (Access.RO, Access.CONST):
        codes = (AbortCode.WRITE_OF_READ_ONLY, AbortCode.UNSUPPORTED_ACCESS)
        reasons.append(Reason(idle.READ_ONLY, codes, late=True))
    return tuple(reasons)


def announced_reasons(facts: Facts, size: int | None, *, block: bool) -> Reasons:
    """Return why a download is refused for the size that its initiate announces."""
    if size is None:
        return ()
    length = facts.length
    if length is None:
        return _variable_reasons(facts, size, block=block)
    if size > length:
        return (
            Reason(
                initiates.BLOCK_NUMBER_LENGTH if block else initiates.NUMBER_TOO_LONG,
                TOO_LONG,
                late=True,
            ),
        )
    if size < length:
        of_segmented = initiates.NUMBER_TOO_SHORT if size else initiates.NUMBER_EMPTY
        rule = initiates.BLOCK_NUMBER_LENGTH if block else of_segmented
        return (Reason(rule, TOO_SHORT, late=True),)
    return ()


def _variable_reasons(facts: Facts, size: int, *, block: bool) -> Reasons:
    reasons = []
    if size == 0:
        reasons.append(
            Reason(
                block_download.EMPTY if block else segmented_download.EMPTY,
                EMPTY,
                binding=False,
                late=True,
            )
        )
    if facts.capacity is None:
        reasons.append(Reason(initiates.HUGE_SIZE, ANY_LENGTH, binding=False, late=True))
    elif size > facts.capacity:
        reasons.append(Reason(initiates.HUGE_SIZE, NO_ROOM, binding=False, late=True))
    elif facts.data_type not in TEXT_TYPES:
        # What takes n + 1 bytes need not take n.
        reasons.append(Reason(initiates.HUGE_SIZE, LENGTHS, binding=False, late=True))
    if facts.data_type is DataType.UNICODE_STRING and size % 2:
        reasons.append(Reason(sizes.UNICODE, LENGTHS, binding=False, late=True))
    return tuple(reasons)


def excess_reasons(facts: Facts, announced: int | None, count: int, too_many: Rule) -> Reasons:
    """Return why so many bytes are too many: more than were announced, or than there is room."""
    length = facts.length
    if announced is not None and count > announced:
        return (Reason(too_many, TOO_LONG, late=True),)
    if length is not None and count > length:
        return (Reason(too_many, TOO_LONG, late=True),)
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
        reasons += (Reason(too_few, TOO_SHORT),)
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
            return (Reason(initiates.LIMITS, VALUE),)
    if facts.any_value and not (facts.data_type is DataType.BOOLEAN and max(data, default=0) > 1):
        return ()
    return (Reason(initiates.LIMITS, NOT_NOW, binding=False),)
