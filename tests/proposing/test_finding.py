"""The search for objects without an EDS: what is there, what moves, and when it ends."""

from collections.abc import Iterable

from support.run_bench import (
    BASELINE,
    NODE_ID,
    READ,
    Scripted,
    Workbench,
    discovered,
    recording,
    undiscovered,
)

from conformance.beginning.discovery import READING, Reading
from conformance.device.effort import READS_WITHOUT_ANSWER
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.dialogue import Dialogue
from conformance.proposing.finding import Found, ObjectSearch
from conformance.reference.built_in_device import reference_entries
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry

MISSING = bytes.fromhex("8000000000000206")


def search(bench: Workbench, indices: Iterable[int]) -> Found:
    reading = Reading(Dialogue(bench.channel, bench.device, CaseRecord(READING), 0))
    return ObjectSearch(reading).through(indices, lambda index: None)


def test_what_is_there() -> None:
    entries = {
        **reference_entries(NODE_ID),
        Multiplexer(0x2200): Entry(b"\3", DataType.UNSIGNED8, Access.CONST),
        Multiplexer(0x2200, 1): Entry(b"\1\0", DataType.UNSIGNED16),
        Multiplexer(0x2200, 3): Entry(b"\3\0", DataType.UNSIGNED16),
    }
    server = recording(entries=entries)
    with discovered(server) as bench:
        found = search(bench, range(0x1FFF, 0x2300))
    expected = {mux for mux in entries if mux.index >= 0x2000 and mux.index != 0x2020}
    assert found.values.keys() == expected
    assert found.values[Multiplexer(0x2010)] == b"text"
    assert found.write_only == [Multiplexer(0x2020)]
    assert found.indices == {mux.index for mux in entries if mux.index >= 0x2000}
    assert found.moving == set()
    assert found.ended == ""
    assert server.writes == []


def test_a_variable_of_a_byte_is_no_record() -> None:
    server = recording()
    with discovered(server) as bench:
        search(bench, [0x2001])
    read = [data for data in server.requests if data[1:3] == b"\x01\x20" and data[3]]
    assert len(read) == 3


def test_a_variable_that_any_sub_index_serves_is_no_record() -> None:
    def answers(data: bytes) -> list[bytes]:
        if data == READ:
            return [BASELINE]
        if data[:3] == b"\x40\x01\x20":
            return [b"\x4f" + data[1:4] + b"\x11\0\0\0"]
        return [MISSING[:1] + data[1:4] + MISSING[4:]] if data[0] == 0x40 else []

    with undiscovered(Scripted(answers), objects=()) as bench:
        found = search(bench, [0x2001, 0x2002])
    assert found.values == {Multiplexer(0x2001): b"\x11"}


def test_a_value_that_changes_moves() -> None:
    ticks = iter(range(100))

    def answers(data: bytes) -> list[bytes]:
        if data == READ:
            return [BASELINE]
        if data[:4] == b"\x40\x01\x20\0":
            return [b"\x4b\x01\x20\0" + next(ticks).to_bytes(4, "little")]
        return [MISSING[:1] + data[1:4] + MISSING[4:]] if data[0] == 0x40 else []

    with undiscovered(Scripted(answers), objects=()) as bench:
        found = search(bench, [0x2001, 0x2002])
    assert found.moving == found.values.keys() == {Multiplexer(0x2001)}


def test_a_device_that_passes_over_reads_does_not_cost_hours() -> None:
    def answers(data: bytes) -> list[bytes]:
        return [BASELINE] if data == READ else []

    node = Scripted(answers)
    with undiscovered(node, timeout=0.05, objects=()) as bench:
        found = search(bench, range(0x2000, 0x9FFF))
    assert found.ended == (
        f"the search ended at 2002h: {READS_WITHOUT_ANSWER} reads in a row were not answered as "
        "they have to be"
    )
    assert found.values == {}
    asked = sum(data[:1] == b"@" and data != READ for data in node.requests)
    # Where this machine has paused, a silence is doubtful and the read is repeated.
    assert READS_WITHOUT_ANSWER <= asked <= 2 * READS_WITHOUT_ANSWER
