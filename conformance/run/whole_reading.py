"""What of an object is read when a run begins: all of it, unless that would take for ever."""

from collections.abc import Generator

from conformance.device.device import VERY_LONG
from conformance.device.known_objects import KnownObject
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.long_values import read_in_blocks
from conformance.sdo.block_client import Step
from conformance.sdo.client import Uploaded
from conformance.sdo.decoding import as_answer
from conformance.sdo.frames import Response, UploadInitiateResponse
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.stepping import Ended, advance

# What is longer, in bytes, is never read or written whole: that takes tens of thousands of requests
# each time, and a device of which 65,544 bytes are right has shown how far it counts.
MOST_READ = 100_000
# The same of all very long values together where no block upload brings them: a run reads and
# writes each of them in segments several times, some hundreds of requests at a time.
MOST_IN_SEGMENTS = 5_000


class TooLong(Exception):
    """An object has so many bytes that they are not read; the text says how many."""

    def __init__(self, size: int, most: int) -> None:
        """Take the size that the device announces, and the ``most`` that is read."""
        few = most < MOST_READ
        why = " in segments (more with --sdo-thorough)" if few else ""
        super().__init__(f"it has {size} bytes, and no more than {most} are read{why}")
        self.size = size


def read_whole(sdo: Dialogue, known: KnownObject) -> bytes:
    """Read an object; raises TooLong, and Violation for a device that does not serve it.

    One that is longer than what is read in segments has to come in blocks as well.
    """
    if known.length is not None:
        return sdo.upload(known)
    permits = sdo.device.permits
    if permits.takes_time(known):
        return _read(sdo, known, MOST_READ)
    long = sum(len(value) for value in sdo.device.values.values() if len(value) > VERY_LONG)
    most = VERY_LONG if permits.in_haste else max(MOST_IN_SEGMENTS - long, VERY_LONG)
    try:
        data = _read(sdo, known, most)
    except TooLong as found:
        return _read_in_both_ways(sdo, known, found, MOST_READ - long)
    if len(data) > most and not Blocks(sdo).reads(known.mux, data):
        raise TooLong(len(data), most)  # that was not announced
    return data


def _read_in_both_ways(sdo: Dialogue, known: KnownObject, found: TooLong, most: int) -> bytes:
    """Read in blocks what is long, and in segments as well if that is not too much by now.

    Nor is there the time for that in a hasty run.
    """
    if found.size > MOST_READ:
        raise TooLong(found.size, MOST_READ)
    in_blocks = read_in_blocks(sdo, known.mux)
    if in_blocks is None:
        raise found
    if sdo.device.permits.in_haste or len(in_blocks) > most:
        sdo.wire.seen[known.mux] = in_blocks
        return in_blocks
    return _read(sdo, known, MOST_READ)


def _read(sdo: Dialogue, known: KnownObject, most: int) -> bytes:
    with sdo.served():
        try:
            uploaded = sdo.run(_cut_off(sdo.client.upload(known.mux), most))
        except TooLong:
            sdo.end_transfer()
            raise
    sdo.wire.seen[known.mux] = uploaded.data
    return uploaded.data


def _cut_off(
    upload: Generator[Step, Response, Uploaded], most: int
) -> Generator[Step, Response, Uploaded]:
    """Hand on an upload as far as one goes that announces no more bytes than ``most``.

    What a device announces may be wrong, so it has to bring hundreds of segments first.
    """
    step, size, brought = advance(upload), 0, 0
    while not isinstance(step, Ended):
        answer = yield step
        if not brought and isinstance(response := as_answer(answer), UploadInitiateResponse):
            size = response.size or 0
        brought += SEGMENT_LENGTH
        if size > most and brought > min(most, MOST_IN_SEGMENTS):
            raise TooLong(size, most)
        step = advance(upload, answer)
    return step.result
