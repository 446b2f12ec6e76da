"""What an object holds follows from what is sent, read and reset."""

import pytest

from conformance.device.contents import Contents, Holds
from conformance.device.known_objects import KnownObject, by_multiplexer
from conformance.sdo.frames import DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.objects import Access, DataType
from conformance.sdo.storage_commands import LOAD_ALL

NUMBER, TEXT, READ_ONLY = Multiplexer(0x2004), Multiplexer(0x2010), Multiplexer(0x2011)
OWN, PRESUMED, LEFT, UNKNOWN = Holds.OWN, Holds.PRESUMED, Holds.LEFT, Holds.UNKNOWN
RESET = NmtCommand.RESET_NODE


def contents(state: Holds = OWN) -> Contents:
    """Return the contents of a device of which the text is in a state."""
    objects = [
        KnownObject(NUMBER, DataType.UNSIGNED32),
        KnownObject(TEXT, DataType.VISIBLE_STRING),
        KnownObject(READ_ONLY, DataType.UNSIGNED32, Access.RO),
    ]
    made = Contents({NUMBER: b"1234", TEXT: b"own", READ_ONLY: b"5678"}, by_multiplexer(objects))
    made.will_change(TEXT)
    made.settle(TEXT)
    match state:
        case Holds.PRESUMED:
            made.presume(TEXT)
        case Holds.LEFT:
            made.leave(TEXT)
        case Holds.UNKNOWN:
            made.lose(TEXT)
    return made


@pytest.mark.parametrize(
    ("before", "after"),
    [(OWN, UNKNOWN), (PRESUMED, UNKNOWN), (LEFT, LEFT), (UNKNOWN, UNKNOWN)],
)
def test_nobody_knows_what_is_written(before: Holds, after: Holds) -> None:
    held = contents(before)
    held.will_change(TEXT)
    assert held.holds(TEXT) is after
    held.settle(TEXT)
    assert held.holds(TEXT) is OWN


@pytest.mark.parametrize(
    ("before", "after", "after_others"),
    [
        (OWN, PRESUMED, OWN),
        (PRESUMED, PRESUMED, PRESUMED),
        (LEFT, LEFT, PRESUMED),
        (UNKNOWN, UNKNOWN, UNKNOWN),
    ],
)
def test_a_reset(before: Holds, after: Holds, after_others: Holds) -> None:
    """Behind one that was seen to bring an object back, the next one will."""
    held = contents(before)
    held.will_change(NUMBER)
    assert held.reset(RESET, [NUMBER, TEXT]) == {NUMBER, TEXT}
    assert (held.holds(TEXT), held.holds(NUMBER)) == (after, UNKNOWN), "it was written"
    assert held.outstanding == {NUMBER: b"1234", TEXT: b"own"}
    held = contents(before)
    held.brought_back[RESET].add(TEXT)
    assert held.reset(RESET, [TEXT]) == set()
    assert held.holds(TEXT) is after_others


@pytest.mark.parametrize(
    ("before", "left", "lost"),
    [
        (OWN, LEFT, UNKNOWN),
        (PRESUMED, PRESUMED, UNKNOWN),
        (LEFT, LEFT, LEFT),
        (UNKNOWN, LEFT, UNKNOWN),
    ],
)
def test_what_is_not_put_back(before: Holds, left: Holds, lost: Holds) -> None:
    held = contents(before)
    held.leave(TEXT)
    assert held.holds(TEXT) is left
    held = contents(before)
    held.lose(TEXT)
    assert held.holds(TEXT) is lost


@pytest.mark.parametrize("state", Holds)
def test_the_value(state: Holds) -> None:
    """What was read counts, but its own value only where it is known to be there."""
    held = contents(state)
    assert held.value(TEXT) == (b"own" if state is OWN else None)
    held.current[TEXT] = b"read"
    assert held.value(TEXT) == (b"own" if state is OWN else b"read")
    assert held.read_last(TEXT) == b"read"
    assert held.read_last(NUMBER) == b"1234"


@pytest.mark.parametrize("state", Holds)
def test_only_its_own_value_is_back(state: Holds) -> None:
    held = contents(state)
    held.is_back(TEXT, b"stored")
    assert (held.holds(TEXT), held.outstanding) == (state, {TEXT: b"own"})
    held.is_back(TEXT, b"own")
    assert (held.holds(TEXT), held.outstanding) == (OWN, {})


def test_what_is_due() -> None:
    """What is read-only has a value that it has to have once it has taken a write."""
    held = contents()
    assert held.due([TEXT, READ_ONLY, NUMBER]) == {NUMBER: b"1234", TEXT: b"own"}
    held.parameters[READ_ONLY] = b"5678"
    assert list(held.due([TEXT, READ_ONLY])) == [TEXT, READ_ONLY]


def test_what_a_case_finds() -> None:
    """Only what the suite alone has written reads the same in the next case."""
    held = contents(LEFT)
    held.current |= {TEXT: b"left", NUMBER: b"1234"}
    held.case_begins()
    assert held.current == {TEXT: b"left"}


def test_a_command_changes_what_is_stored() -> None:
    held = contents()
    held.stored = {}
    held.brought_back[RESET].add(TEXT)
    held.sent(DownloadInitiate.with_data(LOAD_ALL, b"load"))
    assert held.stored is None
    assert not held.brought_back
