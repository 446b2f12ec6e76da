"""What only the makers of this drive know about it; the suite knows the protocol."""

import struct

import pytest

from conformance import AbortCode, Device, Dialogue, Multiplexer, ServerAborted, UploadInitiate

VENDOR_ID = Multiplexer(0x1018, 1)
TARGET_SPEED = Multiplexer(0x2004)
SERVICE_ONLY = Multiplexer(0x2FFF)


@pytest.fixture
def target_speed(sdo: Dialogue) -> int:
    """The speed that the drive is to reach, as it is before the test."""
    (speed,) = struct.unpack("<I", sdo.upload(TARGET_SPEED))
    return int(speed)


def test_it_is_one_of_ours(sdo_device: Device) -> None:
    """What the run has read at its beginning need not be read again."""
    assert sdo_device.values[VENDOR_ID] == struct.pack("<I", 0x5D0C0000)


@pytest.mark.parametrize("speed", [0, 1, 3000])
def test_a_speed_is_taken(sdo: Dialogue, target_speed: int, speed: int) -> None:
    """The suite writes the old value back, whatever becomes of the test."""
    assert speed != target_speed
    sdo.download(TARGET_SPEED, struct.pack("<I", speed))
    assert sdo.upload(TARGET_SPEED) == struct.pack("<I", speed)


def test_a_service_object_is_hidden(sdo: Dialogue) -> None:
    """Frame by frame: any other answer fails the test, with the frames as evidence."""
    sdo.send(UploadInitiate(SERVICE_ONLY))
    sdo.expect_abort(AbortCode.OBJECT_MISSING, of=SERVICE_ONLY)


def test_a_refusal_as_an_exception(sdo: Dialogue) -> None:
    """``upload`` has to be served; what ``read`` asks for may be refused."""
    with pytest.raises(ServerAborted) as refused:
        sdo.read(SERVICE_ONLY)
    assert refused.value.abort.code == AbortCode.OBJECT_MISSING
