"""Whether a device cuts the values of a string or domain to a length of its own."""

from dataclasses import replace

from conformance.device.known_objects import KnownObject
from conformance.dialogue.dialogue import Dialogue
from conformance.sdo.limits import SEGMENT_LENGTH

# Two lengths in bytes: an object that keeps as many of either is a buffer.
BUFFER, LARGER = 50, 64
WAYS = ((BUFFER, False), (LARGER, False), (LARGER, True))


def find_cut(sdo: Dialogue, known: KnownObject) -> None:
    """Find out how many bytes an object keeps of a longer value, if it takes that and cuts it.

    A server that loses segments keeps as many as it took by one protocol, and another number by
    the other; one that loses the end of a value keeps more of a longer one.
    """
    lengths = sdo.device.learned.lengths[known.mux]
    if known.habits.keeps_tails or lengths.most is not None or lengths.least > BUFFER:
        return  # of the first, the end of what is written here would stay
    kept = {_kept(sdo, known, size, in_blocks=in_blocks) for size, in_blocks in WAYS}
    kept.discard(None)
    if len(kept) != 1:
        return
    (cut,) = kept
    if cut is not None and SEGMENT_LENGTH < cut < BUFFER:
        sdo.device.learn(known, replace(known.habits, cut=cut))
        lengths.most = cut


def _kept(sdo: Dialogue, known: KnownObject, size: int, *, in_blocks: bool) -> int | None:
    """Write a value; return how many of its bytes are read, None where it was refused.

    All of them, or others, are as many as were written.
    """
    data = sdo.payload(size)
    transfer = (
        sdo.client.block_download(known.mux, data)
        if in_blocks
        else sdo.client.download(known.mux, data, segmented=True)
    )
    if sdo.abort_of(transfer) is not None:
        return None
    found = sdo.upload(known)
    return len(found) if data.startswith(found) else size
