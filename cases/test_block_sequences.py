"""Block transfers before and behind others: nothing of one shows in the next (7.2.4.2)."""

from collections.abc import Callable

from conformance.device.objects import KnownObject
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.transfers import same_value, shown
from conformance.run.case import must
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import Abort

WRITE: dict[str, Callable[[Dialogue, KnownObject, bytes], None]] = {
    "block": lambda sdo, known, data: sdo.block_download(known, data),
    "block-unsized": lambda sdo, known, data: sdo.block_download(known, data, sized=False),
    "segmented": lambda sdo, known, data: sdo.store(known, data, segmented=True),
    "expedited": lambda sdo, known, data: sdo.store(known, data[:3]),
}
READ: dict[str, Callable[[Dialogue, KnownObject], bytes]] = {
    "block": lambda sdo, known: sdo.block_upload(known).data,
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
def test_pairs(sdo: Dialogue, variable: KnownObject, pair: tuple[str, str, str]) -> None:
    """Two downloads in a row, of whatever kind, each read back: the object holds the last."""
    first, second, read = pair
    for kind, size in ((first, 40), (second, 17)):
        data = sdo.payload(len(sdo.prepare(variable, size)))
        WRITE[kind](sdo, variable, data)
        due = data[:3] if kind == "expedited" else data
        found = READ[read](sdo, variable)
        if not same_value(variable, found, due):
            raise sdo.breach(f"{variable} reads {shown(due)}", shown(found))


@must("block-sequence.abandoned-download", "server.nothing-afterwards")
def test_abandoned_download(sdo: Dialogue, text: KnownObject) -> None:
    """Segments of a block download that was aborted do not turn up in the next one."""
    size = sdo.fit(text, 12)
    kinds = list(WRITE) if sdo.fit(text, 3) == 3 else ["block", "segmented"]
    response = sdo.initiate_block_download(text, len(sdo.prepare(text, 30, least=15)))
    if response.block_size > 2:
        sdo.send_segments([sdo.payload(7), sdo.payload(7)])
    sdo.send(Abort(text.mux, AbortCode.TIMED_OUT))
    for kind in kinds:
        data = sdo.payload(size)
        WRITE[kind](sdo, text, data)
        sdo.expect_value(text, data[:3] if kind == "expedited" else data)


@must("block-sequence.abandoned-upload", "server.nothing-afterwards", "block-upload.client-abort")
def test_abandoned_upload(sdo: Dialogue, variable: KnownObject) -> None:
    """A block upload that was aborted starts again from the first byte."""
    data = sdo.prepare(variable, 40, least=15)
    sdo.initiate_block_upload(variable, block_size=2)
    sdo.start_block_upload(variable, 2)
    sdo.send(Abort(variable.mux, AbortCode.TIMED_OUT))
    for read in READ.values():
        found = read(sdo, variable)
        if not same_value(variable, found, data):
            raise sdo.breach(f"{variable} reads {shown(data)}", shown(found))
