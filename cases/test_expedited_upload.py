"""Upload initiate with an answer of up to 4 bytes (CiA 301, 7.2.4.3.6)."""

from conformance.device.device import DEVICE_TYPE
from conformance.run.case import must
from conformance.run.dialogue import Dialogue


@must("upload.device-type", clause="7.5.2.1")
def test_device_type(sdo: Dialogue) -> None:
    """The device type (1000h), which every device has, reads as 4 bytes."""
    data = sdo.upload(DEVICE_TYPE)
    if len(data) != 4:
        raise sdo.breach("4 bytes", f"{len(data)} bytes")
