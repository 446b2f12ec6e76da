"""Very long values are read in blocks, once the device was seen to serve those."""

from conformance.device.effort import LONG_VALUE, SEGMENTS_COMPARED
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.sdo.checks import ServerAborted
from conformance.sdo.decoding import as_answer
from conformance.sdo.frames import UploadInitiate, UploadInitiateResponse
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation


def read_in_blocks(sdo: Dialogue, mux: Multiplexer) -> bytes | None:
    """Read in blocks what announces that it is very long, and begins in segments as in blocks.

    None where it has to be read in segments to the end: to know what it is, or what is wrong.
    """
    blocks = Blocks(sdo)
    sdo.send(UploadInitiate(mux))
    response = as_answer(sdo.receive())
    sdo.end_transfer()
    size = response.size if isinstance(response, UploadInitiateResponse) else None
    if size is None or size <= LONG_VALUE or not blocks.read_alike():
        return None
    sdo.start_segmented_upload(mux)
    begun = b"".join(
        sdo.upload_segment(toggle=number % 2).data for number in range(SEGMENTS_COMPARED)
    )
    sdo.end_transfer()
    try:
        found = sdo.run(sdo.client.block_upload(mux)).data
    except (Violation, ServerAborted):
        sdo.silence.recover()
        return None
    return found if len(found) == size and found.startswith(begun) else None
