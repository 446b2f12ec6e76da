"""What an object is expected to hold: a value that was written, stated, or not to be changed."""

from conformance.device.effort import LONG_VALUE
from conformance.device.known_objects import KnownObject
from conformance.dialogue.changing import changes_by_itself
from conformance.dialogue.transfers import Transfers
from conformance.dialogue.value_access import ValueAccess
from conformance.dialogue.values import (
    is_written_through,
    not_as_written,
    not_stored,
    same_value,
    tail_kept,
    with_spaces,
)
from conformance.sdo.describe import shown
from conformance.sdo.objects import DataType, same_data
from conformance.sdo.rules import PART_WRITTEN, Violation
from conformance.sdo.rules.object_dictionary import STATED_TEXT
from conformance.sdo.seen import Data


def expect_stated(sdo: Transfers, known: KnownObject, stated: bytes) -> None:
    """Expect an object to read as an EDS or DCF states.

    00h is a VISIBLE_CHAR (7.1.6.3), which such a file cannot state: a text with some behind it
    breaks a SHOULD.
    """
    known = sdo.device.known.get(known.mux, known)  # with what was seen of it
    found = sdo.upload(known)
    _expect_found(sdo, known, with_spaces(known, stated, found), found)
    is_text = known.data_type is DataType.VISIBLE_STRING
    if is_text and found.endswith(b"\0") and not stated.endswith(b"\0"):
        actual = Data(found, known)
        due = f"{known} reads {shown(stated)}"
        sdo.note(Violation(STATED_TEXT, expected=due, actual=actual))


def expect_value(sdo: Transfers, known: KnownObject, due: bytes) -> None:
    """Expect an object to read as ``due``; a string may end in 00h."""
    _expect_found(sdo, known, due, ValueAccess(sdo).read(known, due))


def expect_read(sdo: Transfers, known: KnownObject, due: bytes) -> None:
    """Expect an ordinary upload to bring ``due``; a string may end in 00h."""
    found = sdo.upload_while(known, due) if len(due) > LONG_VALUE else sdo.upload(known)
    if sdo.line.open is not None and not sdo.record.causes.nothing_is_stored:
        begins = Data(found, known, remark=", and was read no further")
        raise sdo.breach(f"{known} reads {shown(due)}", begins)
    _expect_found(sdo, known, due, found)


def _expect_found(sdo: Transfers, known: KnownObject, due: bytes, found: bytes) -> None:
    if not same_value(known, found, due):
        number = known.length is not None
        unstored = sdo.record.causes.unstored(number=number, size=len(due))
        if unstored is not None:
            raise not_stored(known, due, unstored)
        if changes_by_itself(sdo, known.mux):
            sdo.info(f"{known} changes by itself: its values are not compared")
            return
        raise _reads_wrong(sdo, known, due, found)
    if not same_data(known.data_type, found, due) and not known.habits.adapts:
        sdo.note(not_as_written(known, due, found))


def _reads_wrong(sdo: Transfers, known: KnownObject, due: bytes, found: bytes) -> Violation:
    wrong = sdo.breach(f"{known} reads {shown(due)}", Data(found, known))
    wrong.is_certain = True
    return wrong


def expect_empty(
    sdo: Transfers, known: KnownObject, found: bytes, before: int, *, counted: bool = True
) -> None:
    """Expect an empty value to read as nothing or as one byte 00h.

    A string may be filled up to its fixed length, no shorter than the ``before`` bytes that it
    read last; or it comes with bytes that are not ``counted``, and ends at the first 00h.
    """
    if known.habits.keeps_tails and found:
        sdo.note(tail_kept(known, b""))
        return
    fills = known.data_type is DataType.VISIBLE_STRING or known.habits.filled > 0
    filled = fills and (len(found) >= before or not counted)
    if found.strip(b"\0" + known.habits.padding) or (len(found) > 1 and not filled):
        raise sdo.breach(f"{known} reads as nothing, or as one byte 00h", Data(found))


def expect_kept(sdo: Transfers, known: KnownObject, before: bytes) -> None:
    """Expect an object to read as before a download that was aborted.

    Of a string what came before the abort may have been written, a domain may hold anything;
    both count as a breach of a SHOULD.
    """
    if known.length is not None:
        expect_value(sdo, known, before)
        return
    found = ValueAccess(sdo).read(known, before)
    if same_value(known, found, before):
        return
    due, actual = f"{known} reads {shown(before)}", Data(found, known)
    parts = sdo.wire.parts[known.mux]
    if known.data_type is DataType.DOMAIN or is_written_through(found, before, parts):
        sdo.note(Violation(PART_WRITTEN, expected=due, actual=actual))
    else:
        raise sdo.breach(due, actual)
