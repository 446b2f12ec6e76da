"""Block uploads that a server has to serve (CiA 301, 7.2.4.3.12 to 7.2.4.3.15)."""

from contextlib import suppress

from conformance.device.device import VENDOR_ID
from conformance.device.effort import SHORT_VALUE
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.device.object_roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.held_values import expect_empty
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.values import same_value, segments_of
from conformance.model_cases.variations import BEYOND_16_BITS, BLOCK_UPLOAD_SIZES
from conformance.run.case import may, must, should
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import wrong_count
from conformance.sdo.checks import ServerAborted
from conformance.sdo.client import Uploaded
from conformance.sdo.describe import in_words, shown
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    UploadInitiate,
)
from conformance.sdo.rules import FILLER, RESERVED, Violation
from conformance.sdo.seen import Data, Received, said

INITIATE = "7.2.4.3.13"
SUB_BLOCK = "7.2.4.3.14"
CRC = "7.2.4.3.16"
LENGTH = 60
# Of two segments each.
THREE_SUB_BLOCKS = 36
PADDED = 5


def expect_data(sdo: Dialogue, known: KnownObject, due: bytes, uploaded: Uploaded) -> None:
    """Compare what a block upload brought."""
    found = sdo.of_its_length(known, uploaded)
    if same_value(known, found, due):
        return
    is_cut = due.startswith(found) or found.startswith(due)
    if is_cut and uploaded.segments == len(segments_of(due)):
        raise wrong_count(f"n that leaves {len(due)} bytes", said("n that leaves {}", len(found)))
    raise sdo.breach(f"{known} reads {shown(due)}", Data(found, known))


def expect_in_blocks(sdo: Dialogue, known: KnownObject, request: BlockUploadInitiate) -> None:
    """Expect a block upload to begin, where pst does not let it become an ordinary one."""
    sdo.send(request)
    response = sdo.receive()
    if isinstance(response, Abort) and response.code == AbortCode.COMMAND_NOT_VALID:
        raise Unimplemented(Received(response))
    if not isinstance(response, BlockUploadInitiateResponse):
        raise sdo.breach(f"C0h to C6h: a block upload of {known}", Received(response))
    sdo.end_transfer()


def reads_in_segments(sdo: Dialogue, known: KnownObject, due: bytes) -> bool:
    """Say whether an ordinary upload brings what a block upload should have brought."""
    sdo.end_transfer()
    with suppress(Violation, ServerAborted):
        found = sdo.upload_while(known, due)
        sdo.end_transfer()
        return same_value(known, found, due)
    sdo.end_transfer()
    return False


@must(
    "block-upload.size",
    "block-upload.first-sub-block",
    "block-upload.next-sub-block",
    "block-upload.end",
    "upload.size",
    "block.crc",
    "crc.algorithm",
    "crc.placement",
    "crc.not-offered",
    size=BLOCK_UPLOAD_SIZES,
)
def test_size(sdo: Dialogue, room: Room, blocks: Blocks, roles: Roles, size: int) -> None:
    """A block upload delivers the bytes of the object, with the right size and CRC."""
    variable, data = roles.variable(size), sdo.payload(size)
    room.store(variable, data, segmented=True)
    expect_data(sdo, variable, data, blocks.upload(variable))


@must("block-upload.beyond-16-bits", "block-upload.next-sub-block", "upload.size")
def test_beyond_16_bits(sdo: Dialogue, room: Room, blocks: Blocks) -> None:
    """More bytes than 16 bits count are read whole, however the object came to them."""
    blocks.require_upload()
    if any(BEYOND_16_BITS in lengths.whole for lengths in sdo.device.learned.lengths.values()):
        return  # segmented-download.beyond-16-bits has written and read it
    # What is wrong with any block upload shows before much is written.
    expect_data(sdo, VENDOR_ID, sdo.upload(VENDOR_ID), blocks.upload(VENDOR_ID))
    known, data = room.object_beyond(BEYOND_16_BITS)
    if known.mux not in sdo.record.written:
        expect_data(sdo, known, data, blocks.upload(known))
        return
    whole = sdo.device.learned.lengths[known.mux].whole
    try:
        expect_data(sdo, known, data, blocks.upload(known))
    except Violation:
        # While it stands there: segmented-download.beyond-16-bits need not write it again.
        if reads_in_segments(sdo, known, data):
            whole.add(len(data))
        expect_data(sdo, known, data, blocks.upload(known))
        raise
    whole.add(len(data))


@must("block-upload.without-crc", "crc.not-asked", "crc.offered-unasked", size=[1, 7, 20])
def test_without_crc(
    sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject, size: int
) -> None:
    """A client that has no CRC is served, and the CRC field is 0."""
    data = sdo.payload(size)
    room.store(variable, data, segmented=True)
    expect_data(sdo, variable, data, blocks.upload(variable, crc=False))


@must(
    "block-upload.block-size",
    "block-upload.first-sub-block",
    "block-upload.next-sub-block",
    "block.size",
    "upload.ends",
    "block.ends-with-sub-block",
    block_size=[1, 2, 7, 20],
)
def test_block_size(
    sdo: Dialogue, room: Room, blocks: Blocks, roles: Roles, block_size: int
) -> None:
    """A sub-block has as many segments as the client asked for, and the last one what is left.

    What fills large sub-blocks is for block-upload.size.
    """
    beyond = 7 * block_size + 1
    variable = roles.variable(beyond)
    for size in (beyond,) if beyond > SHORT_VALUE else (beyond - 2, beyond - 1, beyond):
        data = sdo.payload(size)
        room.store(variable, data, segmented=True)
        expect_data(sdo, variable, data, blocks.upload(variable, block_size=block_size))


@must("block-upload.ends-with-sub-block", "block.ends-with-sub-block", block_size=[1, 2, 20])
def test_ends_with_sub_block(
    sdo: Dialogue, room: Room, blocks: Blocks, roles: Roles, block_size: int
) -> None:
    """Data that fills its last sub-block is marked there, and the end follows at once."""
    size = 7 * block_size
    variable = roles.variable(size)
    room.store(variable, sdo.payload(size), segmented=True)
    if blocks.initiate_upload(variable, block_size=block_size).size != size:
        sdo.end_transfer()
        if len(value := sdo.upload(variable)) != size:
            raise NotTestable(f"{variable} reads {len(value)} bytes where {size} were stored")
        blocks.initiate_upload(variable, block_size=block_size)
    segments = blocks.start_upload(variable, block_size)
    if not segments[-1].last:
        raise sdo.breach(
            f"segment {block_size} to be marked as the last ({0x80 | block_size:02X}h)",
            Received(segments[-1]),
        )
    blocks.end_of_upload(variable, BlockAck(len(segments), block_size))


@must("block-upload.block-size-changes", "block-upload.next-sub-block", "block.size")
def test_block_size_changes(
    sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject
) -> None:
    """The block size of an acknowledgement counts for the next sub-block, larger or smaller."""
    data = room.prepare(variable, 210, least=15)
    uploaded = blocks.upload(
        variable, block_size=1, next_block_size=lambda size: {1: 5, 5: 2}.get(size, 9)
    )
    expect_data(sdo, variable, data, uploaded)


@must("block-upload.same-as-segmented", "block-upload.first-sub-block", "block-upload.end")
def test_same_as_segmented(sdo: Dialogue, room: Room, blocks: Blocks) -> None:
    """An object reads the same in blocks as in segments."""
    known, _ = room.long_object()
    segmented = sdo.upload(known)
    found = blocks.upload(known).data
    if found != segmented:
        raise sdo.breach(f"{known} reads {shown(segmented)}", Data(found, known))


@must("block-upload.again", "server.idle-afterwards", clause=SUB_BLOCK)
def test_again(sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject) -> None:
    """One block upload after another: each delivers its own object's bytes."""
    for size in (50, 7, 30, 3):
        data = room.prepare(variable, size)
        expect_data(sdo, variable, data, blocks.upload(variable))
        expect_data(sdo, variable, data, blocks.upload(variable))
        sdo.expect_value(variable, data)


@must(
    "block-upload.acknowledged",
    "block-upload.nothing-acknowledged",
    "block.sequence",
    "crc.covers",
    "block-upload.retransmission-numbering",
    taken={"none": 0, "first": 1, "all-but-last": -1},
)
def test_acknowledged(
    sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject, taken: int
) -> None:
    """What was not acknowledged comes again, numbered from 1; size and CRC count it once."""
    data = room.prepare(variable, LENGTH, least=8)
    first = [True]

    def acknowledge(received: int) -> int:
        if first.pop() if first else False:
            return taken % received if taken else 0
        return received

    expect_data(sdo, variable, data, blocks.upload(variable, acknowledge=acknowledge))


@must(
    "block-upload.acknowledged-later",
    "block-upload.acknowledged",
    "block-upload.nothing-acknowledged",
    "block-upload.retransmission-numbering",
    lost={"second-all": (2, 0), "second-last": (2, 1), "third-all": (3, 0), "third-last": (3, 1)},
)
def test_acknowledged_later(
    sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject, lost: tuple[int, int]
) -> None:
    """What was not acknowledged of a later sub-block comes again, from there."""
    data = room.prepare(variable, LENGTH, least=THREE_SUB_BLOCKS)
    sub_block, taken = lost
    seen = iter(range(1, len(data)))

    def acknowledge(received: int) -> int:
        return min(taken, received) if next(seen) == sub_block else received

    expect_data(sdo, variable, data, blocks.upload(variable, block_size=2, acknowledge=acknowledge))


@must(
    "block-upload.acknowledged-repeatedly",
    "block-upload.acknowledged",
    "block-upload.nothing-acknowledged",
    "block-upload.retransmission-numbering",
)
def test_acknowledged_repeatedly(
    sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject
) -> None:
    """Segments that get lost again and again come again and again."""
    data = room.prepare(variable, LENGTH, least=8)
    losses = [0, 1, 0, 0, 2]

    def acknowledge(received: int) -> int:
        return min(losses.pop(), received) if losses else received

    expect_data(sdo, variable, data, blocks.upload(variable, acknowledge=acknowledge))


@must(
    "block-upload.block-size-with-retransmission",
    "block-upload.acknowledged",
    "block-upload.nothing-acknowledged",
    "block.size",
)
def test_block_size_with_retransmission(
    sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject
) -> None:
    """The block size of an acknowledgement counts for what is sent again as well."""
    data = room.prepare(variable, LENGTH, least=8)
    losses = [0, 1]
    sizes = [3, 2, 5, 1]

    def acknowledge(received: int) -> int:
        return min(losses.pop(), received) if losses else received

    def next_block_size(size: int) -> int:
        return sizes.pop() if sizes else size

    uploaded = blocks.upload(
        variable, block_size=4, acknowledge=acknowledge, next_block_size=next_block_size
    )
    expect_data(sdo, variable, data, uploaded)


@must(
    "block-upload.threshold",
    "block-upload.no-switch",
    "block-upload.above-threshold",
    "block-upload.switch",
    threshold=[0, 1, 5, 13, 14, 255],
)
def test_threshold(
    sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject, threshold: int
) -> None:
    """Up to pst bytes may come as an ordinary upload; more, or any with pst = 0, must not."""
    data = room.prepare(variable, 14)
    if threshold < len(data):
        expect_in_blocks(sdo, variable, BlockUploadInitiate(variable.mux, 127, threshold))
        return
    expect_data(sdo, variable, data, blocks.upload(variable, threshold=threshold))


@must(
    "block-upload.threshold-and-block-size",
    "block-upload.above-threshold",
    "block.size",
    "block-upload.first-sub-block",
    threshold=[1, 5, 20, 255],
)
def test_threshold_and_block_size(
    sdo: Dialogue, room: Room, blocks: Blocks, roles: Roles, threshold: int
) -> None:
    """pst says nothing of the block size: an object longer than both comes in blocks as asked."""
    data = sdo.payload(max(threshold, 7 * 5) + 10)
    variable = roles.variable(len(data))
    room.store(variable, data, segmented=True)
    expect_in_blocks(sdo, variable, BlockUploadInitiate(variable.mux, 5, threshold))
    uploaded = blocks.upload(variable, block_size=5, threshold=threshold)
    expect_data(sdo, variable, data, uploaded)


@must("block-upload.reserved", "response.reserved", clause=INITIATE)
def test_reserved(sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject) -> None:
    """Reserved bits and bytes of the answers in a block upload are 0."""
    room.prepare(variable, 20)
    blocks.upload(variable)
    sdo.expect_clean(RESERVED)


@should("block-upload.filler", "response.filler", clause=SUB_BLOCK, size=[1, 8, 20])
def test_filler(
    sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject, size: int
) -> None:
    """The bytes of the last segment that hold no data are 0."""
    room.store(variable, sdo.payload(size))
    blocks.upload(variable)
    sdo.expect_clean(FILLER)


@must("block-upload.next-request", "server.next-request", "block-upload.over")
def test_next_request(sdo: Dialogue, room: Room, blocks: Blocks) -> None:
    """A request right behind the end of a block upload is served."""
    due = sdo.upload(VENDOR_ID)
    known, _ = room.long_object()
    sdo.silence.calms_down = False  # what comes behind the end is the point
    for _ in range(5):
        blocks.upload(known)
        sdo.send(UploadInitiate(VENDOR_ID.mux))
        response = sdo.checks.upload_initiate(sdo.receive(), VENDOR_ID.mux)
        found = sdo.finish_upload(VENDOR_ID, response)
        if found != due:
            raise sdo.breach(f"{VENDOR_ID} reads {shown(due)}", Data(found))


@may("block-upload.empty", "data.empty", "crc.empty")
def test_empty(sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject) -> None:
    """An object without data uploads as nothing, as one byte 00h, or is refused; it never hangs."""
    before = len(room.prepare(variable, PADDED))
    blocks.initiate_upload(variable)
    sdo.end_transfer()
    if sdo.try_download(variable, b"", segmented=True) is not None:
        sdo.info(f"{variable} refuses to become empty")
        return
    uploaded = blocks.try_upload(variable)
    if isinstance(uploaded, Abort):
        sdo.info(f"{variable} is empty and refused: {in_words(uploaded)}")
    else:
        expect_empty(sdo, variable, uploaded.data, before)
    room.prepare(variable, PADDED)  # what is empty may be refused to the next case


@must("block-upload.constant", "block-upload.first-sub-block", "block-upload.end")
def test_constant(sdo: Dialogue, blocks: Blocks) -> None:
    """The vendor-ID reads the same in a block, of one segment, as expedited."""
    due = sdo.upload(VENDOR_ID)
    found = blocks.upload(VENDOR_ID).data
    if found != due:
        raise sdo.breach(f"{VENDOR_ID} reads {shown(due)}", Data(found))
