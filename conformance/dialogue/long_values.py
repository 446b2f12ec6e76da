"""Long values are put back in blocks, once the device was seen to serve those."""

from conformance.dialogue.blocks import LONG
from conformance.dialogue.dialogue import Dialogue
from conformance.sdo.checks import ServerAborted
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation


def write_in_blocks(sdo: Dialogue, mux: Multiplexer, value: bytes) -> bool:
    """Write a value in blocks if it is long and a case has done that; say whether it was taken.

    What is written has to be read back; a device that has failed once is not trusted again.
    """
    services = sdo.device.services
    if len(value) <= LONG or not services.takes_blocks or services.distrusted:
        return False
    try:
        sdo.run(sdo.client.block_download(mux, value))
    except (Violation, ServerAborted):
        services.distrusted = True
        sdo.silence.recover()
        return False
    return True
