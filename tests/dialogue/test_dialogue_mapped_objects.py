"""Which objects a PDO is offered in cases, and what is said of those that it maps."""

from contextlib import nullcontext
from dataclasses import replace

import pytest
from support.run_bench import NODE_ID, Recording, discovered

from conformance.device.device import Device
from conformance.device.known_objects import KnownObject, by_multiplexer
from conformance.device.not_testable import NotTestable
from conformance.dialogue.mapped_objects import (
    another_entry,
    expect_mapped,
    forbidden,
    unmappable,
)
from conformance.dialogue.parameters import PDOS
from conformance.reference.built_in_device import reference_entries
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType
from conformance.sdo.pdos import Mapped
from conformance.sdo.rules import Violation

RECEIVED, SENT = PDOS["1400h"], PDOS["1800h"]
U8, U32 = DataType.UNSIGNED8, DataType.UNSIGNED32
NUMBER = KnownObject(Multiplexer(0x2004), U32, mappable=True)
OTHER = KnownObject(Multiplexer(0x2014), U32, mappable=True)
KEPT = KnownObject(Multiplexer(0x2024), U32, mappable=False)
FLAG = KnownObject(Multiplexer(0x2034), DataType.BOOLEAN, mappable=False)
TEXT = KnownObject(Multiplexer(0x2010), DataType.VISIBLE_STRING, mappable=False)
MEASURED = KnownObject(Multiplexer(0x2044), U32, Access.RO, mappable=True)
SERIAL = KnownObject(Multiplexer(0x1018, 4), U32, Access.CONST, mappable=False)
UNKNOWN = KnownObject(Multiplexer(0x2054), U32, Access.RO)
COMMAND = KnownObject(Multiplexer(0x2064), U32, Access.WO)


def device(*objects: KnownObject) -> Device:
    read = {known.mux: b"\1" for known in objects if known.access.readable}
    return Device(NODE_ID, by_multiplexer(objects), read)


def test_what_no_pdo_may_map() -> None:
    there = device(TEXT, FLAG, NUMBER, SERIAL, COMMAND, KEPT)
    assert unmappable(there, SENT).mux == SERIAL.mux
    assert unmappable(there, RECEIVED).mux == KEPT.mux, "its access alone would not keep it out"
    with pytest.raises(NotTestable, match="PDOMapping=0"):
        unmappable(device(TEXT, FLAG, NUMBER), SENT)


def test_what_could_not_be_read_is_not_offered() -> None:
    there = Device(NODE_ID, by_multiplexer([KEPT]))
    with pytest.raises(NotTestable):
        unmappable(there, SENT)


def test_what_its_access_forbids() -> None:
    there = device(SERIAL, UNKNOWN, MEASURED, COMMAND)
    assert forbidden(there, RECEIVED).mux == MEASURED.mux, "nothing else keeps it out"
    assert forbidden(there, SENT).mux == COMMAND.mux
    assert forbidden(device(SERIAL, UNKNOWN), RECEIVED).mux == UNKNOWN.mux
    with pytest.raises(NotTestable, match="write-only"):
        forbidden(device(SERIAL, NUMBER), SENT)


def test_what_an_entry_could_hold_instead() -> None:
    first, second = int(Mapped(NUMBER.mux, 32)), int(Mapped(KEPT.mux, 32))
    short = int(Mapped(Multiplexer(0x2001), 8))
    there = device(KEPT, MEASURED, NUMBER, OTHER)
    assert another_entry(there, SENT, [first, second]) == bytes(Mapped(KEPT.mux, 32))
    assert another_entry(there, SENT, [first, short]) == bytes(Mapped(MEASURED.mux, 32))
    assert another_entry(there, RECEIVED, [first]) == bytes(Mapped(OTHER.mux, 32))
    assert another_entry(device(KEPT), RECEIVED, [first]) == bytes(4)


@pytest.mark.parametrize(
    ("entry", "mapped", "said"),
    [
        (Multiplexer(0x1A00, 1), Mapped(Multiplexer(0x2004), 32), ""),
        (Multiplexer(0x1600, 1), Mapped(Multiplexer(0x2004), 32), ""),
        (Multiplexer(0x1600, 1), Mapped(Multiplexer(0x0005), 8), ""),
        (Multiplexer(0x1600, 1), Mapped(Multiplexer(0x0001), 1), ""),
        (Multiplexer(0x1600, 1), Mapped(Multiplexer(0x0005), 16), "all 8 bits of 0005h:00"),
        (Multiplexer(0x1A00, 1), Mapped(Multiplexer(0x2004), 24), "all 32 bits of 2004h:00"),
        (Multiplexer(0x1A00, 1), Mapped(Multiplexer(0x2FFF), 8), "maps an object that exists"),
        (Multiplexer(0x1A00, 1), Mapped(Multiplexer(0), 0), "maps an object that exists"),
        (Multiplexer(0x1A00, 1), Mapped(Multiplexer(0x2020), 32), "of what can be read"),
        (Multiplexer(0x1600, 1), Mapped(Multiplexer(0x2020), 32), ""),
        (Multiplexer(0x1600, 1), Mapped(Multiplexer(0x1000), 32), "what the EDS lets PDOs map"),
        # It is not in the EDS: nobody knows what it is.
        (Multiplexer(0x1A00, 1), Mapped(Multiplexer(0x2003), 8), ""),
        (Multiplexer(0x1A00, 1), Mapped(Multiplexer(0x2010), 64), ""),
    ],
    ids=str,
)
def test_what_is_mapped(entry: Multiplexer, mapped: Mapped, said: str) -> None:
    listed = [
        NUMBER,
        replace(TEXT, mappable=True),
        KnownObject(Multiplexer(0x1000), U32, Access.CONST, mappable=False),
        KnownObject(Multiplexer(0x2020), U32, Access.WO),
    ]
    with discovered(Recording(reference_entries(NODE_ID)), objects=listed) as bench:
        sdo = bench.dialogue()
        with pytest.raises(Violation) if said else nullcontext() as raised:
            expect_mapped(sdo, entry, mapped)
        assert said in str(raised and raised.value)
        assert sdo.record.written == set()
