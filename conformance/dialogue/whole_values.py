"""A value that is written in segments and read in segments, whole."""

from conformance.device.effort import SHORT_VALUE
from conformance.device.known_objects import KnownObject
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.held_values import expect_read
from conformance.dialogue.lengths_by_writing import Room


def expect_stored_and_read(sdo: Dialogue, room: Room, known: KnownObject, size: int) -> None:
    """Expect a value of ``size`` bytes to be stored by a download, and to be read by an upload.

    Long values take so many requests that the cases on either side share one exchange.
    """
    whole = sdo.device.learned.lengths[known.mux].whole
    if size in whole:
        return
    data = sdo.payload(size)
    room.store(known, data, segmented=True)
    expect_read(sdo, known, data)
    if size > SHORT_VALUE:
        whole.add(size)
