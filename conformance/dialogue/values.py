"""Values of objects: how they are compared, shown, and cut into segments."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import chain

from conformance.device.device import Device
from conformance.device.known_objects import KnownObject
from conformance.sdo.describe import shown
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH
from conformance.sdo.objects import DataType, same_data
from conformance.sdo.rules import CONSTANT, NOT_REFUSED, Cause, Violation
from conformance.sdo.rules.block_upload import FIRST_SUB_BLOCK
from conformance.sdo.rules.defects import (
    EMPTY_NOT_STORED,
    END_MISSING,
    IN_BLOCKS,
    LENGTH_OF_ANOTHER,
    LONGER_THAN_TAKEN,
    NOT_STORED,
)
from conformance.sdo.rules.segmented_upload import SEGMENTS
from conformance.sdo.rules.sizes import TYPE_LENGTH, VARIABLE_LENGTH
from conformance.sdo.seen import Data, other_data, said


def same_value(known: KnownObject, found: bytes, due: bytes) -> bool:
    """Compare values: the 00h that ends a string is optional.

    So is that with which the device is known to fill up values, and so is what it is known to leave
    of longer ones: it is told so elsewhere.
    """
    return same_data(known.data_type, found, due, known.habits)


def with_spaces(known: KnownObject, stated: bytes, found: bytes) -> bytes:
    """Return a text that an EDS or DCF states with the spaces around it that were ``found``.

    Such a file cannot hold them: whoever reads it strips each value (CiA 306-1 is silent on them).
    """
    text = known.data_type is DataType.VISIBLE_STRING
    alike = found.rstrip(b"\0").strip() == stated.rstrip(b"\0").strip()
    return found if text and alike else stated


def restored_value(known: KnownObject, found: bytes, due: bytes) -> bool:
    """Compare what was put back: what is left of another value is not as it was."""
    return same_data(known.data_type, found, due, replace(known.habits, keeps_tails=False))


def not_as_written(known: KnownObject, due: bytes, found: bytes) -> Violation:
    """Build the breach that was seen of an object before: what of it reads as it was written."""
    if known.habits.lacks:
        return end_missing(known, due, known.habits.lacks)
    if known.habits.miscounted and len(found) <= EXPEDITED_LENGTH:
        return of_another_length(known, found)
    if known.habits.keeps_tails:
        return tail_kept(known, due)
    if known.habits.beyond:
        return longer_than_taken(known, found)
    return filled_up(known, due, found)


def check_constant(device: Device, mux: Multiplexer, data: bytes) -> None:
    """Raise Violation for a constant that reads otherwise than at the beginning of the run."""
    due = device.values.get(mux)
    # Without its type, an answer that does not count its bytes may be longer than the value.
    if due is not None and device.is_constant(mux) and not data.startswith(due):
        raise Violation(
            CONSTANT,
            expected=f"{mux} reads {shown(due)}, as at the beginning",
            actual=Data(data, mux),
        )


def of_another_length(known: KnownObject, data: bytes) -> Violation:
    """Build the breach that a value reads with another number of bytes than it has."""
    due = "as it was written"
    if known.data_type is not None and known.length is not None:
        due = f"{known.length} bytes, as {known.data_type.name} has"
    return Violation(
        TYPE_LENGTH,
        expected=f"{known} reads {due}",
        actual=Data(data, known),
        told_as=LENGTH_OF_ANOTHER,
    )


def end_missing(known: KnownObject, due: bytes, count: int) -> Violation:
    """Build the breach that the last ``count`` bytes of values are not read."""
    return Violation(
        SEGMENTS,
        expected=f"{known} to read the {len(due)} bytes that were written to it",
        actual=said("the last {} are left out", count),
        told_as=END_MISSING,
    )


def tail_kept(known: KnownObject, due: bytes) -> Violation:
    """Build the breach that the end of a longer value is left behind a shorter one."""
    return Violation(
        VARIABLE_LENGTH,
        expected=f"{known} to read the {len(due)} bytes that were written to it",
        actual="the end of a longer value is left behind a shorter one",
    )


def not_stored(known: KnownObject, due: bytes, told_as: Cause = NOT_STORED) -> Violation:
    """Build the breach that a download was confirmed and has changed nothing."""
    return Violation(
        NOT_REFUSED,
        expected=f"{known} to hold {shown(due)} once the download of that was confirmed",
        actual="it holds what it held before",
        told_as=told_as,
        is_certain=True,
    )


def not_emptied(known: KnownObject) -> Violation:
    """Build the breach that a download of no data was confirmed and has changed nothing."""
    return Violation(
        NOT_REFUSED,
        expected=f"{known} to be empty once the download of that was confirmed",
        actual="it holds what it held before",
        told_as=EMPTY_NOT_STORED,
        is_certain=True,
    )


def other_in_blocks(known: KnownObject, due: bytes, found: bytes) -> Violation:
    """Build the breach that a block upload brings other data than an ordinary one."""
    return Violation(
        FIRST_SUB_BLOCK,
        expected=f"{known} reads {shown(due)} in blocks, as by an ordinary upload",
        actual=Data(found, known),
        told_as=IN_BLOCKS,
        is_certain=True,
    )


def filled_up(known: KnownObject, due: bytes, found: bytes) -> Violation:
    """Build the breach that a value was filled up with 00h."""
    return Violation(
        VARIABLE_LENGTH,
        expected=f"{known} to take values of {len(due)} bytes",
        actual=said("shorter values are filled up with {}, {} bytes in all", "00h", len(found)),
    )


def longer_than_taken(known: KnownObject, found: bytes) -> Violation:
    """Build the breach that a value has more bytes than any that may be written."""
    return Violation(
        VARIABLE_LENGTH,
        expected=f"{known} to take a value as long as the one that it reads",
        actual=other_data(f"{known} reads longer than may be written: {shown(found)}"),
        told_as=LONGER_THAN_TAKEN,
    )


def segments_of(data: bytes) -> list[bytes]:
    """Return the data in pieces of 7 bytes; of no data one empty piece."""
    return [data[start : start + 7] for start in range(0, max(len(data), 1), 7)]


def is_written_through(found: bytes, before: bytes, parts: Iterable[bytes | bytearray]) -> bool:
    """Say whether a value is one of which some bytes have been written, each at its place.

    The others are what they were, or 0. A download that is aborted may have written its ``parts``
    through, where an object is a string or a domain.

    >>> is_written_through(b"newold", b"oldold", [b"newest"])
    True
    """
    sources = [before, *parts]
    return all(
        byte in chain((0,), (source[place] for source in sources if place < len(source)))
        for place, byte in enumerate(found)
    )
