"""What is read before the first case: all objects, and in haste some of very many."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import pytest
from support.run_bench import NODE_ID, NUMBER, TEXT, Recording, Workbench, undiscovered

from conformance.beginning.discovery import discover
from conformance.beginning.first_reading import FirstReading, in_order
from conformance.device import effort
from conformance.device.device import Device
from conformance.device.effort import LONG_VALUE, Effort
from conformance.device.known_objects import KnownObject, by_multiplexer
from conformance.device.learned import Reason, Unread
from conformance.device.not_testable import NotTestable
from conformance.device.permits import Permits
from conformance.device.protected_objects import NMT
from conformance.dialogue.object_expectations import value_of
from conformance.dialogue.tools import CaseTools
from conformance.reference.built_in_device import reference_entries
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.objects import Access, DataType, Entry

ENOUGH, MORE = 4, 6
FIRST = 0x3000


@pytest.fixture(autouse=True)
def _very_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(effort, "OBJECTS_IN_HASTE", ENOUGH)
    monkeypatch.setattr(effort, "FURTHER_REQUESTS_IN_HASTE", MORE)


def numbers(count: int, access: Access = Access.RW, first: int = FIRST) -> list[KnownObject]:
    """Return numbers of one kind, side by side."""
    indices = range(first, first + count)
    return [KnownObject(Multiplexer(index), DataType.UNSIGNED16, access) for index in indices]


def indices(objects: list[KnownObject]) -> list[int]:
    return [known.mux.index for known in objects]


def ordered(objects: list[KnownObject], *named: KnownObject) -> list[int]:
    permits = Permits(named=named, effort=Effort.HASTE)
    device = Device(NODE_ID, by_multiplexer(objects), permits=permits)
    return indices(in_order(device))


def test_few_objects_are_read_as_they_are_listed() -> None:
    few = [*numbers(2, Access.RO), *numbers(2, first=0x2000)]
    assert ordered(few) == indices(few)


def test_what_the_user_has_named_comes_first_and_then_all_kinds() -> None:
    named, other_kind = numbers(1, first=0x3040)[0], numbers(1, first=0x6000)[0]
    order = ordered([*numbers(8), other_kind, named], named)
    assert order[0] == named.mux.index
    assert other_kind.mux.index in order[:ENOUGH]


def test_what_is_not_to_be_read_is_not() -> None:
    write_only, excluded = numbers(1, Access.WO)[0], replace(numbers(1)[0], flags=2)
    for known in (write_only, excluded):
        assert ordered([*numbers(8, first=0x2000), known]) == indices(numbers(8, first=0x2000))


def test_the_first_are_read_whatever_they_take() -> None:
    reading = FirstReading(Effort.HASTE)
    for _ in range(ENOUGH):
        assert not reading.ends()
        reading.count(bytes(LONG_VALUE))
    for _ in range(MORE):
        assert not reading.ends()
        reading.count(b"")
    assert reading.ends()


def test_without_haste_all_are_read() -> None:
    reading = FirstReading(Effort.USUAL)
    for _ in range(1000):
        reading.count(bytes(LONG_VALUE))
    assert not reading.ends()


@contextmanager
def of_many(count: int, *, effort: Effort = Effort.HASTE) -> Iterator[tuple[Workbench, Recording]]:
    """Get to know a device of so many numbers, and of a text.

    The standard's objects are not listed.
    """
    entries = reference_entries(NODE_ID)
    added = numbers(count)
    entries |= {known.mux: Entry(b"\1\2", DataType.UNSIGNED16) for known in added}
    server = Recording(entries)
    with undiscovered(server, objects=[*added, TEXT]) as bench:
        permits = Permits(permissions=frozenset({NMT}), effort=effort)
        bench.device = replace(bench.device, permits=permits)
        discover(bench.channel, bench.device)
        yield bench, server


def test_very_many_are_passed_over() -> None:
    with of_many(20) as (bench, _):
        learned, values = bench.device.learned, bench.device.values
        read = [known for known in numbers(20) if known.mux in values]
        assert len(read) + (TEXT.mux in values) == ENOUGH + MORE
        assert (
            learned.unread_for(Reason.PASSED_OVER)
            == {known.mux for known in numbers(20)} - values.keys()
        )
        assert learned.unreadable == {}
        left = next(known for known in numbers(20) if known.mux in learned.unread)
        with pytest.raises(NotTestable, match=r"one of very many, and was not read .*--sdo-quick"):
            value_of(bench.device, left)
        # What every device has is read all the same.
        assert bench.device.identity["vendor-id"] == "0x5D0C0000"


def test_a_list_of_which_all_is_read() -> None:
    with of_many(20, effort=Effort.USUAL) as (bench, _):
        assert not bench.device.learned.unread_for(Reason.PASSED_OVER)
        assert {known.mux for known in numbers(20)} <= bench.device.values.keys()


def test_the_device_type_is_read_though_the_list_is_cut_short() -> None:
    listed = [*numbers(20), KnownObject(Multiplexer(0x1018, 1), DataType.UNSIGNED32, Access.CONST)]
    server = Recording(
        reference_entries(NODE_ID)
        | {known.mux: Entry(b"\1\2", DataType.UNSIGNED16) for known in numbers(20)}
    )
    # So many of a kind are in turn before it.
    listed += numbers(ENOUGH, first=0x2F00)
    with undiscovered(server, objects=listed) as bench:
        bench.device = replace(bench.device, permits=Permits(effort=Effort.HASTE))
        discover(bench.channel, bench.device)
        assert listed[20].mux in bench.device.values
        assert bench.device.learned.unread.keys().isdisjoint(bench.device.values)


@pytest.mark.parametrize("command", [NmtCommand.RESET_NODE, NmtCommand.RESET_COMMUNICATION])
def test_no_reset_where_it_changes_what_was_not_read(command: NmtCommand) -> None:
    """What is no communication parameter stays in a reset of the communication."""
    with of_many(20) as (bench, server):
        network = CaseTools.of(bench.dialogue()).network
        before = len(server.requests)
        if command is NmtCommand.RESET_COMMUNICATION:
            network.reset(command)
            return
        with pytest.raises(NotTestable, match=r"may change 11 objects of very many .*--sdo-quick"):
            network.reset(command)
        assert len(server.requests) == before
        assert network.expected_boot_ups == 0


def test_what_a_reset_does_not_change_need_not_be_read() -> None:
    over = {known.mux for known in numbers(3, Access.RO)}
    device = Device(NODE_ID, by_multiplexer([*numbers(3, Access.RO), NUMBER]))
    device.learned.unread |= dict.fromkeys(over, Unread(Reason.PASSED_OVER))
    assert device.lost_in_reset() == []
    device.learned.unread[NUMBER.mux] = Unread(Reason.PASSED_OVER)
    assert device.lost_in_reset() == [NUMBER]
    assert device.lost_in_reset(range(0x1000, 0x2000)) == []
