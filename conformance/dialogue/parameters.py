"""What cases do with communication parameters, and how they get their values back.

A COB-ID is taken out of use before it is moved, and a PDO before its mapping changes.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.dialogue.dialogue import Dialogue
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.cob_id import EXTENDED, LARGEST_EXTENDED_ID
from conformance.sdo.describe import shown
from conformance.sdo.frames import Abort
from conformance.sdo.layout import Multiplexer
from conformance.sdo.pdos import MAPPING_OF, MOST_MAPPED, is_multiplexed
from conformance.sdo.rules import Rule, Violation
from conformance.sdo.seen import Received, said

NOT_VALID, PRODUCES, CONSUMES = 1 << 31, 1 << 30, 1 << 31
MISSING = (AbortCode.OBJECT_MISSING, AbortCode.SUB_INDEX_MISSING)
# How a device says that an entry cannot be configured at all.
CONSTANT = (AbortCode.WRITE_OF_READ_ONLY, AbortCode.UNSUPPORTED_ACCESS)


@dataclass(frozen=True, slots=True)
class CobIdEntry:
    """An entry that holds a COB-ID: how it is taken out of use, and how put into use.

    ``in_use`` are the bits that say so when they are set, or when they are not (``valid_is_0``).
    What is ``always_consumed`` has no bit that says that it is not.
    """

    mux: Multiplexer
    in_use: int
    valid_is_0: bool = False
    consumes: int = 0
    always_consumed: bool = False

    def is_used(self, number: int) -> bool:
        """Say whether a value may not be moved."""
        return bool(number & self.in_use) is not self.valid_is_0

    def unused(self, number: int) -> int:
        """Return a value with the same CAN-ID that is not in use."""
        return number | self.in_use if self.valid_is_0 else number & ~self.in_use

    def using(self, number: int, can_id: int) -> int:
        """Return the value that puts an 11-bit CAN-ID into use, as a consumer if there is one."""
        flags = self.unused(number) & ~(LARGEST_EXTENDED_ID | EXTENDED)
        return (flags & ~self.in_use if self.valid_is_0 else flags | self.consumes) | can_id

    def ways_of_using(self, number: int, can_id: int) -> list[int]:
        """Return all values that put an 11-bit CAN-ID into use."""
        using = self.using(number, can_id)
        return [self.unused(using), using] if self.always_consumed else [using]


COB_ID_ENTRIES = {
    "1005h": CobIdEntry(Multiplexer(0x1005), PRODUCES, always_consumed=True),
    "1012h": CobIdEntry(Multiplexer(0x1012), PRODUCES | CONSUMES, consumes=CONSUMES),
    "1014h": CobIdEntry(Multiplexer(0x1014), NOT_VALID, valid_is_0=True),
    "1400h": CobIdEntry(Multiplexer(0x1400, 1), NOT_VALID, valid_is_0=True),
    "1800h": CobIdEntry(Multiplexer(0x1800, 1), NOT_VALID, valid_is_0=True),
}


# The first of those that a device receives, and of those that it sends.
PDOS = {label: COB_ID_ENTRIES[label] for label in ("1400h", "1800h")}


def number_of(value: bytes) -> int:
    """Return the number that an entry holds."""
    return int.from_bytes(value, "little")


class Parameters:
    """Communication parameters of a device, which are known before they are written."""

    def __init__(self, sdo: Dialogue) -> None:
        """Take what reads and writes them; what they held is known of its device."""
        self._sdo = sdo

    def learn(self, mux: Multiplexer) -> bool:
        """Read a parameter before it is written for the first time; say whether it is there."""
        return self.learn_or_refusal(mux) is None

    def learn_or_refusal(self, mux: Multiplexer) -> Abort | None:
        """Read a parameter before it is written for the first time; return the abort if refused."""
        found = self._sdo.device.contents.parameters
        if mux not in found:
            try:
                found[mux] = self._sdo.read(mux)
            except ServerAborted as aborted:
                return aborted.abort
        return None

    def write(self, mux: Multiplexer, data: bytes) -> Abort | None:
        """Write a parameter that was learned; return the abort if the server refuses."""
        if not self.learn(mux):
            raise self._sdo.breach(f"{mux} to be readable", "it is not")
        return self._sdo.try_download(mux, data)

    def write_if_configurable(self, mux: Multiplexer, value: bytes) -> None:
        """Write an entry; raises Unimplemented where it is constant, NotTestable where not now."""
        abort = self.write(mux, value)
        if abort is None:
            return
        refusal = Received(abort)
        if abort.code in CONSTANT:
            raise Unimplemented(refusal)
        raise NotTestable(f"{mux} does not take {value.hex(' ')} now: {refusal.words}")

    def present(self, mux: Multiplexer) -> bytes:
        """Read an entry of the communication; raises Unimplemented where a device has none."""
        try:
            return self._sdo.read(mux)
        except ServerAborted as aborted:
            refusal = Received(aborted.abort)
            if aborted.abort.code in (*MISSING, AbortCode.GENERAL_ERROR):
                raise Unimplemented(refusal) from aborted
            raise NotTestable(f"{mux} cannot be read: {refusal.words}") from aborted

    # What has to be out of use before it is changed

    @contextmanager
    def out_of_use(self, entry: CobIdEntry) -> Iterator[int]:
        """Take a COB-ID out of use for the block; hands out the value that it had.

        Whatever was taken in the block is out of use in the end: the value of before can be put
        back.
        """
        self._sdo.device.permits.require_write(entry.mux.index)
        before = self.present(entry.mux)
        unused = entry.unused(number_of(before)).to_bytes(4, "little")
        self.learn(entry.mux)
        if unused == before:
            abort = self._sdo.try_download(entry.mux, unused)
            if abort is not None and abort.code in CONSTANT:
                raise Unimplemented(Received(abort))
        else:
            self.write_if_configurable(entry.mux, unused)
        try:
            yield number_of(before)
        finally:
            self._tidy(lambda: self._retire(entry))

    def _retire(self, entry: CobIdEntry) -> None:
        found = number_of(self._sdo.upload(entry.mux))
        if entry.is_used(found):
            self._sdo.try_download(entry.mux, entry.unused(found).to_bytes(4, "little"))

    def require_used(self, entry: CobIdEntry, before: int) -> None:
        """Put a COB-ID back into use that was; raises NotTestable where it was not."""
        if not entry.is_used(before):
            raise NotTestable(f"{entry.mux} is not in use: let the device use it")
        self.write_if_configurable(entry.mux, before.to_bytes(4, "little"))

    def mapping_of(self, pdo: CobIdEntry) -> tuple[Multiplexer, list[bytes]]:
        """Return where the number of entries of a mapping is, and the entries that are in use."""
        count = Multiplexer(pdo.mux.index + MAPPING_OF)
        value = self.present(count)
        if is_multiplexed(count, value):
            raise NotTestable(f"{count} reads {value.hex().upper()}h: the PDO is multiplexed")
        number = number_of(value)
        if number > MOST_MAPPED:
            raise NotTestable(f"{count} reads {shown(value)}: see pdo.mapping-in-use")
        return count, [self._sdo.upload(_entry_of(count, sub)) for sub in range(1, number + 1)]

    @contextmanager
    def free_mapping(self, entry: CobIdEntry) -> Iterator[tuple[Multiplexer, Sequence[int]]]:
        """Take a PDO out of use and let it map nothing; hands out its mapping and what was mapped.

        The mapping is put back in the end, in the order that it takes.
        """
        with self.out_of_use(entry):
            count, values = self.mapping_of(entry)
            self.learn(count)
            self.write_if_configurable(count, b"\0")
            try:
                yield count, [number_of(value) for value in values]
            finally:
                self._tidy(lambda: self._map_again(count, values))

    def _map_again(self, count: Multiplexer, values: Sequence[bytes]) -> None:
        self._sdo.try_download(count, b"\0")
        for sub_index, value in enumerate(values, 1):
            if self._sdo.upload(_entry_of(count, sub_index)) != value:
                self._sdo.try_download(_entry_of(count, sub_index), value)
        # Entries behind those that were in use need not be what they were: they map nothing.
        self._sdo.try_download(count, bytes([len(values)]))

    def _tidy(self, steps: Callable[[], None]) -> None:
        """Put values back on the way out of a case; what cannot be is left to its end."""
        self._sdo.end_transfer()
        try:
            steps()
        except (Violation, ServerAborted):
            self._sdo.end_transfer()

    def expect_not_mapped(self, count: Multiplexer, entries: Sequence[int], rule: Rule) -> None:
        """Write a mapping that cannot be; it may be refused at any of its entries, or at the last.

        Raises Unimplemented where an entry cannot be configured.
        """
        abort = self.map_entries(count, entries)
        if abort is None:
            raise self._sdo.breach(
                "abort with 06040041h or 06040042h", said("{} entries are mapped", len(entries))
            )
        if abort.code in CONSTANT:
            raise Unimplemented(Received(abort))
        self._sdo.take_abort(abort, rule.codes, None, rule.tolerated)
        if any(found := self._sdo.upload(count)):
            raise self._sdo.breach(f"{count} reads 00 as before", said("{}", found.hex()))

    def map_entries(self, count: Multiplexer, entries: Sequence[int]) -> Abort | None:
        """Write entries of a mapping and how many there are; return the abort that ends it."""
        for sub_index, entry in enumerate(entries, 1):
            mux = _entry_of(count, sub_index)
            self.learn(mux)
            abort = self._sdo.try_download(mux, entry.to_bytes(4, "little"))
            if abort is not None:
                return abort
        return self._sdo.try_download(count, bytes([len(entries)]))


def _entry_of(count: Multiplexer, sub_index: int) -> Multiplexer:
    return Multiplexer(count.index, sub_index)
