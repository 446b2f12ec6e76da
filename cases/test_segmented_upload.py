"""Uploads in segments (CiA 301, 7.2.4.3.6 and 7.2.4.3.7)."""

from conformance.device.device import DEVICE_TYPE, IDENTITY_COUNT
from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.held_values import expect_empty
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.object_expectations import expect_stored_and_read
from conformance.dialogue.values import not_emptied, same_value
from conformance.model_cases.open_transfer import begin
from conformance.model_cases.server_states import (
    SEGMENTED_UPLOAD_FIRST,
    SEGMENTED_UPLOAD_LAST,
    SEGMENTED_UPLOAD_MIDDLE,
    SEGMENTED_UPLOADS,
    State,
    by_name,
)
from conformance.model_cases.variations import FOREIGN_IN_UPLOAD, LONG_SIZES, SHORT_SIZES
from conformance.run.case import may, must, should
from conformance.run.risks import risk_of_request
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.describe import shown
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
)
from conformance.sdo.rules import FILLER, RESERVED, accepted
from conformance.sdo.rules.segmented_upload import TOGGLE
from conformance.sdo.seen import Data, Received, other_data

INITIATE = "7.2.4.3.6"
SEGMENT = "7.2.4.3.7"
PADDED = 5
LATER = by_name(SEGMENTED_UPLOAD_MIDDLE, SEGMENTED_UPLOAD_LAST)


@must(
    "segmented-upload.size",
    "segmented-upload.segments",
    "upload.size",
    "response.toggle",
    "upload.ends",
    "response.unused-count",
    "response.unusual-forms",
    "data.long-in-segments",
    size=[*SHORT_SIZES, *LONG_SIZES],
)
def test_size(sdo: Dialogue, room: Room, roles: Roles, size: int) -> None:
    """An upload delivers the bytes of the object, no more and no fewer, and says so rightly."""
    expect_stored_and_read(sdo, room, roles.variable(size), size)


@must("segmented-upload.again", "segmented-upload.segments")
def test_again(sdo: Dialogue, room: Room) -> None:
    """A second upload of the same object delivers the same."""
    known, data = room.long_object()
    sdo.expect_value(known, data)
    sdo.expect_value(known, data)


@must("segmented-upload.read-only-text", "segmented-upload.segments", "object.constant")
def test_read_only_text(sdo: Dialogue, read_only_text: KnownObject) -> None:
    """A text longer than 4 bytes comes in segments; a constant one is the same every time."""
    sdo.start_segmented_upload(read_only_text)
    sdo.end_transfer()
    first = sdo.upload(read_only_text)
    second = sdo.upload(read_only_text)
    if read_only_text.is_steady and first != second:
        raise sdo.breach(f"{shown(first)} again", Data(second))


@must("segmented-upload.toggle-first", "segmented-upload.toggle")
def test_toggle_first(sdo: Dialogue, room: Room) -> None:
    """The first segment request has t = 0; 70h ends the transfer and brings no data."""
    transfer = begin(sdo, SEGMENTED_UPLOAD_FIRST)
    sdo.send(UploadSegment(1))
    sdo.expect_abort(*TOGGLE.codes, of=transfer.known, tolerated=TOGGLE.tolerated)
    sdo.expect_dead(transfer.due)


@must("segmented-upload.toggle-repeated", "segmented-upload.toggle", state=LATER)
def test_toggle_repeated(sdo: Dialogue, state: State[UploadSegment]) -> None:
    """A repeated toggle bit ends the transfer and brings no data."""
    transfer = begin(sdo, state)
    sdo.send(UploadSegment(1 - transfer.due.toggle))
    sdo.expect_abort(*TOGGLE.codes, of=transfer.known, tolerated=TOGGLE.tolerated)
    sdo.expect_dead(transfer.due)


@must(
    "segmented-upload.toggle-afterwards",
    "segmented-upload.segments",
    "server.idle-afterwards",
    state=LATER,
)
def test_toggle_afterwards(sdo: Dialogue, state: State[UploadSegment]) -> None:
    """Wherever a transfer ended, the next one begins with t = 0."""
    transfer = begin(sdo, state)
    sdo.send(Abort(transfer.known.mux, AbortCode.GENERAL_ERROR))
    sdo.start_segmented_upload(transfer.known)
    sdo.upload_segment(toggle=0)


@must("segmented-upload.reserved", "response.reserved", clause=INITIATE)
def test_reserved(sdo: Dialogue, room: Room) -> None:
    """Reserved bits of the answers in an upload are 0, and the d field without a size is too."""
    known, data = room.long_object()
    sdo.expect_value(known, data)
    sdo.expect_clean(RESERVED)


@should("segmented-upload.filler", "response.filler", clause=SEGMENT, size=[8, 9, 13, 15, 20])
def test_filler(sdo: Dialogue, room: Room, variable: KnownObject, size: int) -> None:
    """The bytes of the last segment that hold no data are 0."""
    data = sdo.payload(size)
    room.store(variable, data)
    sdo.expect_value(variable, data)
    sdo.expect_clean(FILLER)


@must(
    "segmented-upload.foreign",
    "segmented-upload.download-segment",
    "segmented-upload.unknown-specifier",
    "segmented-upload.block-frames",
    risk=risk_of_request,
    request=FOREIGN_IN_UPLOAD,
)
def test_foreign(sdo: Dialogue, request: bytes) -> None:
    """A request of another service before the first segment ends the upload with 05040001h."""
    transfer = begin(sdo, SEGMENTED_UPLOAD_FIRST)
    sdo.send(request)
    sdo.expect_abort(*accepted.NOT_VALID, of=transfer.known)
    sdo.expect_dead(transfer.due)


@must(
    "segmented-upload.foreign-later",
    "segmented-upload.download-segment",
    "segmented-upload.unknown-specifier",
    "segmented-upload.block-frames",
    risk=risk_of_request,
    request=FOREIGN_IN_UPLOAD,
)
def test_foreign_later(sdo: Dialogue, request: bytes) -> None:
    """A request of another service between segments ends the upload with 05040001h."""
    transfer = begin(sdo, SEGMENTED_UPLOAD_MIDDLE)
    sdo.send(request)
    sdo.expect_abort(*accepted.NOT_VALID, of=transfer.known)
    sdo.expect_dead(transfer.due)


@must("segmented-upload.restart", "server.new-initiate-served", state=SEGMENTED_UPLOADS)
def test_restart(sdo: Dialogue, room: Room, state: State[UploadSegment]) -> None:
    """The same initiate again starts from the first byte, or is refused and ends the transfer."""
    known, data = room.long_object()
    state.reach(sdo, known, len(data))
    answer = sdo.expect_restart_or_abort(UploadInitiate(known.mux), known, known)
    if answer is not None:
        with sdo.one_transfer():
            response = sdo.checks.upload_initiate(answer, known.mux)
            found = sdo.finish_upload(known, response)
            if not same_value(known, found, data):
                raise sdo.breach(f"{known} from its first byte: {shown(data)}", Data(found))


@must(
    "segmented-upload.new-upload",
    "segmented-upload.new-initiate",
    "server.new-initiate-served",
    state=SEGMENTED_UPLOADS,
)
def test_new_upload(sdo: Dialogue, state: State[UploadSegment]) -> None:
    """An upload of another object is served with its data, or refused; the old one is over."""
    due = sdo.upload(IDENTITY_COUNT)
    transfer = begin(sdo, state)
    answer = sdo.expect_restart_or_abort(
        UploadInitiate(IDENTITY_COUNT), transfer.known, IDENTITY_COUNT
    )
    with sdo.one_transfer():
        if answer is not None:
            response = sdo.checks.upload_initiate(answer, IDENTITY_COUNT)
            found = sdo.finish_upload(IDENTITY_COUNT, response)
            if found[: len(due)] != due:
                raise sdo.breach(
                    f"1018h:00 reads {due.hex()}", other_data(f"it reads {found.hex()}")
                )
        sdo.expect_dead(transfer.due)


@must(
    "segmented-upload.new-download", "segmented-upload.new-initiate", "server.new-initiate-served"
)
def test_new_download(sdo: Dialogue, number: KnownObject) -> None:
    """A download in the middle of an upload is served or refused; the upload is over."""
    value = sdo.upload(number)
    transfer = begin(sdo, SEGMENTED_UPLOAD_MIDDLE)
    request = (
        DownloadInitiate.with_data(number.mux, value)
        if len(value) <= 4
        else DownloadInitiate.with_size(number.mux, len(value))
    )
    answer = sdo.expect_restart_or_abort(request, transfer.known, number)
    with sdo.one_transfer():
        if answer is not None:
            sdo.checks.download_initiate(answer, number.mux)
        sdo.end_transfer()
        sdo.expect_dead(transfer.due)
        sdo.expect_value(number, value)


@must("segmented-upload.client-abort", state=SEGMENTED_UPLOADS)
def test_client_abort(sdo: Dialogue, state: State[UploadSegment]) -> None:
    """An abort of the client is not answered and ends the upload."""
    transfer = begin(sdo, state)
    sdo.send(Abort(transfer.known.mux, AbortCode.GENERAL_ERROR))
    sdo.expect_nothing()
    sdo.expect_dead(transfer.due)


@must(
    "segmented-upload.client-abort-then-segment",
    "segmented-upload.client-abort",
    "time-out.client",
    "server.nothing-afterwards",
    state=SEGMENTED_UPLOADS,
)
def test_client_abort_then_segment(sdo: Dialogue, state: State[UploadSegment]) -> None:
    """A segment request right behind an abort brings no data."""
    transfer = begin(sdo, state)
    sdo.send(Abort(transfer.known.mux, AbortCode.TIMED_OUT))
    sdo.expect_dead(transfer.due)


@must(
    "segmented-upload.client-abort-then-upload",
    "segmented-upload.client-abort",
    "server.idle-afterwards",
)
def test_client_abort_then_upload(sdo: Dialogue, room: Room) -> None:
    """An upload right behind an abort is served whole."""
    known, data = room.long_object()
    sdo.start_segmented_upload(known)
    sdo.upload_segment(toggle=0)
    sdo.send(Abort(known.mux, AbortCode.TIMED_OUT))
    sdo.expect_value(known, data)


@may("segmented-upload.after-the-last", "request.out-of-transfer")
def test_after_the_last(sdo: Dialogue, room: Room) -> None:
    """After the last segment there are no more: abort or silence, but no data."""
    known, data = room.long_object()
    for toggle in (0, 1):
        sdo.expect_value(known, data)
        sdo.expect_dead(UploadSegment(toggle))


@may("segmented-upload.without-initiate", "request.out-of-transfer", "abort.any-multiplexer")
def test_without_initiate(sdo: Dialogue) -> None:
    """A segment request without an upload brings no data: abort or silence."""
    for toggle in (0, 1):
        sdo.upload(DEVICE_TYPE)
        sdo.expect_dead(UploadSegment(toggle))


@may("segmented-upload.request-reserved-bytes", "request.reserved-bytes")
def test_request_reserved_bytes(sdo: Dialogue, room: Room) -> None:
    """Segment requests that repeat the multiplexer, as some clients do, are served or refused."""
    known, data = room.long_object()
    response = sdo.start_segmented_upload(known)
    multiplexer = UploadInitiate(known.mux).encode()[1:4]
    _compare_or_abort(sdo, known, response, data, UploadSegment(0, 0, multiplexer + bytes(4)))


@may("segmented-upload.request-reserved-bits", "request.reserved-bits", bits=[0x01, 0x0F])
def test_request_reserved_bits(sdo: Dialogue, room: Room, bits: int) -> None:
    """Reserved bits of a segment request may be ignored or refused; silence is neither."""
    known, data = room.long_object()
    response = sdo.start_segmented_upload(known)
    _compare_or_abort(sdo, known, response, data, UploadSegment(0, bits))


def _compare_or_abort(
    sdo: Dialogue,
    known: KnownObject,
    response: UploadInitiateResponse,
    data: bytes,
    request: UploadSegment,
) -> None:
    """Expect the first segment in answer to ``request``, or a refusal of it."""
    sdo.send(request)
    answer = sdo.receive()
    if isinstance(answer, Abort):
        abort = sdo.checks.abort(answer, known.mux)
        if abort.code not in (AbortCode.COMMAND_NOT_VALID, AbortCode.PARAMETER_INCOMPATIBLE):
            raise sdo.breach("the segment, or abort 05040001h", Received(answer))
        return
    segment = sdo.checks.upload_segment(answer, known.mux, 0)
    if not data.startswith(segment.data) or response.size not in (None, len(data), len(data) + 1):
        raise sdo.breach(f"the first bytes of {shown(data)}", Received(answer))


@may("segmented-upload.empty", "data.empty")
def test_empty(sdo: Dialogue, room: Room, variable: KnownObject) -> None:
    """An object without data uploads as nothing, as one byte 00h, or is refused; it never hangs."""
    before = room.prepare(variable, PADDED)
    if sdo.try_download(variable, b"", segmented=True) is not None:
        sdo.info(f"{variable} refuses to become empty")
        return
    sdo.send(UploadInitiate(variable.mux))
    answer = sdo.receive()
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, variable.mux)
    else:
        response = sdo.checks.upload_initiate(answer, variable.mux)
        found = sdo.finish_upload(variable, response)
        if found == before and not variable.habits.keeps_tails:
            raise not_emptied(variable)
        counted = response.sized or not response.expedited
        expect_empty(sdo, variable, found, len(before), counted=counted)
    room.prepare(variable, PADDED)  # what is empty may be refused to the next case
