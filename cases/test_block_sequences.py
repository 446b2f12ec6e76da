"""Block transfers before and behind others: nothing of one shows in the next (7.2.4.2)."""

from collections.abc import Callable

from conformance.device.known_objects import KnownObject
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.values import same_value
from conformance.run.case import must
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.describe import shown
from conformance.sdo.frames import Abort
from conformance.sdo.seen import Data

WRITE: dict[str, Callable[[Dialogue, KnownObject, bytes], None]] = {
    "block": lambda sdo, known, data: Blocks(sdo).download(known, data),
    "block-unsized": lambda sdo, known, data: Blocks(sdo).download(known, data, sized=False),
    "segmented": lambda sdo, known, data: Room(sdo).store(known, data, segmented=True),
    "expedited": lambda sdo, known, data: Room(sdo).store(known, data[:3]),
}
READ: dict[str, Callable[[Dialogue, KnownObject], bytes]] = {
    "block": lambda sdo, known: Blocks(sdo).upload(known).data,
    "segmented": lambda sdo, known: sdo.upload(known),
}
PAIRS = {
    f"{first}-then-{second}-read-{read}": (first, second, read)
    for first in WRITE
    for second in WRITE
    for read in READ
    if "block" in f"{first}{second}{read}"
}


@must("block-sequence.pairs", "server.idle-afterwards", pair=PAIRS)
def test_pairs(
    sdo: Dialogue, room: Room, variable: KnownObject, pair: tuple[str, str, str]
) -> None:
    """Two downloads in a row, of whatever kind, each read back: the object holds the last."""
    first, second, read = pair
    for kind, size in ((first, 26), (second, 17)):
        data = sdo.payload(room.fit(variable, size))
        WRITE[kind](sdo, variable, data)
        due = data[:3] if kind == "expedited" else data
        found = READ[read](sdo, variable)
        if not same_value(variable, found, due):
            raise sdo.breach(f"{variable} reads {shown(due)}", Data(found))


@must("block-sequence.abandoned-download", "server.nothing-afterwards")
def test_abandoned_download(sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject) -> None:
    """Segments of a block download that was aborted do not turn up in the next one."""
    size = room.fit(text, 12)
    kinds = list(WRITE) if room.fit(text, 3) == 3 else ["block", "segmented"]
    response = blocks.initiate_download(text, len(room.prepare(text, 30, least=15)))
    if response.block_size > 2:
        blocks.send_segments([sdo.payload(7), sdo.payload(7)])
    sdo.send(Abort(text.mux, AbortCode.TIMED_OUT))
    for kind in kinds:
        data = sdo.payload(size)
        WRITE[kind](sdo, text, data)
        sdo.expect_value(text, data[:3] if kind == "expedited" else data)


@must("block-sequence.abandoned-upload", "server.nothing-afterwards", "block-upload.client-abort")
def test_abandoned_upload(sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject) -> None:
    """A block upload that was aborted starts again from the first byte."""
    data = room.prepare(variable, 40, least=15)
    blocks.initiate_upload(variable, block_size=2)
    blocks.start_upload(variable, 2)
    sdo.send(Abort(variable.mux, AbortCode.TIMED_OUT))
    for read in READ.values():
        found = read(sdo, variable)
        if not same_value(variable, found, data):
            raise sdo.breach(f"{variable} reads {shown(data)}", Data(found))
