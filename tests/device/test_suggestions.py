"""What is suggested where a case lacks an object: one that the device has, of the type it has."""

from collections.abc import Callable

import pytest

from conformance.device.device import Device
from conformance.device.eds_listing import ListedObject, Listing, ObjectType
from conformance.device.known_objects import KnownObject, by_multiplexer
from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.device.object_roles import Roles
from conformance.device.permits import Permits
from conformance.device.safety import WritePolicy
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType


def entry(
    index: int, data_type: DataType, access: Access = Access.RW, name: str = "", flags: int = 0
) -> KnownObject:
    return KnownObject(Multiplexer(index), data_type, access, name=name, flags=flags)


def device(*entries: KnownObject, named: tuple[KnownObject, ...] = ()) -> Device:
    """Return a device with an EDS of these entries, of which some are named."""
    objects = {
        one.mux.index: ListedObject(one.mux.index, ObjectType.VAR, {0: one}) for one in entries
    }
    return Device(
        5,
        by_multiplexer(entries),
        {one.mux: b"longer than seven" for one in entries if one.access.readable},
        policy=WritePolicy([one.mux for one in named]),
        permits=Permits(named),
        listing=Listing(objects, is_complete=True),
    )


def lacking(ask: Callable[[], object]) -> NotTestable:
    with pytest.raises(NotTestable) as caught:
        ask()
    return caught.value


def said(ask: Callable[[], object]) -> str:
    return str(lacking(ask))


SPEED = entry(0x2002, DataType.UNSIGNED16, name="Speed")
LABEL = entry(0x2005, DataType.VISIBLE_STRING, name="Label")
TRACE = entry(0x2006, DataType.OCTET_STRING, Access.WO, name="Trace")
MODEL = entry(0x2007, DataType.VISIBLE_STRING, Access.RO, name="Model")


def test_an_object_of_the_eds_with_its_type() -> None:
    roles = Roles(device(entry(0x2001, DataType.UNSIGNED32), SPEED, LABEL, TRACE, MODEL))
    assert said(lambda: roles.number(2)) == (
        "needs a writable number of 2 bytes: add --sdo-object=2002=unsigned16 if 2002h:00 (Speed) "
        "may be written"
    )
    assert lacking(lambda: roles.number(2)).missing == Missing(Lack.OBJECT, "2002=unsigned16")
    assert "add --sdo-object=2001=unsigned32 if" in said(roles.number), "the longest that is used"
    assert "add --sdo-object=2005=visible_string if" in said(roles.text)
    assert "add --sdo-object=2005=visible_string if" in said(roles.variable)
    assert "add --sdo-object=2006=octet_string,wo if" in said(roles.write_only)
    assert "add --sdo-object=2007=visible_string,ro if 2007h:00 (Model) has to refuse" in said(
        roles.read_only_text
    )
    assert "add --sdo-object=2001=unsigned32 if" in said(roles.writable)
    assert "needs two writable objects" in said(roles.two_writable)


def test_what_does_least_harm_comes_first() -> None:
    limited = KnownObject(Multiplexer(0x2003), DataType.UNSIGNED16, low=1)
    other = entry(0x2009, DataType.UNSIGNED16)
    known = (
        entry(0x2000, DataType.UNSIGNED16, name="Node-ID"),
        entry(0x2001, DataType.UNSIGNED16, flags=1),
        limited,
        other,
        entry(0x6040, DataType.UNSIGNED16),
    )
    assert "=2009=unsigned16" in said(lambda: Roles(device(*known)).number(2))
    without = [one for one in known if one is not other]
    assert "=2003=unsigned16" in said(lambda: Roles(device(*without)).number(2))


@pytest.mark.parametrize(
    "known",
    [
        *(
            entry(0x2011, DataType.UNSIGNED16, name=name)
            for name in ("Node-ID", "Firmware", "Program data", "Download area", "Update image")
        ),
        entry(0x6060, DataType.UNSIGNED16, name="Modes of operation"),
    ],
    ids=str,
)
def test_what_may_do_harm_is_never_suggested(known: KnownObject) -> None:
    """Of them, ``init`` says why; to be read they may be named."""
    advice = lacking(lambda: Roles(device(known)).number(2))
    assert advice.missing is None
    assert str(advice) == (
        "needs a writable number of 2 bytes: by its name or its profile, each that the EDS lists "
        "may do harm when it is written ('conformance init' lists them)"
    )
    refusal = Permits().refusal(known)
    assert refusal is not None
    assert "may do harm" in str(refusal)
    assert refusal.missing is None


def test_a_domain_for_firmware_is_no_example_of_what_is_write_only() -> None:
    firmware = entry(0x2011, DataType.DOMAIN, Access.WO, name="Firmware")
    assert "--sdo-object" not in said(Roles(device(firmware)).write_only)
    assert "=2006=octet_string,wo if" in said(Roles(device(firmware, TRACE)).write_only)


def test_where_the_eds_has_none() -> None:
    assert said(lambda: Roles(device(LABEL)).number(2)) == (
        "needs a writable number of 2 bytes: the EDS lists none that could be added"
    )
    communication = entry(0x1017, DataType.UNSIGNED16)
    assert "the EDS lists none" in said(lambda: Roles(device(communication)).number(2))


def test_what_is_permitted_already_is_not_suggested() -> None:
    roles = Roles(device(SPEED, entry(0x2009, DataType.UNSIGNED16), named=(SPEED,)))
    assert roles.number(2) == SPEED
    assert "needs another writable object: add --sdo-object=2009=unsigned16 if" in said(
        roles.two_writable
    )


def test_without_an_eds_it_is_an_example() -> None:
    assert said(lambda: Roles(Device(5)).number(2)) == (
        "needs a writable number of 2 bytes: name one of the device with its type, as in "
        "--sdo-object=2001=unsigned16 (2001h is an example; 'conformance init' looks for objects)"
    )
