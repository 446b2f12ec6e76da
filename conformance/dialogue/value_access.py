"""How values are read and written where their protocol is not the point.

Long ones go in blocks then, where a device was seen to serve these: in segments they take hundreds
of requests, and after each of many cases.
"""

from collections.abc import Generator
from functools import partial

from conformance.device.contents import Holds
from conformance.device.device import DEVICE_TYPE
from conformance.device.effort import LONG_VALUE, SEGMENTS_COMPARED, SHORT_VALUE
from conformance.device.known_objects import KnownObject
from conformance.device.learned import Way
from conformance.dialogue.payload import endangered
from conformance.dialogue.transfers import Transfers
from conformance.dialogue.values import same_value
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import BlockClient, Step
from conformance.sdo.checks import ServerAborted
from conformance.sdo.decoding import as_answer
from conformance.sdo.frames import Response, UploadInitiate, UploadInitiateResponse
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation
from conformance.sdo.stepping import Result

NO_ROOM = (
    AbortCode.LENGTH_TOO_HIGH,
    AbortCode.LENGTH_MISMATCH,
    AbortCode.LENGTH_TOO_LOW,
    AbortCode.OUT_OF_MEMORY,
)
# How a value is written: a device may refuse one way and take another.
WAYS: tuple[Way, ...] = (
    partial(BlockClient.download, segmented=True),
    partial(BlockClient.download, segmented=True, sized=False),
    BlockClient.block_download,
)


class ValueAccess:
    """Reads and writes values of a device; behind a try that fails the server is idle."""

    def __init__(self, sdo: Transfers) -> None:
        """Take what runs transfers; what they show is learned of its device."""
        self._sdo = sdo
        self._device = sdo.device

    def attempt(
        self, transfer: Generator[Step, Response, Result]
    ) -> Result | Violation | ServerAborted:
        """Run a transfer; return its result, or what has broken it off."""
        try:
            return self._sdo.run(transfer)
        except (Violation, ServerAborted) as broken:
            self._sdo.silence.recover()
            return broken

    # Reading

    def read(self, known: KnownObject, due: bytes | None = None) -> bytes:
        """Read an object: in blocks if its value is long, whatever was written to it.

        What does not read as ``due`` in blocks is read in segments as well.
        """
        found = self.in_blocks(known.mux)
        if found is None or (due is not None and not same_value(known, found, due)):
            return self._sdo.upload(known)
        self._device.contents.current[known.mux] = found
        return found

    def in_blocks(self, mux: Multiplexer, like: bytes = b"") -> bytes | None:
        """Read a long value in blocks: one as long as ``like``, or that was never seen shorter.

        None where it has to be read in segments: to know what it is, or what is wrong.
        """
        length = max(len(like), self._device.learned.lengths[mux].least)
        return self._brought(mux) if length > SHORT_VALUE and self.read_alike() else None

    def announced_in_blocks(self, mux: Multiplexer) -> bytes | None:
        """Read in blocks what announces that it is very long, and begins in segments as in blocks.

        None where it has to be read in segments to the end, as above.
        """
        sdo = self._sdo
        sdo.send(UploadInitiate(mux))
        response = as_answer(sdo.receive())
        sdo.end_transfer()
        size = response.size if isinstance(response, UploadInitiateResponse) else None
        if size is None or size <= LONG_VALUE or not self.read_alike():
            return None
        sdo.start_segmented_upload(mux)
        begun = b"".join(
            sdo.upload_segment(toggle=number % 2).data for number in range(SEGMENTS_COMPARED)
        )
        sdo.end_transfer()
        found = self._brought(mux) or b""
        return found if len(found) == size and found.startswith(begun) else None

    def read_alike(self) -> bool:
        """Say whether block uploads bring what ordinary ones do; compares them once in a run.

        A server that sends more behind the end of one is read in blocks where blocks are the point.
        """
        device, learned = self._device, self._device.learned
        if learned.reads_alike is None:
            lengths = {mux: len(device.values[mux]) for mux in device.steady()}
            short = [mux for mux, length in lengths.items() if length <= SHORT_VALUE]
            target = max(short, key=lambda mux: lengths[mux], default=DEVICE_TYPE)
            alike = self._sdo.upload(target) == self._brought(target)
            learned.reads_alike = alike and self._ends_quietly()
        return learned.reads_alike

    def _brought(self, mux: Multiplexer) -> bytes | None:
        found = self.attempt(self._sdo.client.block_upload(mux))
        return None if isinstance(found, Violation | ServerAborted) else found.data

    def _ends_quietly(self) -> bool:
        """Say whether nothing comes behind a transfer that has ended."""
        try:
            return not self._sdo.fence()
        except Violation:
            self._sdo.silence.recover()
            return False

    # Writing

    def write_in_blocks(self, mux: Multiplexer, value: bytes) -> bool:
        """Write a value in blocks if it is long and a case has done that; say whether it was taken.

        What is written has to be read back; a device that has failed once is not trusted again, but
        where it lacks the room.
        """
        learned = self._device.learned
        if len(value) <= SHORT_VALUE or not learned.stores_in_blocks:
            return False
        if endangered(self._device, value) is not None:
            return False
        broken = self.attempt(self._sdo.client.block_download(mux, value))
        if isinstance(broken, Violation | ServerAborted):
            lacks_room = isinstance(broken, ServerAborted) and broken.abort.code in NO_ROOM
            learned.stores_in_blocks = lacks_room
            return False
        return True

    def write_own(self, mux: Multiplexer) -> None:
        """Write what a string or domain held before the run, where a case has left another value.

        It is written as values are on a device that refuses the ordinary way; not at all where it
        is known to read so. To find that out might cost more than to write it: of what the object
        holds not even the length is known. Whether it does is found out later. Only what may well
        hold what it did is read: that was written already, or it takes no value at all.
        """
        contents, sdo = self._device.contents, self._sdo
        if mux not in contents.left():
            return
        value = self._device.values[mux]
        presumed = contents.holds(mux) is Holds.PRESUMED
        may_hold_it = presumed or self._device.learned.lengths[mux].most == 0
        if contents.value(mux) != value and not (may_hold_it and sdo.upload(mux) == value):
            way = self._device.learned.way_to_store
            if way is None or sdo.abort_of(way(sdo.client, mux, value)) is not None:
                sdo.download(mux, value)
        contents.presume(mux)

    def write_all_own(self) -> None:
        """Write what they all held before the run, but for those that ought to hold it."""
        contents = self._device.contents
        for mux in sorted(contents.left(Holds.LEFT)):
            if self._own_in_blocks(mux):
                contents.presume(mux)
            else:
                self.write_own(mux)

    def _own_in_blocks(self, mux: Multiplexer) -> bool:
        """Write a long value in blocks and read it back, where both are known to serve."""
        value, learned = self._device.values[mux], self._device.learned
        if len(value) <= SHORT_VALUE or not self.read_alike():
            return False
        if not self.write_in_blocks(mux, value):
            return False
        learned.stores_in_blocks = self._brought(mux) == value
        return learned.stores_in_blocks
