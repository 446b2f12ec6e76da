"""What may be written: what was named, or what the EDS calls rw and nothing forbids."""

import pytest

from conformance.device.eds_listing import ListedObject, Listing, ObjectType
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import Lack
from conformance.device.permits import NotPermitted, Permits, known_objects
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType


def known(
    index: int, access: Access = Access.RW, sub_index: int = 0, flags: int = 0
) -> KnownObject:
    return KnownObject(Multiplexer(index, sub_index), DataType.UNSIGNED32, access, flags=flags)


def refusal(permits: Permits, known: KnownObject) -> str:
    return str(permits.refusal(known) or "")


def probe_refusal(permits: Permits, known: KnownObject) -> str:
    return str(permits.probe_refusal(known) or "")


ALL = Permits(all_rw=True)
PROTECTED = [0x1005, 0x1010, 0x1011, 0x1014, 0x1016, 0x1017, 0x1020, 0x1200, 0x1280, 0x1400, 0x1A00]


def test_an_eds_allows_nothing_by_itself() -> None:
    assert "writing it is not permitted" in refusal(Permits(), known(0x2001))


@pytest.mark.parametrize("index", [0x2000, 0x5FFF, 0x6000, 0x9FFF])
def test_all_rw(index: int) -> None:
    assert refusal(ALL, known(index)) == ""
    assert refusal(ALL, known(index, Access.WO)), "there is nothing that could be put back"
    assert "ObjFlags" in refusal(ALL, known(index, flags=1))


@pytest.mark.parametrize("index", [0x1002, 0x1003, 0x100C, 0x1FFF, 0xA000])
def test_all_rw_is_about_the_device_and_its_profile(index: int) -> None:
    assert refusal(ALL, known(index))


@pytest.mark.parametrize("index", [*PROTECTED, 0x1F50, 0x1F80])
def test_denied_objects_take_a_permission(index: int) -> None:
    refused = ALL.refusal(known(index))
    assert refused is not None
    assert refused.missing is not None
    kind, permission = refused.missing
    assert kind is Lack.PERMISSION
    assert f"--sdo-allow={permission}, or [permissions] {permission} = true" in str(refused)
    with pytest.raises(NotPermitted, match=permission):
        Permits((known(index),)).check()
    allowing = Permits((known(index),), permissions=frozenset({permission}))
    allowing.check()
    assert refusal(allowing, known(index)) == ""
    assert refusal(Permits(all_rw=True, permissions=frozenset({permission})), known(index)) == ""
    assert refusal(Permits(permissions=frozenset({permission})), known(index))


def test_named_objects() -> None:
    named = Permits((known(0x1002), known(0x2001, flags=1)))
    named.check()
    assert refusal(named, known(0x1002)) == ""
    assert refusal(named, known(0x2001, flags=1)) == ""
    assert refusal(named, known(0x2001, sub_index=1))


def test_never_is_stronger_than_all() -> None:
    mux = Multiplexer(0x2001)
    never = Permits((known(0x2001),), all_rw=True, never=frozenset({mux}))
    assert refusal(never, known(0x2001)) == "device.toml says that 2001h:00 is never written"
    assert probe_refusal(never, known(0x2001, Access.RO))


def test_read_only_objects_are_probed_with_permission() -> None:
    allowing = Permits(permissions=frozenset({"read-only-probes"}))
    probed = known(0x2001, Access.RO)
    assert "read-only-probes" in probe_refusal(Permits(), probed)
    assert "read-only-probes" in probe_refusal(ALL, probed)
    assert probe_refusal(allowing, probed) == ""
    assert probe_refusal(Permits((probed,)), probed) == ""
    assert "ObjFlags" in probe_refusal(allowing, known(0x2001, Access.RO, flags=1))
    assert "sdo-parameters" in probe_refusal(allowing, known(0x1200, Access.CONST))
    assert "read-only-probes" in probe_refusal(Permits(), known(0x1018, Access.CONST))
    assert probe_refusal(allowing, known(0x1018, Access.CONST)) == ""


def test_allowed_is_what_nothing_forbids() -> None:
    permits = Permits(all_rw=True, permissions=frozenset({"read-only-probes"}))
    objects = [known(0x1017), known(0x2001), known(0x2002, Access.RO), known(0x2003, Access.WO)]
    assert permits.allowed(objects) == [Multiplexer(0x2001), Multiplexer(0x2002)]


def test_what_was_named_is_completed_by_the_eds() -> None:
    mux = Multiplexer(0x2001)
    listed = KnownObject(
        mux, DataType.UNSIGNED16, Access.RO, name="Speed", low=1, high=9, default=b"\x05\0"
    )
    listing = Listing({0x2001: ListedObject(0x2001, ObjectType.VAR, {0: listed})})
    assert known_objects([KnownObject(mux)], listing) == [listed]
    (same_type,) = known_objects([KnownObject(mux, DataType.UNSIGNED16)], listing)
    assert (same_type.access, same_type.high) == (Access.RW, 9)
    other_type = KnownObject(mux, DataType.UNSIGNED32)
    assert known_objects([other_type], listing) == [other_type], "the user's word counts"
    assert known_objects([], listing) == [listed]
