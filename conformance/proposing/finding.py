"""The objects of a device of which there is no EDS: every index is read, and nothing written."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from conformance.beginning.discovery import Reading
from conformance.device.effort import READS_WITHOUT_ANSWER
from conformance.dialogue.transfers import EXISTS
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation

LAST_SUB_INDEX = 0xFE
# Takes the index that is read next.
Progress = Callable[[int], None]


@dataclass(slots=True)
class Found:
    """The result of a search: values by multiplexer, and write-only entries.

    ``moving`` values did not read the same twice. ``ended`` says why a search has not come
    to its end; empty if it has.
    """

    values: dict[Multiplexer, bytes] = field(default_factory=dict)
    write_only: list[Multiplexer] = field(default_factory=list)
    moving: set[Multiplexer] = field(default_factory=set)
    ended: str = ""

    @property
    def indices(self) -> set[int]:
        """The objects that are there."""
        return {mux.index for mux in (*self.values, *self.write_only)}


class ObjectSearch:
    """A search through the object dictionary of a device, by reads alone."""

    def __init__(self, reading: Reading) -> None:
        """Take a device that was discovered."""
        self.found = Found()
        self._reading = reading
        self._unanswered = 0

    def through(self, indices: Iterable[int], progress: Progress) -> Found:
        """Read each index, the sub-indices of arrays and records, and everything once more.

        Raises DeviceLost.
        """
        for index in indices:
            progress(index)
            if self._is_there(Multiplexer(index)):
                self._read_sub_indices(index)
            if self._unanswered >= READS_WITHOUT_ANSWER:
                self.found.ended = (
                    f"the search ended at {index:04X}h: {READS_WITHOUT_ANSWER} reads in a row were "
                    "not answered as they have to be"
                )
                break
        for mux, value in self.found.values.items():
            if self._unanswered < READS_WITHOUT_ANSWER and self._read(mux) != value:
                self.found.moving.add(mux)
        return self.found

    def _read_sub_indices(self, index: int) -> None:
        """Read the entries that sub-index 0 counts; sub-index 0 of a variable counts none.

        Some devices serve a variable at every sub-index.
        """
        count = self.found.values.get(Multiplexer(index), b"")
        if len(count) != 1 or not 0 < count[0] <= LAST_SUB_INDEX:
            return
        if count[0] < LAST_SUB_INDEX and self._read(Multiplexer(index, LAST_SUB_INDEX)) is not None:
            return
        for sub in range(1, count[0] + 1):
            there = self._is_there(Multiplexer(index, sub))
            # There may be a gap, but hardly one right at the beginning.
            if sub == 2 and not there and Multiplexer(index, 1) not in self.found.values:
                return

    def _is_there(self, mux: Multiplexer) -> bool:
        value = self._read(mux)
        if isinstance(value, bytes):
            self.found.values[mux] = value
        elif value == AbortCode.READ_OF_WRITE_ONLY:
            self.found.write_only.append(mux)
        return value is not None

    def _read(self, mux: Multiplexer) -> bytes | int | None:
        """Return the value, or the abort code of an entry that is there; None for none."""
        try:
            value: bytes | int | None = self._reading.sdo.read(mux)
        except ServerAborted as aborted:
            value = aborted.abort.code if aborted.abort.code in EXISTS else None
        except Violation:
            # The cases of a run will report it.
            self._reading.recover()
            self._unanswered += 1
            return None
        self._unanswered = 0
        return value
