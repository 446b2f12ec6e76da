"""Attempts to write to a string or domain, and what they tell: which lengths it takes, and how."""

from collections.abc import Iterable

from conformance.device.effort import TRIES_OF_LENGTH
from conformance.device.known_objects import KnownObject
from conformance.device.learned import Way
from conformance.dialogue.transfers import Transfers
from conformance.dialogue.value_access import WAYS
from conformance.sdo.abort_codes import describe_code
from conformance.sdo.frames import Abort
from conformance.sdo.objects import DataType
from conformance.sdo.rules import Violation

# What even an object of a few bytes takes one of.
EXPEDITED = (1, 4)


class Trials:
    """Writes values of several lengths in several ways: an object holds the last that it took."""

    def __init__(self, sdo: Transfers) -> None:
        """Take what writes; what was found out is known of its device."""
        self._sdo = sdo
        self._device = sdo.device

    def write(
        self, known: KnownObject, data: bytes, *, segmented: bool | None = True, sized: bool = True
    ) -> Abort | None:
        """Write a value; where the server ends the running transfer, write it again.

        Returns the abort if it ends each of some tries.
        """
        return self._sdo.again_if_aborted(
            lambda: self._sdo.try_download(known, data, segmented=segmented, sized=sized)
        )

    def learn_that_nothing_is_taken(
        self, known: KnownObject, data: bytes, refused: Violation
    ) -> None:
        """Remember of an object that takes no value at all, by no way, that it takes none.

        That is told here, once; the cases behind this one do without the object.
        """
        lengths = self._device.learned.lengths[known.mux]
        own = self._device.values[known.mux]
        if lengths.taken or lengths.most is not None:
            return
        for _ in range(TRIES_OF_LENGTH):
            self._sdo.silence.recover()
            if own != data and self.write_otherwise(known, own, WAYS):
                lengths.taken.add(len(own))
                return
            if any(self.takes(known, size) for size in EXPEDITED):
                return
        lengths.most, lengths.refusal = 0, refused.actual

    def write_otherwise(self, known: KnownObject, data: bytes, ways: Iterable[Way]) -> bool:
        """Write by one of several ways; say whether one of them was taken."""
        for way in ways:
            try:
                abort = self._sdo.abort_of(way(self._sdo.client, known.mux, data))
            except Violation as broken:
                self._sdo.note(broken)
                self._sdo.silence.recover()
            else:
                if abort is None:
                    self._device.learned.way_to_store = way
                    return True
                if self._sdo.record.early.met is not None:
                    self._sdo.silence.recover(crossed=True)
        return False

    def takes_otherwise(self, known: KnownObject, data: bytes) -> bool:
        """Say whether it is not for the length that an object refused a download.

        It takes these bytes without their size. Or it takes longer and shorter values, so that no
        fixed length, no shortest one and no multiple explains the refusal.
        """
        size = len(data)
        return (
            self._sdo.try_download(known, data, segmented=True, sized=False) is None
            or self._sdo.try_download(known, data, segmented=True) is None
            or self._has_gap(known, size)
        )

    def is_too_long(self, known: KnownObject, data: bytes) -> bool:
        """Say whether it is for its length that an object refuses a value, whatever it says.

        It takes a shorter one in segments, and this one by no protocol.
        """
        size, lengths = len(data), self._device.learned.lengths[known.mux]
        own = len(self._device.values[known.mux])
        shorter = [taken for taken in (*lengths.taken, own, *EXPEDITED) if 0 < taken < size]
        if not shorter or not self.takes(known, max(shorter)):
            return False
        try:
            in_blocks = self._sdo.abort_of(self._sdo.client.block_download(known.mux, data))
        except Violation as broken:
            self._sdo.note(broken)
            self._sdo.end_transfer()
            return False
        return in_blocks is not None and not self.takes_otherwise(known, data)

    def _has_gap(self, known: KnownObject, size: int) -> bool:
        """Say whether an object takes values around a length that it does not take."""
        if not self.takes(known, size + 1):
            return False
        two_more = self.takes(known, size + 2)
        shorter = self.takes(known, size - 1) if size > 1 else self.takes(known, size + 3)
        if known.data_type is DataType.VISIBLE_STRING:
            return two_more or shorter  # else it has one length
        return two_more and shorter

    def takes(self, known: KnownObject, size: int) -> bool:
        """Write a value of ``size`` bytes; say whether it was taken."""
        for _ in range(TRIES_OF_LENGTH):
            try:
                taken = self.write(known, self._sdo.payload(size)) is None
            except Violation as broken:
                self._sdo.note(broken)
                self._sdo.silence.recover()
                continue
            if taken:
                self._device.learned.lengths[known.mux].taken.add(size)
            return taken
        return False

    def measure(self, known: KnownObject, refused: int, abort: Abort) -> None:
        """Find the most bytes that an object takes, fewer than ``refused``, or its only length."""
        lengths = self._device.learned.lengths[known.mux]
        own = len(self._device.values[known.mux])
        if own and own not in lengths.taken:
            self.takes(known, own)
        low = max((taken for taken in lengths.taken if taken < refused), default=0)
        high = refused
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.takes(known, middle) else (low, middle)
        longer = [taken for taken in lengths.taken if taken > refused]
        if len(lengths.taken) == 1:
            (low,) = lengths.taken
            lengths.fixed = low == 1 or not self.takes(known, low - 1)
        elif longer:
            low = max(longer)
        lengths.most = low
        lengths.refusal = describe_code(abort.code)
