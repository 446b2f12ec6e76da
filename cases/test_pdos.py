"""PDOs: what they map, how that changes, and what does not change while they are valid."""

from conformance.device.device import Device
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.mapped_objects import (
    another_entry,
    expect_mapped,
    forbidden,
    unmappable,
)
from conformance.dialogue.parameters import CONSTANT, PDOS, CobIdEntry, Parameters, number_of
from conformance.run import object_choices as choose
from conformance.run.case import must
from conformance.sdo.frames import DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access
from conformance.sdo.pdos import (
    INHIBIT_TIME,
    MOST_BITS,
    MOST_MAPPED,
    SYNC_START,
    Mapped,
    is_multiplexed,
)
from conformance.sdo.rules import Rule, pdos
from conformance.sdo.seen import Data, Received, said

TOO_MANY = (MOST_MAPPED + 1, 0xFD)
SENT = PDOS["1800h"]
KEPT = {
    f"1800h:{sub_index:02X}": Multiplexer(SENT.mux.index, sub_index)
    for sub_index in (INHIBIT_TIME, SYNC_START)
}


# What is mapped


@must("pdo.mapping-in-use", mapping=choose.mappings)
def test_mapping_in_use(sdo: Dialogue, parameters: Parameters, mapping: int) -> None:
    """What a PDO maps exists, may be mapped, and has as many bits as are mapped of it."""
    count = Multiplexer(mapping)
    for known in sdo.device.objects:
        if known.mux.index == mapping and known.refuses_scan:
            raise NotTestable(f"the EDS asks tools not to read {known} (ObjFlags)")
    value = parameters.present(count)
    if is_multiplexed(count, value):
        raise NotTestable(f"{count} reads {value.hex().upper()}h: the PDO is multiplexed")
    if number_of(value) > MOST_MAPPED:
        raise sdo.breach(f"{count} reads {MOST_MAPPED:X}h at most", Data(value))
    bits = 0
    for sub_index in range(1, number_of(value) + 1):
        entry = Multiplexer(mapping, sub_index)
        mapped = Mapped.of(number_of(sdo.upload(entry)))
        expect_mapped(sdo, entry, mapped)
        bits += mapped.bits
    if bits > MOST_BITS:
        raise sdo.breach(
            f"{MOST_BITS} bits at most in {mapping:04X}h", said("{} bits are mapped", bits)
        )


@must("pdo.mappable", pdo=PDOS)
def test_mappable(sdo: Dialogue, device: Device, parameters: Parameters, pdo: CobIdEntry) -> None:
    """An object that the EDS keeps from PDOs (PDOMapping=0) is not mapped."""
    entry = unmappable(device, pdo)
    with parameters.free_mapping(pdo) as (count, _):
        parameters.expect_not_mapped(count, [int(entry)], pdos.MAPPABLE)


@must("pdo.mapped-access", pdo=PDOS)
def test_mapped_access(
    sdo: Dialogue, device: Device, parameters: Parameters, pdo: CobIdEntry
) -> None:
    """A received PDO maps nothing that is read-only, a sent one nothing that is write-only."""
    entry = forbidden(device, pdo)
    with parameters.free_mapping(pdo) as (count, _):
        parameters.expect_not_mapped(count, [int(entry)], pdos.ACCESS)


@must("pdo.mapping-count", pdo=PDOS)
def test_mapping_count(sdo: Dialogue, parameters: Parameters, pdo: CobIdEntry) -> None:
    """A mapping of 41h to FDh entries is refused: there are 40h at most."""
    with parameters.free_mapping(pdo) as (count, _):
        for number in TOO_MANY:
            refuse_value(sdo, count, bytes([number]), pdos.COUNT)


# How it changes


@must("pdo.mapping-taken", pdo=PDOS)
def test_mapping_taken(
    sdo: Dialogue, device: Device, parameters: Parameters, pdo: CobIdEntry
) -> None:
    """A PDO out of use takes 0 entries, then its mapping, their number, and its COB-ID again."""
    with parameters.out_of_use(pdo) as before:
        count, values = parameters.mapping_of(pdo)
        entries = {Multiplexer(count.index, sub): value for sub, value in enumerate(values, 1)}
        map_nothing(sdo, device, parameters, count)
        due = {**entries, count: bytes([len(values)]), pdo.mux: before.to_bytes(4, "little")}
        for mux, value in due.items():
            abort = parameters.write(mux, value)
            if abort is None:
                continue
            if abort.code in CONSTANT and mux in entries:
                raise Unimplemented(Received(abort))
            raise sdo.breach(f"{mux} takes {value.hex(' ')}", Received(abort))
        for mux, value in due.items():
            if (found := sdo.upload(mux)) != value:
                raise sdo.breach(
                    f"{mux} reads {value.hex(' ')} as written", said("{}", found.hex(" "))
                )


@must("pdo.mapping-while-valid", "pdo.mapping-procedure", pdo=PDOS)
def test_mapping_while_valid(
    sdo: Dialogue, device: Device, parameters: Parameters, pdo: CobIdEntry
) -> None:
    """A valid PDO refuses another mapping: an entry of it, and the number of entries."""
    with parameters.out_of_use(pdo) as before:
        count, mapped = changeable_mapping(parameters, pdo)
        first = Multiplexer(count.index, 1)
        parameters.learn(first)
        parameters.require_used(pdo, before)
        refuse_value(sdo, first, another_entry(device, pdo, mapped), pdos.PROCEDURE)
        refuse_value(sdo, count, b"\0", pdos.PROCEDURE)


@must("pdo.mapping-while-counted", "pdo.mapping-procedure", pdo=PDOS)
def test_mapping_while_counted(
    sdo: Dialogue, device: Device, parameters: Parameters, pdo: CobIdEntry
) -> None:
    """A PDO out of use refuses another entry as long as some are in use: their number is not 0."""
    with parameters.out_of_use(pdo):
        count, mapped = changeable_mapping(parameters, pdo)
        first = Multiplexer(count.index, 1)
        parameters.learn(first)
        refuse_value(sdo, first, another_entry(device, pdo, mapped), pdos.PROCEDURE)


@must("pdo.kept-while-valid", entry=KEPT)
def test_kept_while_valid(sdo: Dialogue, parameters: Parameters, entry: Multiplexer) -> None:
    """The inhibit time and the SYNC start value of a valid PDO do not change."""
    with parameters.out_of_use(SENT) as before:
        value = parameters.present(entry)
        parameters.write_if_configurable(entry, value)
        parameters.require_used(SENT, before)
        other = number_of(value) ^ 1
        refuse_value(sdo, entry, other.to_bytes(len(value), "little"), pdos.KEPT_WHILE_VALID)


def map_nothing(sdo: Dialogue, device: Device, parameters: Parameters, count: Multiplexer) -> None:
    """Write 0 to the number of entries, which a mapping takes that is not fixed."""
    abort = parameters.write(count, b"\0")
    if abort is None:
        return
    refusal = Received(abort)
    if abort.code in CONSTANT:
        raise Unimplemented(refusal)
    listed = device.listing.find(count)
    changes = listed is not None and listed.access is Access.RW
    if changes and device.listing.is_complete and abort.code not in pdos.REMAPPED.codes:
        raise sdo.breach(f"{count}, which the EDS calls rw, takes 00", refusal)
    raise NotTestable(f"{count} does not take 00 now: {refusal.words}")


def changeable_mapping(parameters: Parameters, pdo: CobIdEntry) -> tuple[Multiplexer, list[int]]:
    """Return where the number of entries is, and what is mapped; raises where that is fixed."""
    count, values = parameters.mapping_of(pdo)
    if not values:
        raise NotTestable(f"{count} maps nothing: map an object")
    parameters.write_if_configurable(count, bytes([len(values)]))
    return count, [number_of(value) for value in values]


def refuse_value(sdo: Dialogue, mux: Multiplexer, data: bytes, rule: Rule) -> None:
    """Write a value that has to be refused, and see that the one of before stays."""
    before = sdo.upload(mux)
    sdo.send(DownloadInitiate.with_data(mux, data))
    sdo.expect_abort(*rule.codes, of=mux, tolerated=rule.tolerated)
    if (found := sdo.upload(mux)) != before:
        raise sdo.breach(f"{mux} reads {before.hex(' ')} as before", said("{}", found.hex(" ")))
