"""What of an object is read when a run begins: all of it, unless that would take for ever."""

from collections.abc import Generator

from conformance.device.known_objects import KnownObject
from conformance.device.roles import THOUSANDS_OF_SEGMENTS
from conformance.dialogue.dialogue import Dialogue
from conformance.sdo.block_client import Step
from conformance.sdo.client import Uploaded
from conformance.sdo.decoding import as_answer
from conformance.sdo.frames import Response, UploadInitiateResponse
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.stepping import Ended, advance

# What is longer, in bytes, is never read or written whole: that takes tens of thousands of requests
# each time, and a device of which 65,544 bytes are right has shown how far it counts.
MOST_READ = 100_000


class TooLong(Exception):
    """An object has so many bytes that they are not read; the text says how many."""

    def __init__(self, size: int) -> None:
        """Take the size that the device announces."""
        super().__init__(f"it has {size} bytes, and no more than {MOST_READ} are read")


def read_whole(sdo: Dialogue, known: KnownObject) -> bytes:
    """Read an object; raises TooLong, and Violation for a device that does not serve it."""
    if known.length is not None:
        return sdo.upload(known)
    with sdo.served():
        try:
            uploaded = sdo.run(_cut_off(sdo.client.upload(known.mux)))
        except TooLong:
            sdo.end_transfer()
            raise
    sdo.wire.seen[known.mux] = uploaded.data
    return uploaded.data


def _cut_off(
    upload: Generator[Step, Response, Uploaded],
) -> Generator[Step, Response, Uploaded]:
    """Hand on an upload as far as one goes that is not too long.

    What a device announces may be wrong, so it has to bring thousands of segments first.
    """
    step, size, brought = advance(upload), 0, 0
    while not isinstance(step, Ended):
        answer = yield step
        if not brought and isinstance(response := as_answer(answer), UploadInitiateResponse):
            size = response.size or 0
        brought += SEGMENT_LENGTH
        if size > MOST_READ and brought > THOUSANDS_OF_SEGMENTS:
            raise TooLong(size)
        step = advance(upload, answer)
    return step.result
