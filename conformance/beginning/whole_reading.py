"""What of an object is read when a run begins: all of it, unless that would take for ever."""

from collections.abc import Generator

from conformance.device.effort import BELIEVED, LONGEST_READ
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import Lack, Missing
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.value_access import ValueAccess
from conformance.sdo.block_client import Step
from conformance.sdo.client import Uploaded
from conformance.sdo.decoding import as_answer
from conformance.sdo.frames import Response, UploadInitiateResponse
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.stepping import Ended, advance


class TooLong(Exception):
    """An object has so many bytes that they are not read; the text says how many."""

    def __init__(self, size: int, most: int) -> None:
        """Take the size that the device announces, and the ``most`` that is read."""
        in_haste = most < LONGEST_READ
        why = " by --sdo-quick" if in_haste else ""
        super().__init__(f"it has {size} bytes, and no more than {most} are read{why}")
        self.size = size
        self.missing = Missing(Lack.WHOLE_READING) if in_haste else None


def read_whole(sdo: Dialogue, known: KnownObject) -> bytes:
    """Read an object; raises TooLong, and Violation for a device that does not serve it.

    In haste a long value has to come in blocks.
    """
    if known.length is not None:
        return sdo.upload(known)
    most = sdo.device.permits.effort.longest_read
    try:
        return _read(sdo, known, most)
    except TooLong as found:
        if most == LONGEST_READ:
            raise
        if found.size > LONGEST_READ:
            raise TooLong(found.size, LONGEST_READ) from found
        in_blocks = ValueAccess(sdo).announced_in_blocks(known.mux)
        if in_blocks is None:
            raise
        sdo.device.contents.current[known.mux] = in_blocks
        return in_blocks


def _read(sdo: Dialogue, known: KnownObject, most: int) -> bytes:
    with sdo.served():
        try:
            uploaded = sdo.run(_cut_off(sdo.client.upload(known.mux), most))
        except TooLong:
            sdo.end_transfer()
            raise
    sdo.device.contents.current[known.mux] = uploaded.data
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
        if size > most and brought > min(most, BELIEVED):
            raise TooLong(size, most)
        step = advance(upload, answer)
    return step.result
