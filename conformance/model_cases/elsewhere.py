"""Transfers in another NMT state, or on another channel, than those of most cases."""

from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.values import same_value
from conformance.model_cases.conversations.conversation import Kind
from conformance.sdo.describe import in_words, shown
from conformance.sdo.seen import Data

CONVERSATIONS = {
    "segmented": Kind.SEGMENTED_TRANSFERS,
    "block": Kind.BLOCK_TRANSFERS,
    "interrupted": Kind.INTERRUPTED,
}
# Bytes: in segments more than one byte counts, in blocks more than a sub-block has.
LONG = {"segmented": 260, "block": 900}


def require_writes(sdo: Dialogue) -> None:
    """Raise NotTestable where the server refuses writes in its present state, as it may."""
    known = Roles(sdo.device).variable()
    abort = sdo.try_download(known, sdo.upload(known))
    if abort is not None:
        raise NotTestable(f"{known} refuses in this state what it holds: {in_words(abort)}")


def expect_carried(sdo: Dialogue, known: KnownObject, data: bytes, *, in_blocks: bool) -> None:
    """Expect that data are written and read by one protocol."""
    blocks = Blocks(sdo)
    if in_blocks:
        blocks.require_download()
        blocks.require_upload()
        blocks.download(known, data)
        found = blocks.upload(known).data
    else:
        sdo.download(known, data, segmented=True)
        found = sdo.upload(known)
    if not same_value(known, found, data):
        raise sdo.breach(f"{known} reads {shown(data)}", Data(found, known))
