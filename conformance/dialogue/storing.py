"""Ways to write a value, of which a device may refuse one and take another."""

from collections.abc import Generator

from conformance.device.effort import SHORT_VALUE
from conformance.device.learned import Way
from conformance.dialogue.payload import endangered
from conformance.dialogue.transfers import Transfers
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import BlockClient, Step
from conformance.sdo.checks import ServerAborted
from conformance.sdo.frames import Response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation

NO_ROOM = (
    AbortCode.LENGTH_TOO_HIGH,
    AbortCode.LENGTH_MISMATCH,
    AbortCode.LENGTH_TOO_LOW,
    AbortCode.OUT_OF_MEMORY,
)
Transfer = Generator[Step, Response, object]


def in_segments(client: BlockClient, mux: Multiplexer, data: bytes) -> Transfer:
    """Write in segments, with the size indicated."""
    return client.download(mux, data, segmented=True)


def in_unsized_segments(client: BlockClient, mux: Multiplexer, data: bytes) -> Transfer:
    """Write in segments without a word on their size."""
    return client.download(mux, data, segmented=True, sized=False)


def in_blocks(client: BlockClient, mux: Multiplexer, data: bytes) -> Transfer:
    """Write in blocks."""
    return client.block_download(mux, data)


WAYS: tuple[Way, ...] = (in_segments, in_unsized_segments, in_blocks)


def write_in_blocks(sdo: Transfers, mux: Multiplexer, value: bytes) -> bool:
    """Write a value in blocks if it is long and a case has done that; say whether it was taken.

    What is written has to be read back; a device that has failed once is not trusted again, but
    where it lacks the room.
    """
    if len(value) <= SHORT_VALUE or not sdo.device.learned.stores_in_blocks:
        return False
    if endangered(sdo.device, value) is not None:
        return False
    try:
        sdo.run(in_blocks(sdo.client, mux, value))
    except (Violation, ServerAborted) as error:
        lacks_room = isinstance(error, ServerAborted) and error.abort.code in NO_ROOM
        sdo.device.learned.stores_in_blocks = lacks_room
        sdo.silence.recover()
        return False
    return True
