"""Exchanges of two frames that a log has again and again: they need not be judged anew."""

from conformance.logs.reading import Seen
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.fixed_objects import entry_at
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.objects import Access

# What an exchange of two frames begins and ends with. Those that are expedited carry a value.
EXPEDITED = frozenset((0x23, 0x27, 0x2B, 0x2F, 0x43, 0x47, 0x4B, 0x4F))
ASKING = frozenset((0x40, 0x23, 0x27, 0x2B, 0x2F))
ANSWERING = frozenset((0x43, 0x47, 0x4B, 0x4F, 0x60, 0x80))
MOST_EXCHANGES = 50_000


class Exchanges:
    """Requests and answers, frame by frame, after which a channel was at rest as before.

    Most of a log are the same ones again and again, apart from the values in them. Where a value is
    not known either, nothing is left to find out.
    """

    def __init__(self) -> None:
        """Know none."""
        self._known: set[tuple[bytes, bytes]] = set()

    def has(self, asked: Seen | None, seen: Seen) -> bool:
        """Say whether what was asked and its answer are known."""
        if asked is None or not is_one_of(ANSWERING, seen.frame):
            return False
        return (_form(asked.frame.data), _form(seen.frame.data)) in self._known

    def add(self, asked: Seen, seen: Seen) -> None:
        """Know an exchange, unless the value in it matters."""
        if len(self._known) >= MOST_EXCHANGES:
            self._known.clear()
        if is_one_of(ANSWERING, seen.frame) and not _is_about_a_value(asked.frame.data):
            self._known.add((_form(asked.frame.data), _form(seen.frame.data)))


def is_one_of(commands: frozenset[int], frame: CanFrame) -> bool:
    """Say whether a frame is a plain one with one of these command bytes."""
    ordinary = not frame.extended and not frame.remote and len(frame.data) == FRAME_LENGTH
    return ordinary and frame.data[0] in commands


def _is_about_a_value(request: bytes) -> bool:
    fixed = entry_at(Multiplexer(int.from_bytes(request[1:3], "little"), request[3]))
    return fixed is not None and (fixed.access is Access.CONST or fixed.takes is not None)


def _form(data: bytes) -> bytes:
    """Return a frame without the bytes of a value."""
    if data[0] not in EXPEDITED:
        return data
    return data[:4] + data[FRAME_LENGTH - (data[0] >> 2 & 3) :]
