"""Whether a string or domain reads with more bytes than may be written to it.

What it holds could not be put back as it was read. So this is found out by writing just that,
before any other value.
"""

from dataclasses import replace

from conformance.device.effort import LONG_VALUE, TRIES_OF_REFUSED
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.values import longer_than_taken
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.limits import EXPEDITED_LENGTH
from conformance.sdo.objects import DataType

TOO_LONG = (AbortCode.LENGTH_TOO_HIGH, AbortCode.LENGTH_MISMATCH, AbortCode.OUT_OF_MEMORY)
# With what a device fills up a value that is shorter than its buffer.
PADDINGS = (b"\0", b" ")


def find_longer(sdo: Dialogue, known: KnownObject) -> bool:
    """Find out whether a value is refused for its length, though the object reads so.

    Where it is only filled up, the part of it that may be written is put back from then on. Else
    nothing is ever written there. Says whether it is refused.
    """
    device = sdo.device
    own = device.values[known.mux]
    if not EXPEDITED_LENGTH < len(own) <= LONG_VALUE:
        return False  # what is very long costs more requests than this is worth
    # A device may be short of memory once.
    if not all(_refused(sdo, known, own) for _ in range(TRIES_OF_REFUSED)):
        return False
    padding = next((each for each in PADDINGS if own.endswith(each)), b"")
    written = _written_part(sdo, known, own, padding)
    device.contents.is_back(known.mux, own)
    if written is None:
        device.learned.lengths[known.mux].irreplaceable = True
        sdo.note(longer_than_taken(known, own))
        return True
    device.values[known.mux] = written
    habits = replace(known.habits, filled=len(own), padding=padding, beyond=True)
    known = device.learn(known, habits)
    _measure(sdo, known, len(own))
    if known.data_type is not DataType.VISIBLE_STRING and not known.habits.adapts:
        sdo.note(longer_than_taken(known, own))
    return True


def find_others(sdo: Dialogue) -> None:
    """Find out which other strings and domains are like the one that reads longer."""
    for known in Roles(sdo.device).all_writable(lambda known: known.varies):
        if not known.habits.beyond:
            find_longer(sdo, known)


def _refused(sdo: Dialogue, known: KnownObject, own: bytes) -> bool:
    abort = sdo.try_download(known, own)
    return abort is not None and abort.code in TOO_LONG


def _written_part(sdo: Dialogue, known: KnownObject, own: bytes, padding: bytes) -> bytes | None:
    """Write a value without what fills it up; return it if the object reads as before then."""
    if not padding:
        return None
    written = own.rstrip(padding) or padding
    taken = sdo.try_download(known, written) is None
    return written if taken and sdo.upload(known) == own else None


def _measure(sdo: Dialogue, known: KnownObject, size: int) -> None:
    """Find out how many bytes may be written, fewer than ``size``."""
    lengths = sdo.device.learned.lengths[known.mux]
    lengths.taken.add(len(sdo.device.values[known.mux]))
    try:
        Room(sdo).fit(known, size - 1)
    except NotTestable:
        lengths.most = max(lengths.taken)
    lengths.filled = size
