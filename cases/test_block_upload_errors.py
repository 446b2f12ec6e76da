"""What goes wrong in a block upload (CiA 301, 7.2.4.3.13 to 7.2.4.3.15 and 7.2.4.3.17)."""

from conformance.device.device import IDENTITY_COUNT
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.missing_objects import missing_object, missing_sub_index
from conformance.model_cases.open_transfer import begin
from conformance.model_cases.server_states import (
    BLOCK_UPLOAD_BETWEEN,
    BLOCK_UPLOAD_END,
    BLOCK_UPLOAD_INITIATED,
    State,
    by_name,
)
from conformance.model_cases.variations import UNKNOWN_SPECIFIERS
from conformance.model_cases.ways_to_states import BLOCK_SIZE
from conformance.run.case import must
from conformance.run.risks import risk_of_request
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import as_segment
from conformance.sdo.describe import in_words
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadSegment,
    Request,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import MISSING_REFUSED, accepted
from conformance.sdo.rules.block_upload import ACKNOWLEDGES_BLOCK_SIZE, ACKNOWLEDGES_TOO_MANY
from conformance.sdo.rules.idle import SUB_INDEX_MISSING, WRITE_ONLY
from conformance.sdo.rules.upload_initiates import INVALID_BLOCK_SIZE
from conformance.sdo.seen import Received, Said

NOT_STARTED = {
    "A1h": BlockEndResponse().encode(),
    "A2h": BlockAck(0, 127).encode(),
    "60h": UploadSegment(0).encode(),
    "00h": DownloadSegment.with_data(b"ABCDEFG", toggle=0).encode(),
    "E0h": UNKNOWN_SPECIFIERS["E0h"],
}
FOREIGN = {
    "A3h": BlockUploadStart().encode(),
    "A1h": BlockEndResponse().encode(),
    "60h": UploadSegment(0).encode(),
    "70h": UploadSegment(1).encode(),
    "E0h": UNKNOWN_SPECIFIERS["E0h"],
}
# So many that a server has not sent them all when the abort comes.
SEGMENTS_INSIDE = 20
STATES: dict[str, State[Request]] = by_name(
    BLOCK_UPLOAD_INITIATED, BLOCK_UPLOAD_BETWEEN, BLOCK_UPLOAD_END
)


@must("block-upload.invalid-block-size", block_size=[0, 128, 255])
def test_invalid_block_size(sdo: Dialogue, room: Room, blocks: Blocks, block_size: int) -> None:
    """A block size of 0 or beyond 127 is refused."""
    known, _ = room.long_object()
    blocks.initiate_upload(known)
    sdo.end_transfer()
    sdo.send(BlockUploadInitiate(known.mux, block_size))
    sdo.expect_abort(*INVALID_BLOCK_SIZE.codes, of=known, tolerated=INVALID_BLOCK_SIZE.tolerated)


@must("block-upload.not-started", "block-upload.foreign-before-start", request=NOT_STARTED)
def test_not_started(sdo: Dialogue, request: bytes) -> None:
    """Anything but the start where it is due ends the upload with 05040001h."""
    transfer = begin(sdo, BLOCK_UPLOAD_INITIATED)
    sdo.send(request)
    sdo.expect_abort(*accepted.NOT_VALID, of=transfer.known)
    sdo.expect_dead(transfer.due)


@must("block-upload.foreign", risk=risk_of_request, request=FOREIGN)
def test_foreign(sdo: Dialogue, request: bytes) -> None:
    """Anything but an acknowledgement where it is due ends the upload with 05040001h."""
    transfer = begin(sdo, BLOCK_UPLOAD_BETWEEN)
    sdo.send(request)
    sdo.expect_abort(*accepted.NOT_VALID, of=transfer.known)
    sdo.expect_dead(transfer.due)


@must(
    "block-upload.acknowledges-too-many",
    sequence={"one-more": BLOCK_SIZE + 1, "128": 128, "255": 255},
)
def test_acknowledges_too_many(sdo: Dialogue, sequence: int) -> None:
    """An acknowledgement of more segments than were sent ends the upload."""
    transfer = begin(sdo, BLOCK_UPLOAD_BETWEEN)
    sdo.send(BlockAck(sequence, BLOCK_SIZE))
    sdo.expect_abort(*ACKNOWLEDGES_TOO_MANY.codes, of=transfer.known)
    sdo.expect_dead(transfer.due)


@must("block-upload.acknowledges-block-size", block_size=[0, 128, 255])
def test_acknowledges_block_size(sdo: Dialogue, block_size: int) -> None:
    """An acknowledgement with a block size of 0 or beyond 127 ends the upload."""
    transfer = begin(sdo, BLOCK_UPLOAD_BETWEEN)
    sdo.send(BlockAck(BLOCK_SIZE, block_size))
    sdo.expect_abort(
        *ACKNOWLEDGES_BLOCK_SIZE.codes,
        of=transfer.known,
        tolerated=ACKNOWLEDGES_BLOCK_SIZE.tolerated,
    )
    sdo.expect_dead(transfer.due)


@must("block-upload.client-abort", "block-upload.client-abort-at-end", state=STATES)
def test_client_abort(sdo: Dialogue, state: State[Request]) -> None:
    """An abort of the client is not answered and ends the upload."""
    transfer = begin(sdo, state)
    sdo.send(Abort(transfer.known.mux, AbortCode.GENERAL_ERROR))
    sdo.expect_nothing()


@must(
    "block-upload.client-abort-then-ack",
    "block-upload.client-abort",
    "time-out.client",
    "server.nothing-afterwards",
)
def test_client_abort_then_ack(sdo: Dialogue) -> None:
    """An acknowledgement right behind an abort brings no more segments."""
    transfer = begin(sdo, BLOCK_UPLOAD_BETWEEN)
    sdo.send(Abort(transfer.known.mux, AbortCode.TIMED_OUT))
    sdo.expect_dead(transfer.due)


@must(
    "block-upload.client-abort-then-start",
    "block-upload.client-abort",
    "time-out.client",
    "server.nothing-afterwards",
)
def test_client_abort_then_start(sdo: Dialogue) -> None:
    """A start behind an abort brings no segments: the abort has ended the upload before it."""
    transfer = begin(sdo, BLOCK_UPLOAD_INITIATED)
    sdo.send(Abort(transfer.known.mux, AbortCode.TIMED_OUT))
    sdo.expect_dead(transfer.due)


@must(
    "block-upload.client-abort-inside",
    "block-upload.client-abort",
    "time-out.client",
    "server.nothing-afterwards",
)
def test_client_abort_inside(sdo: Dialogue, room: Room, blocks: Blocks) -> None:
    """An abort inside a sub-block that the server is sending stops it.

    What was on its way comes before the answer to the next request, and nothing behind it.
    """
    try:
        known, _ = room.long_object(SEGMENTS_INSIDE)
    except NotTestable:
        known, _ = room.long_object()
    blocks.initiate_upload(known)
    sdo.send(BlockUploadStart())
    sdo.checks.block_segment(sdo.receive(), known.mux, 1)
    sdo.send(Abort(known.mux, AbortCode.GENERAL_ERROR))
    for response in sdo.fence():
        if not isinstance(as_segment(response, known.mux), BlockSegment):
            raise sdo.breach("no answer to the abort", Received(response))
    behind = sdo.silence.outlast()
    if behind:
        raise sdo.breach(
            "no segment behind the answer to the next request",
            Said(f"{len(behind)} frames more, first {in_words(behind[0])}", "… frames more"),
        )


def refused_block_upload(sdo: Dialogue, mux: Multiplexer, *codes: AbortCode) -> None:
    """Expect a block upload of ``mux`` to be refused by a server that has block uploads."""
    sdo.send(BlockUploadInitiate(IDENTITY_COUNT, 127))
    response = sdo.receive()
    if isinstance(response, Abort) and response.code == AbortCode.COMMAND_NOT_VALID:
        raise Unimplemented(Received(response))
    sdo.end_transfer()
    sdo.send(BlockUploadInitiate(mux, 127))
    sdo.expect_abort(*codes, of=mux)


@must("block-upload.object-missing", "object.missing-refused")
def test_object_missing(sdo: Dialogue) -> None:
    """The block upload of an object that does not exist is aborted as such."""
    refused_block_upload(sdo, missing_object(sdo), *MISSING_REFUSED.codes)


@must("block-upload.sub-index-missing", "object.sub-index-missing")
def test_sub_index_missing(sdo: Dialogue) -> None:
    """The block upload of a sub-index that does not exist is aborted as such."""
    missing = missing_sub_index(sdo, IDENTITY_COUNT.index)
    refused_block_upload(sdo, missing, *SUB_INDEX_MISSING.codes)


@must("block-upload.write-only", "object.write-only")
def test_write_only(sdo: Dialogue, write_only: KnownObject) -> None:
    """The block upload of a write-only object is aborted as such."""
    refused_block_upload(sdo, write_only.mux, *WRITE_ONLY.codes)
