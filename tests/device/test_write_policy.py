"""Nothing is written but what the user named, and what a device has to refuse."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from conformance.bus.errors import WriteNotPermitted
from conformance.device.protected_objects import (
    NMT,
    PERMISSIONS,
    READ_ONLY_PROBES,
    SDO_PARAMETERS,
    PermissionNameError,
    parse_permission,
)
from conformance.device.safety import WritePolicy
from conformance.sdo.decoding import decode_request, decode_segment
from conformance.sdo.layout import Multiplexer

# A busy machine is no failure.
UNHURRIED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])


def check(policy: WritePolicy, frame: bytes) -> None:
    policy.check(decode_request(frame.ljust(8, b"\0")))


NAMED = Multiplexer(0x2010, 1)
POLICY = WritePolicy([NAMED, Multiplexer(0x2001)])

WRITES_2010_01 = [
    "2F 10 20 01 00 00 00 00",
    "22 10 20 01 00 00 00 00",
    "21 10 20 01 08 00 00 00",
    "20 10 20 01 00 00 00 00",
    "3F 10 20 01 00 00 00 00",
    "C0 10 20 01 00 00 00 00",
    "C6 10 20 01 08 00 00 00",
    "DE 10 20 01 08 00 00 00",
    "23 10 20 01",
]
# Requests that write nothing by themselves, whatever bytes 1 to 3 are.
HARMLESS = [
    "40 17 10 00 00 00 00 00",
    "60 17 10 00 00 00 00 00",
    "00 17 10 00 00 00 00 00",
    "1F 17 10 00 00 00 00 00",
    "80 17 10 00 00 00 00 08",
    "A4 17 10 00 7F 00 00 00",
    "A3 17 10 00 00 00 00 00",
    "C1 17 10 00 00 00 00 00",
    "E0 17 10 00 00 00 00 00",
    "40 17",
    "",
]


@pytest.mark.parametrize("frame", WRITES_2010_01)
def test_named_objects_may_be_written(frame: str) -> None:
    check(POLICY, bytes.fromhex(frame))


@pytest.mark.parametrize("frame", WRITES_2010_01)
def test_others_may_not(frame: str) -> None:
    with pytest.raises(WriteNotPermitted, match=r"2010h:01, which is not .* --sdo-object=2010:01"):
        check(WritePolicy([Multiplexer(0x2010, 0)]), bytes.fromhex(frame))


@pytest.mark.parametrize("frame", HARMLESS)
def test_what_writes_nothing_may_be_sent(frame: str) -> None:
    check(WritePolicy([]), bytes.fromhex(frame))


@pytest.mark.parametrize(
    ("frame", "target"),
    [
        ("23", "0000h:00"),
        ("2F 17", "0017h:00"),
        ("2F 17 10", "1017h:00"),
        ("C2 17 10", "1017h:00"),
    ],
)
def test_short_frames_count_as_if_filled_with_0(frame: str, target: str) -> None:
    with pytest.raises(WriteNotPermitted, match=target):
        check(POLICY, bytes.fromhex(frame))


def test_a_segment_of_a_block_is_no_initiate() -> None:
    """Within a sub-block byte 0 is the sequence number, here 33 and 66."""
    for frame in (bytes.fromhex("2117100000000000"), bytes.fromhex("C217100000000000")):
        WritePolicy([]).check(decode_segment(frame))


@pytest.mark.parametrize("index", [0x1000, 0x1008, 0x1009, 0x100A, 0x1018])
def test_identity_may_be_probed_because_it_is_read_only(index: int) -> None:
    allowing = WritePolicy([], frozenset({READ_ONLY_PROBES}))
    for mux in (Multiplexer(index), Multiplexer(index, 1)):
        assert allowing.permits(mux)
        assert not WritePolicy([]).permits(mux)
        assert WritePolicy([]).needs_probes(mux)
        assert not allowing.needs_probes(mux)
        assert WritePolicy([mux]).permits(mux), "the user named it"


@pytest.mark.parametrize(
    "index",
    [0x1001, 0x1005, 0x1010, 0x1011, 0x1014, 0x1017, 0x1020, 0x1200, 0x1400, 0x1F50, 0x1F80],
)
def test_what_changes_a_device_may_not_be_written(index: int) -> None:
    assert not WritePolicy([]).permits(Multiplexer(index))
    assert not WritePolicy([]).permits(Multiplexer(index, 1))


PROTECTED = [
    *(0x1010, 0x1011, 0x1014, 0x1015, 0x1016, 0x1017, 0x1020, 0x1200, 0x1201, 0x127F, 0x1280),
    *(0x12FF, 0x1400, 0x1600, 0x1800, 0x1A00, 0x1BFF, 0x1F50, 0x1F57, 0x1F80),
]


@pytest.mark.parametrize("index", PROTECTED)
def test_naming_a_protected_object_is_no_permission(index: int) -> None:
    mux = Multiplexer(index, 1)
    policy = WritePolicy([mux])
    policy.allow_missing(mux)
    assert not policy.permits(mux)
    with pytest.raises(
        WriteNotPermitted, match=r"a permission is needed to write .*: --sdo-allow="
    ):
        policy.check(decode_request(b"\x2f" + index.to_bytes(2, "little") + bytes(5)))


@pytest.mark.parametrize(
    ("permission", "permitted"),
    [
        (NMT, {0x1017}),
        (SDO_PARAMETERS, {0x1200, 0x1201, 0x127F, 0x1280, 0x12FF}),
    ],
)
def test_what_a_permission_permits(permission: str, permitted: set[int]) -> None:
    policy = WritePolicy([], frozenset([permission]))
    assert {index for index in PROTECTED if policy.permits(Multiplexer(index, 1))} == permitted
    assert not policy.permits(Multiplexer(0x2001))


@pytest.mark.parametrize("permission", sorted(PERMISSIONS))
def test_permissions_have_names(permission: str) -> None:
    assert parse_permission(permission) == permission


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("nmtt", "Did you mean 'nmt'?"),
        ("sdo", "Did you mean 'sdo-parameters'?"),
        ("x", "Known: clear-errors, configuration-date, "),
        ("NMT", "Did you mean 'nmt'?"),
    ],
)
def test_no_permission_of_that_name(name: str, hint: str) -> None:
    with pytest.raises(PermissionNameError, match=hint.replace("?", r"\?")):
        parse_permission(name)


def test_what_a_device_lacks_may_be_probed() -> None:
    policy = WritePolicy([], frozenset({READ_ONLY_PROBES}))
    missing = Multiplexer(0x1004)
    assert not policy.permits(missing)
    policy.allow_missing(missing)
    assert policy.permits(missing)
    assert not policy.permits(Multiplexer(0x1004, 1))
    assert not WritePolicy([]).permits(missing)


@UNHURRIED
@given(st.binary(max_size=8))
def test_exactly_initiates_of_downloads_are_held_back(frame: bytes) -> None:
    """Bits 7 to 5 are 1, or 6 with bit 0 clear (CiA 301, 7.2.4.3.3 and 7.2.4.3.9)."""
    filled = frame.ljust(8, b"\0")
    held_back = filled[0] >> 5 == 1 or (filled[0] >> 5 == 6 and not filled[0] & 1)
    try:
        check(WritePolicy([]), frame)
    except WriteNotPermitted:
        assert held_back
    else:
        assert not held_back
