"""COB-IDs as values and on the command line, and what makes an SDO channel."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import RESTRICTED, ChannelError, ChannelIds, ClientParameter, CobId


@pytest.mark.parametrize(
    ("value", "cob_id"),
    [
        (0x0000_0605, CobId(0x605)),
        (0x8000_0000, CobId(0, valid=False)),
        (0xC000_0681, CobId(0x681, valid=False, dynamic=True)),
        (0x38FF_0681, CobId(0x18FF_0681, extended=True)),
        (0x0000_0E81, CobId(0xE81)),
    ],
)
def test_bits(value: int, cob_id: CobId) -> None:
    assert CobId.from_bytes(value.to_bytes(4, "little")) == cob_id
    assert bytes(cob_id) == value.to_bytes(4, "little")


@given(st.binary(min_size=4, max_size=4))
def test_no_bit_gets_lost(value: bytes) -> None:
    assert bytes(CobId.from_bytes(value)) == value


def test_restricted_identifiers() -> None:
    """CiA 301, 7.3.5: the first and the last of each range, and their neighbours."""
    assert {can_id for can_id in range(0x800) if CobId(can_id).is_restricted} == {
        can_id for first, last in RESTRICTED for can_id in range(first, last + 1)
    }
    for free in (0x080, 0x100, 0x181, 0x580, 0x600, 0x680, 0x6DF, 0x700):
        assert not CobId(free).is_restricted
    assert not CobId(0x601, extended=True).is_restricted


def test_which_frames_match() -> None:
    cob_id = CobId(0x605)
    assert cob_id.matches(CanFrame(0x605, bytes(8)))
    assert not cob_id.matches(CanFrame(0x606, bytes(8)))
    assert not cob_id.matches(CanFrame(0x605, bytes(8), extended=True))
    assert not cob_id.matches(CanFrame(0x605, remote=True, length=8))
    assert CobId(0x605, True).frame(b"\1") == CanFrame(0x605, b"\1", extended=True)


@pytest.mark.parametrize(
    ("text", "ids"),
    [
        ("640:5C0", ChannelIds(CobId(0x640), CobId(0x5C0))),
        ("0x681:6a1h", ChannelIds(CobId(0x681), CobId(0x6A1))),
        ("18FF0681:18FF06A1", ChannelIds(CobId(0x18FF_0681, True), CobId(0x18FF_06A1, True))),
        ("0640:5C0", ChannelIds(CobId(0x640, True), CobId(0x5C0))),
    ],
)
def test_channels_on_the_command_line(text: str, ids: ChannelIds) -> None:
    assert ChannelIds.parse(text) == ids


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("640", "write REQUEST:RESPONSE"),
        ("1280", "or FILE:RECORD of the client, as in plc.dcf:1280"),
        ("640:", "'' is no CAN-ID"),
        ("64x:5C0", "'64x' is no CAN-ID"),
        ("800:5C0", "more than 11 bits"),
        ("20000000:5C0", "more than 29 bits"),
        ("640:640", "cannot carry both"),
        ("0:5C0", "NMT commands"),
    ],
)
def test_what_is_no_channel(text: str, reason: str) -> None:
    with pytest.raises(ChannelError, match=reason):
        ChannelIds.parse(text)


def record(request: int, response: int, node_id: int = 5) -> ClientParameter:
    values = {1: request.to_bytes(4, "little"), 2: response.to_bytes(4, "little")}
    return ClientParameter.from_values(values | {3: bytes((node_id,))})


def test_the_channel_of_a_client() -> None:
    assert record(0x640, 0x5C0).channel_to(5) == ChannelIds(CobId(0x640), CobId(0x5C0))


@pytest.mark.parametrize(
    ("parameter", "reason"),
    [
        (record(0x8000_0640, 0x5C0), "640h has bit 31 set"),
        (record(0x640, 0x8000_05C0), "5C0h has bit 31 set"),
        (record(0x1640, 0x5C0), "1640h has more than the 11 bits"),
        (record(0x640, 0x5C0, 0), "0 is no node-ID"),
        (record(0x640, 0x5C0, 128), "128 is no node-ID"),
        (record(0x640, 0x5C0, 6), "its server is node 6, not node 5"),
    ],
)
def test_a_client_without_a_channel(parameter: ClientParameter, reason: str) -> None:
    with pytest.raises(ChannelError, match=reason):
        parameter.channel_to(5)


READ = bytes.fromhex("4000100000000000")
SHORT, LONG = ChannelIds.default(5), ChannelIds.parse("18FF0B05:18FF0C05")


@pytest.mark.parametrize(
    ("frame", "there"),
    [
        (CanFrame(0x605, READ), CanFrame(0x18FF0B05, READ, extended=True)),
        (CanFrame(0x585, READ), CanFrame(0x18FF0C05, READ, extended=True)),
        (CanFrame(0x605, remote=True, length=3), CanFrame(0x18FF0B05, b"", True, True, 3)),
        (CanFrame(0x605, READ, extended=True), CanFrame(0x18FF0B05, READ)),
        (CanFrame(0x606, READ), CanFrame(0x606, READ)),
    ],
)
def test_a_frame_on_another_channel(frame: CanFrame, there: CanFrame) -> None:
    assert SHORT.translated(frame, LONG) == there
    assert LONG.translated(there, SHORT) == frame
    assert SHORT.translated(frame, SHORT) == frame
