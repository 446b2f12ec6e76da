"""Which object suits a case: the cheapest that will do."""

from collections.abc import Iterable
from dataclasses import replace

import pytest

from conformance.device.device import Device
from conformance.device.effort import OBJECTS_IN_HASTE, THOUSANDS_OF_SEGMENTS, Effort
from conformance.device.known_objects import KnownObject, by_multiplexer
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.device.permits import Permits
from conformance.device.safety import WritePolicy
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Habits

NUMBER = KnownObject(Multiplexer(0x2001), DataType.UNSIGNED16)
TEXT = KnownObject(Multiplexer(0x2010), DataType.VISIBLE_STRING)
DOMAIN = KnownObject(Multiplexer(0x2020), DataType.DOMAIN)
LONG = 4096
UNNAMED = Permits()


def device(
    known: Iterable[KnownObject] = (NUMBER, TEXT, DOMAIN), permits: Permits = UNNAMED
) -> Device:
    objects = by_multiplexer(known)
    found = Device(5, objects, policy=WritePolicy(objects), permits=permits)
    found.values.update(dict.fromkeys(objects, b"as it was"))
    return found


def chosen(of: Device) -> dict[int, KnownObject]:
    """Return what is taken for values of so many bytes."""
    return {size: Roles(of).variable(size) for size in (3, 20, 64, 257)}


def test_a_domain_is_taken_where_nothing_is_known() -> None:
    assert set(chosen(device()).values()) == {DOMAIN}


@pytest.mark.parametrize("kind", ["filled", "lasting", "fixed"])
def test_what_always_reads_long_is_taken_for_long_values_only(kind: str) -> None:
    """Each reading of it costs its whole length."""
    of = device()
    lengths = of.learned.lengths[DOMAIN.mux]
    match kind:
        case "filled":
            lengths.filled = LONG
        case "lasting":
            lengths.lasting = lengths.most = LONG
        case "fixed":
            lengths.fixed, lengths.most = True, LONG
    of.learned.lengths[TEXT.mux].most = 100
    assert chosen(of) == {3: TEXT, 20: TEXT, 64: TEXT, 257: DOMAIN}
    assert Roles(of).two_writable() == (TEXT, NUMBER)


def test_what_is_filled_up_to_little_is_taken_as_well() -> None:
    of = device()
    of.learned.lengths[DOMAIN.mux].filled = 64
    assert set(chosen(of).values()) == {DOMAIN}
    assert Roles(of).two_writable() == (TEXT, DOMAIN)


def test_what_takes_thousands_of_requests_to_put_back_is_left_alone() -> None:
    """Also for long values, as long as the other object is not known to be shorter."""
    of = device()
    of.values[DOMAIN.mux] = bytes(THOUSANDS_OF_SEGMENTS + 1)
    assert set(chosen(of).values()) == {TEXT}
    assert Roles(of).two_writable() == (TEXT, NUMBER)
    assert of.briefly_read() == [NUMBER.mux, TEXT.mux]
    assert set(chosen(device([NUMBER, DOMAIN])).values()) == {DOMAIN}, "there is no other"
    of.learned.lengths[TEXT.mux].most = 100
    assert chosen(of)[257] == DOMAIN


def test_what_the_user_has_named_for_long_transfers_is_taken_for_these() -> None:
    of = device(permits=Permits(large=DOMAIN))
    of.values[DOMAIN.mux] = bytes(THOUSANDS_OF_SEGMENTS + 1)
    assert chosen(of) == {3: TEXT, 20: TEXT, 64: TEXT, 257: DOMAIN}


def test_what_is_too_short_comes_last() -> None:
    of = device(permits=Permits())
    of.learned.lengths[DOMAIN.mux].lasting = of.learned.lengths[DOMAIN.mux].most = LONG
    of.learned.lengths[TEXT.mux].most = 19
    assert chosen(of) == {3: TEXT, 20: DOMAIN, 64: DOMAIN, 257: DOMAIN}


def test_a_text_that_always_costs_many_requests_comes_behind_a_domain() -> None:
    of = device()
    of.learned.lengths[TEXT.mux].filled = LONG
    assert Roles(of).text() == DOMAIN


def test_nothing_is_written_that_would_stay() -> None:
    """Few bytes are for those who write them to refuse: they may take fewer."""
    of = device([replace(TEXT, habits=Habits(keeps_tails=True))])
    lengths = of.learned.lengths[TEXT.mux]
    lengths.lasting = lengths.most = 19
    assert Roles(of).variable(20).mux == TEXT.mux
    with pytest.raises(NotTestable, match=r"65 bytes would never be the 19 again .* name a larger"):
        Roles(of).variable(65)
    with pytest.raises(NotTestable, match="20 bytes would never be"):
        lengths.check_lasting(TEXT, 20)
    lengths.check_lasting(TEXT, 19)


def test_a_value_that_is_always_long_does_where_there_is_no_other() -> None:
    of = device([NUMBER, DOMAIN])
    of.learned.lengths[DOMAIN.mux].filled = LONG
    assert Roles(of).variable() == Roles(of).text() == DOMAIN


@pytest.mark.parametrize("effort", [Effort.USUAL, Effort.HASTE])
def test_in_haste_some_of_very_many_stand_for_all(effort: Effort) -> None:
    indices = range(0x2000, 0x2000 + 2 * OBJECTS_IN_HASTE + 1)
    of = device(
        [KnownObject(Multiplexer(index), DataType.UNSIGNED16) for index in indices],
        Permits(effort=effort),
    )
    brief = of.briefly_read()
    assert brief[0].index == indices[0]
    assert brief[-1].index >= indices[-3]
    if effort is Effort.HASTE:
        assert OBJECTS_IN_HASTE // 2 < len(brief) <= OBJECTS_IN_HASTE
    else:
        assert len(brief) == len(indices)
