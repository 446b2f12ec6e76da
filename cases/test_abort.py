"""Aborts, by the client and by the server (CiA 301, 7.2.4.3.17)."""

from contextlib import suppress

from conformance.device.device import DEVICE_TYPE, VENDOR_ID
from conformance.device.known_objects import KnownObject
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.missing_objects import missing_object, missing_sub_index
from conformance.run.case import may, must, should
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import Abort, DownloadInitiate, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import ANSWERED, MISSING_REFUSED, OTHER_SERVICE, RESERVED, Violation

ABORT = "7.2.4.3.17"
ANY_ABORT = {
    "general-error": Abort(DEVICE_TYPE, AbortCode.GENERAL_ERROR),
    "timed-out": Abort(VENDOR_ID.mux, AbortCode.TIMED_OUT),
    "missing-object": Abort(Multiplexer(0x1FFF), AbortCode.OBJECT_MISSING),
    "code-0": Abort(DEVICE_TYPE, 0),
    "unknown-code": Abort(DEVICE_TYPE, 0xFFFFFFFF),
    "all-zero": Abort(Multiplexer(0), 0),
}


@must("abort.not-answered", "response.unsolicited", abort=ANY_ABORT)
def test_not_answered(sdo: Dialogue, abort: Abort) -> None:
    """An abort is never answered, whatever it says, also when no transfer is running."""
    sdo.send(abort)
    sdo.expect_nothing()


@should("abort.request-behind")
def test_request_behind(sdo: Dialogue) -> None:
    """A request right behind an abort is answered, without a pause between them."""
    with sdo.channel.without_rest():
        sdo.send(Abort(DEVICE_TYPE, AbortCode.GENERAL_ERROR))
        sdo.send(UploadInitiate(VENDOR_ID.mux))
    try:
        sdo.checks.upload_initiate(sdo.receive(), VENDOR_ID.mux)
    except Violation as silent:
        if silent.rule is not ANSWERED:
            raise
        expected = f"an answer to the read of {VENDOR_ID.mux}, sent right behind an abort"
        raise sdo.breach(expected, silent.seen) from silent


@must("abort.repeated", "abort.not-answered", "server.idle-afterwards")
def test_repeated(sdo: Dialogue) -> None:
    """One abort after another: none is answered, and the server serves the next request."""
    due = sdo.upload(VENDOR_ID)
    for _ in range(3):
        sdo.send(Abort(DEVICE_TYPE, AbortCode.TIMED_OUT))
    sdo.expect_nothing()
    sdo.expect_value(VENDOR_ID, due)


@must("abort.after-a-transfer", "abort.not-answered")
def test_after_a_transfer(sdo: Dialogue, number: KnownObject) -> None:
    """An abort behind a download that is over undoes nothing and is not answered."""
    value = sdo.write_number(number)
    sdo.send(Abort(number.mux, AbortCode.GENERAL_ERROR))
    sdo.expect_nothing()
    sdo.expect_value(number, value)


@may("abort.reserved-bits", "request.reserved-bits", bits=[0x01, 0x10, 0x1F])
def test_reserved_bits(sdo: Dialogue, bits: int) -> None:
    """81h to 9Fh without a transfer is never answered positively."""
    sdo.send(Abort(VENDOR_ID.mux, AbortCode.GENERAL_ERROR, bits))
    sdo.expect_silence_or_abort()


@must("abort.frame", "abort.code", "response.reserved")
def test_frame(sdo: Dialogue) -> None:
    """An abort of the server is exactly 80h, the multiplexer, and a code of table 22."""
    for mux in _refused(sdo):
        sdo.send(UploadInitiate(mux))
        sdo.checks.abort(sdo.receive(), mux)
    sdo.expect_clean(RESERVED)


@must("abort.other-service", clause=ABORT)
def test_other_service(sdo: Dialogue) -> None:
    """A read is refused by no code about writing, and a write by none about reading."""
    missing, *others = _refused(sdo)
    for mux in (missing, *others):
        sdo.send(UploadInitiate(mux))
        sdo.expect_abort(*AbortCode, of=mux)  # which code is due is for other cases
    sdo.send(DownloadInitiate.with_data(missing, bytes(4)))
    sdo.expect_abort(*AbortCode, of=missing)
    sdo.expect_clean(OTHER_SERVICE)


@must("abort.own-multiplexer", "response.multiplexer", clause=ABORT)
def test_own_multiplexer(sdo: Dialogue) -> None:
    """An abort names the object that was just refused, not one of an earlier transfer."""
    missing, *others = _refused(sdo)
    for mux in (missing, *others, missing):
        sdo.upload(VENDOR_ID)
        sdo.send(UploadInitiate(mux))
        sdo.expect_abort(*AbortCode, of=mux)  # which code is due is for other cases


def _refused(sdo: Dialogue) -> list[Multiplexer]:
    """Return an object that the device refuses and, where it does, a sub-index."""
    refused = [missing_object(sdo)]
    with suppress(Violation):  # that it serves any sub-index is for other cases to say
        refused.append(missing_sub_index(sdo, DEVICE_TYPE.index))
    return refused


@must("abort.own-multiplexer-download", "response.multiplexer", clause=ABORT)
def test_own_multiplexer_download(sdo: Dialogue) -> None:
    """The abort of a refused download names its object, not the one read before."""
    missing = missing_object(sdo)
    sdo.upload(VENDOR_ID)
    sdo.send(DownloadInitiate.with_data(missing, b"\1\0\0\0"))
    sdo.expect_abort(*MISSING_REFUSED.codes, of=missing)


@must("abort.many", "server.idle-afterwards", "response.answered", clause=ABORT)
def test_many(sdo: Dialogue) -> None:
    """Refusal after refusal is answered, each with one abort: nothing runs out."""
    missing = missing_object(sdo)
    for _ in range(40):
        sdo.send(UploadInitiate(missing))
        sdo.expect_abort(*MISSING_REFUSED.codes, of=missing)


@must(
    "abort.many-transfers", "server.idle-afterwards", "segmented-upload.client-abort", clause=ABORT
)
def test_many_transfers(sdo: Dialogue, room: Room) -> None:
    """Transfer after transfer is started and aborted by the client: nothing runs out."""
    known, data = room.long_object()
    for _ in range(40):
        sdo.start_segmented_upload(known)
        sdo.upload_segment(toggle=0)
        sdo.send(Abort(known.mux, AbortCode.TIMED_OUT))
    sdo.expect_value(known, data)
