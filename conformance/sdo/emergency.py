"""What a node tells of the errors of its application: emergencies and the objects behind them.

The error register (1001h) says what kind of error there is, the error list (1003h) which there
were, the latest first; a node without 1003h keeps none (CiA 301, 7.2.7, 7.5.2.2, 7.5.2.4).
"""

from dataclasses import dataclass

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.channel_parameters import CheckedEntry
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry, ObjectDictionary, Refusal

ERROR_REGISTER = Multiplexer(0x1001)
# Its sub-index 0 counts errors and takes nothing but 0; places beyond that are empty.
ERROR_LIST = 0x1003
# Codes below say that there is no error any more.
FIRST_ERROR = 0x0100
NO_ERROR = bytes(2)
GENERIC = 0x01
# Kinds of error codes, first and last, and the bit of the error register that each of them sets.
KINDS = (
    (0x2000, 0x2FFF, 0x02),  # current
    (0x3000, 0x3FFF, 0x04),  # voltage
    (0x4000, 0x4FFF, 0x08),  # temperature
    (0x8100, 0x82FF, 0x10),  # communication
    (0xFF00, 0xFFFF, 0x80),  # manufacturer-specific
)


def is_error_place(mux: Multiplexer) -> bool:
    """Say whether an entry is a place of the error list, which holds an error or nothing."""
    return mux.index == ERROR_LIST and mux.sub_index > 0


@dataclass(slots=True)
class ErrorCode(Entry):
    """The emergency error code of the application, 0 for none: the node reports its changes."""

    @classmethod
    def none(cls) -> "ErrorCode":
        """Return an UNSIGNED16 that says that there is no error."""
        return cls(NO_ERROR, DataType.UNSIGNED16)


def error_list(places: int) -> dict[Multiplexer, Entry]:
    """Return 1003h, empty, with room for ``places`` errors."""
    entries: dict[Multiplexer, Entry] = {
        Multiplexer(ERROR_LIST): CheckedEntry(bytes(1), DataType.UNSIGNED8, check=_only_none)
    }
    for place in range(1, places + 1):
        entries[Multiplexer(ERROR_LIST, place)] = Entry(
            bytes(4), DataType.UNSIGNED32, Access.RO, has_data=False
        )
    return entries


def _only_none(old: bytes, new: bytes) -> None:
    """Refuse a number of errors other than 0, which clears the list."""
    if any(new):
        raise Refusal(AbortCode.VALUE_INVALID)


def register_of(code: int) -> int:
    """Return what 1001h holds while there is an error of this code.

    >>> f"{register_of(0x8110):02X}h"
    '11h'
    """
    if code < FIRST_ERROR:
        return 0
    return GENERIC | sum(bit for first, last, bit in KINDS if first <= code <= last)


def tells_of_error(emergency: CanFrame) -> bool:
    """Say whether an emergency tells of an error, and not that there is none any more."""
    return emergency.dlc == 8 and int.from_bytes(emergency.data[:2], "little") >= FIRST_ERROR


class Errors:
    """The error register and the error list of a node, kept up with its ``ErrorCode``."""

    def __init__(self, objects: ObjectDictionary) -> None:
        """Add 1001h to the objects; the others are used where they are there."""
        self.register = Entry(bytes(1), DataType.UNSIGNED8, Access.RO)
        objects.add({ERROR_REGISTER: self.register})
        codes = (entry for entry in objects if isinstance(entry, ErrorCode))
        self._code = next(codes, ErrorCode.none())
        listed = sorted((mux, entry) for mux, entry in objects.items() if mux.index == ERROR_LIST)
        self._count, *self._places = [entry for _, entry in listed] or [Entry(bytes(1))]
        self._told = NO_ERROR
        self._shown = b""

    def forget(self) -> None:
        """Tell anew of an error that is still there."""
        self._told = NO_ERROR

    def update(self) -> int | None:
        """Bring the objects up to date; return the error code if it has to be told, else None."""
        news = None
        if self._code.value != self._told:
            self._told = self._code.value
            news = int.from_bytes(self._told, "little")
            self.register.value = bytes((register_of(news),))
            if news >= FIRST_ERROR:
                self._keep(self._told + bytes(2))
        if self._count.value != self._shown:
            self._show_list()
        return news

    def _keep(self, error: bytes) -> None:
        """Put an error at the head of the list; the oldest falls off a full one."""
        errors = [error, *(place.value for place in self._places[: self._count.value[0]])]
        for place, value in zip(self._places, errors, strict=False):
            place.value = value
        self._count.value = bytes((min(len(errors), len(self._places)),))

    def _show_list(self) -> None:
        """Let those places be read that hold an error, as the count says."""
        self._shown = self._count.value
        for number, place in enumerate(self._places, 1):
            place.has_data = number <= self._shown[0]
