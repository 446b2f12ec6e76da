"""Block uploads where CiA 301 leaves a choice: any choice passes, a wrong result does not."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from conformance.device.device import VENDOR_ID
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.values import same_value
from conformance.model_cases.open_transfer import begin
from conformance.model_cases.server_states import (
    BLOCK_UPLOAD_BETWEEN,
    BLOCK_UPLOAD_END,
    BLOCK_UPLOAD_INITIATED,
    State,
    by_name,
)
from conformance.model_cases.ways_to_states import BLOCK_SIZE, LONGEST
from conformance.run.case import may, must
from conformance.run.new_transfers import INITIATE_SIZE, INITIATES, Initiate
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import as_answer, as_segment
from conformance.sdo.describe import in_words, shown
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    Request,
)
from conformance.sdo.oracle.going_on import AT_THE_END
from conformance.sdo.rules import ANSWERED, SPECIFIER, Violation
from conformance.sdo.rules.block_upload import ACKNOWLEDGEMENT_RESERVED_BITS
from conformance.sdo.rules.defects import FOREIGN_SERVED
from conformance.sdo.rules.upload_initiates import THRESHOLD_WITHOUT_BLOCK_SIZE
from conformance.sdo.seen import Data, Received, said

INITIATE = "7.2.4.3.13"
STATES: dict[str, State[Request]] = by_name(
    BLOCK_UPLOAD_INITIATED, BLOCK_UPLOAD_BETWEEN, BLOCK_UPLOAD_END
)


@may("block-upload.threshold-without-block-size")
def test_threshold_without_block_size(
    sdo: Dialogue, room: Room, blocks: Blocks, variable: KnownObject
) -> None:
    """With pst = 255 and blksize 0 a short object comes as an ordinary upload, or is refused."""
    data = room.prepare(variable, 9)
    blocks.initiate_upload(variable)
    sdo.end_transfer()
    sdo.send(BlockUploadInitiate(variable.mux, 0, threshold=255))
    answer = as_answer(sdo.receive())
    if isinstance(answer, Abort):
        sdo.take_abort(answer, THRESHOLD_WITHOUT_BLOCK_SIZE.codes, variable)
        return
    found = sdo.finish_upload(variable, sdo.checks.upload_initiate(answer, variable.mux))
    if not same_value(variable, found, data):
        raise sdo.breach(f"{variable} reads {shown(data)}", Data(found, variable))


@may("block-upload.acknowledgement-reserved-bits", "request.reserved-bits", bits=[1, 2, 4, 7])
def test_acknowledgement_reserved_bits(sdo: Dialogue, bits: int) -> None:
    """Reserved bits of an acknowledgement (A6h) are ignored, or the upload ends with 05040001h."""
    transfer = begin(sdo, BLOCK_UPLOAD_BETWEEN)
    sdo.send(BlockAck(BLOCK_SIZE, BLOCK_SIZE, reserved_bits=bits))
    answer = as_segment(sdo.receive(), transfer.known.mux)
    if isinstance(answer, Abort):
        sdo.take_abort(answer, ACKNOWLEDGEMENT_RESERVED_BITS.codes, transfer.known)
        sdo.expect_dead(transfer.due)
        return
    segment = sdo.checks.block_segment(answer, transfer.known.mux, 1)
    if not segment.last:
        sdo.checks.block_segment(sdo.receive(), transfer.known.mux, 2)


@may("block-upload.early-acknowledgement")
def test_early_acknowledgement(sdo: Dialogue, blocks: Blocks) -> None:
    """An acknowledgement while segments are on their way does no lasting harm: an abort ends it."""
    transfer = begin(sdo, BLOCK_UPLOAD_INITIATED)
    with sdo.channel.without_pause():
        sdo.send(BlockUploadStart())
        sdo.send(BlockAck(1, BLOCK_SIZE))
    sdo.end_transfer()
    answers = [as_segment(answer, transfer.known.mux) for answer in sdo.fence()]
    segments = [answer for answer in answers if isinstance(answer, BlockSegment)]
    # Which of them come is open: the server may go on, begin again, or count on.
    if len(segments) > 2 * BLOCK_SIZE:
        raise sdo.breach(
            f"two sub-blocks of {BLOCK_SIZE} segments at most", said("{} segments", len(segments))
        )
    blocks.upload(transfer.known)


@may("block-upload.acknowledged-at-end", "block-upload.acknowledged-again")
def test_acknowledged_at_end(sdo: Dialogue, room: Room, blocks: Blocks) -> None:
    """An acknowledgement that comes again brings the end frame again, an abort, or nothing."""
    known, data = room.long_object()
    blocks.initiate_upload(known)
    segments = blocks.start_upload(known, 127)
    for _ in range(LONGEST, len(data), LONGEST):
        segments = blocks.sub_block(known, BlockAck(len(segments), 127), 127)
    ack = BlockAck(len(segments), 127)
    sdo.send(ack)
    end = sdo.receive()
    sdo.checks.block_end(end, known.mux)
    sdo.send(ack)
    sdo.send(BlockEndResponse())
    for answer in sdo.fence():
        if answer.encode() == end.encode():
            sdo.info("the end frame comes again")
        elif not isinstance(answer, Abort):
            raise sdo.breach(
                "the same end frame, an abort, or nothing", Received(as_answer(answer))
            )


@must("block-upload.crc-refused-by-client", "block-upload.client-abort-at-end")
def test_crc_refused_by_client(sdo: Dialogue, blocks: Blocks) -> None:
    """A client that finds the CRC wrong aborts: the server is silent, and nothing is left."""
    transfer = begin(sdo, BLOCK_UPLOAD_END)
    sdo.send(Abort(transfer.known.mux, AbortCode.CRC_ERROR))
    sdo.expect_nothing()
    sdo.expect_dead(transfer.due)
    blocks.upload(transfer.known)


@contextmanager
def whatever_comes(state: State[Request]) -> Iterator[None]:
    """Tell a block upload that goes on with a new initiate as what it is.

    Where its end is to be confirmed, to go on is to be silent.
    """
    try:
        yield
    except Violation as breach:
        if breach.rule is SPECIFIER and state is not BLOCK_UPLOAD_END:
            breach.told_as = FOREIGN_SERVED
        if breach.rule is ANSWERED and state is BLOCK_UPLOAD_END:
            breach.asked_as = AT_THE_END
        raise


def expect_served_or_refused(
    sdo: Dialogue, room: Room, state: State[Request], initiate: Initiate
) -> None:
    """Begin a block upload, and another transfer where its next frame is due."""
    with suppress(NotTestable):
        room.fit(Roles(sdo.device).text(), INITIATE_SIZE)
    transfer = begin(sdo, state)
    with whatever_comes(state):
        refused = initiate(sdo, transfer.known)
    if refused is not None:
        sdo.info(f"refused: {in_words(refused)}")
        sdo.upload(VENDOR_ID)
    sdo.expect_dead(transfer.due)


@must(
    "block-upload.new-initiate-at-start",
    "block-upload.new-initiate-before-start",
    "server.new-initiate-served",
    initiate=INITIATES,
)
def test_new_initiate_at_start(sdo: Dialogue, room: Room, initiate: Initiate) -> None:
    """An initiate where the start is due is served, or ends the upload."""
    expect_served_or_refused(sdo, room, BLOCK_UPLOAD_INITIATED, initiate)


@must(
    "block-upload.new-initiate-in-the-middle",
    "block-upload.new-initiate",
    "server.new-initiate-served",
    initiate=INITIATES,
)
def test_new_initiate_in_the_middle(sdo: Dialogue, room: Room, initiate: Initiate) -> None:
    """An initiate where an acknowledgement is due is served, or ends the upload."""
    expect_served_or_refused(sdo, room, BLOCK_UPLOAD_BETWEEN, initiate)


@must("block-upload.new-initiate-at-end", "server.new-initiate-served", initiate=INITIATES)
def test_new_initiate_at_end(sdo: Dialogue, room: Room, initiate: Initiate) -> None:
    """An initiate where the confirmation of the end is due is served, or ends the upload."""
    expect_served_or_refused(sdo, room, BLOCK_UPLOAD_END, initiate)


@must(
    "block-upload.same-again",
    "block-upload.new-initiate-before-start",
    "block-upload.new-initiate",
    "block-upload.new-initiate-at-end",
    "server.new-initiate-served",
    clause=INITIATE,
    state=STATES,
)
def test_same_again(sdo: Dialogue, state: State[Request]) -> None:
    """The same block upload initiated again starts from the first byte, or ends the first."""
    transfer = begin(sdo, state)
    with whatever_comes(state):
        found = sdo.attempt(sdo.client.block_upload(transfer.known.mux))
    if isinstance(found, Abort):
        sdo.info(f"refused: {in_words(found)}")
        return
    known = transfer.known
    due = sdo.upload(known)
    if not same_value(known, found.data, due):
        raise sdo.breach(f"{known} reads {shown(due)}", Data(found.data, known))
