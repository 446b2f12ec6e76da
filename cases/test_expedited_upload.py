"""Uploads that the server answers with up to 4 bytes at once (CiA 301, 7.2.4.3.6)."""

from contextlib import suppress

from conformance.device.device import DEVICE_TYPE, IDENTITY_COUNT, TEXTS, VENDOR_ID, Device
from conformance.device.effort import LONG_VALUE
from conformance.device.known_objects import KnownObject
from conformance.device.learned import Reason
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.missing_objects import missing_object, missing_sub_index
from conformance.dialogue.values import of_another_length
from conformance.run.case import may, must, should
from conformance.sdo.checks import ServerAborted
from conformance.sdo.frames import (
    Abort,
    UploadInitiate,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType
from conformance.sdo.rules import FILLER, MISSING_REFUSED, RESERVED
from conformance.sdo.rules.freedoms import RESERVED_BYTES
from conformance.sdo.rules.idle import SUB_INDEX_MISSING, WRITE_ONLY
from conformance.sdo.rules.upload_initiates import UPLOAD_RESERVED_BITS
from conformance.sdo.seen import Received, other_data, said

UPLOAD = "7.2.4.3.6"
ABORT = "7.2.4.3.17"


@must("upload.device-type", "object.mandatory", "response.not-refused", clause="7.5.2.1")
def test_device_type(sdo: Dialogue) -> None:
    """The device type (1000h), which every device has, reads as 4 bytes."""
    data = sdo.upload(DEVICE_TYPE)
    if len(data) != 4:
        raise sdo.breach("4 bytes", said("{} bytes", len(data)))


@must("upload.identity", "object.mandatory", "response.not-refused", clause="7.5.2.21")
def test_identity(sdo: Dialogue) -> None:
    """The identity (1018h), which every device has, counts 1 to 4 entries and has a vendor-ID."""
    count = sdo.upload(KnownObject(IDENTITY_COUNT, DataType.UNSIGNED8, Access.CONST))
    if len(count) != 1 or not 1 <= count[0] <= 4:
        raise sdo.breach(
            "1018h:00 reads 1 to 4 in one byte", other_data(f"it reads {count.hex(' ')}")
        )
    vendor = sdo.upload(VENDOR_ID)
    if len(vendor) != 4:
        raise sdo.breach("1018h:01 reads 4 bytes", other_data(f"it reads {len(vendor)}"))


@must("upload.known-objects", "response.not-refused", clause=UPLOAD)
def test_known_objects(sdo: Dialogue, device: Device) -> None:
    """What the run knows of, texts and named objects included, reads without error.

    Long values were read when the run began; a quick run reads some of very many objects.
    """
    long = {mux for mux, value in device.values.items() if len(value) > LONG_VALUE}
    long |= device.learned.unread_for(Reason.TOO_LONG)
    brief = device.permits.effort.sampled(sorted(device.values.keys() - long))
    for mux in (*TEXTS, *brief):
        with suppress(ServerAborted):
            sdo.read(mux)
    named = {known.mux for known in device.permits.named if known.access.readable}
    for mux in sorted(named - long):
        try:
            sdo.read(mux)
        except ServerAborted as aborted:
            raise NotTestable(f"the named object {mux} cannot be read: {aborted}") from aborted


@must("upload.length", "data.type-length", "data.expedited-size", length=range(1, 9))
def test_length(sdo: Dialogue, device: Device, roles: Roles, length: int) -> None:
    """A number reads with the length of its type, whatever its value, and the same again."""
    known = roles.number(length)
    data = sdo.upload(known)
    if len(data) != length:
        raise of_another_length(known, data)
    sdo.expect_value(known, device.values[known.mux])


@must("upload.multiplexer", "response.multiplexer", clause=UPLOAD)
def test_multiplexer(sdo: Dialogue, device: Device) -> None:
    """Each answer repeats the multiplexer of its own request."""
    for mux in sorted(device.values)[:8]:
        sdo.upload(mux)


@must("upload.reserved", "response.reserved", "response.unused-count", clause=UPLOAD)
def test_reserved(sdo: Dialogue, device: Device) -> None:
    """Reserved bits, and reserved bytes where there are any, are 0 in the answer to an initiate."""
    for mux in sorted(device.values)[:8]:
        sdo.initiate_upload(mux)
        sdo.end_transfer()
    sdo.expect_clean(RESERVED)


@should("upload.filler", "response.filler", clause=UPLOAD)
def test_filler(sdo: Dialogue, device: Device, roles: Roles) -> None:
    """Bytes that hold no data are 0: nothing of the answer before leaks into a shorter one."""
    short = roles.shortest_readable()
    for mux in sorted(device.values)[:8]:
        sdo.upload(mux)
        sdo.upload(short)
    sdo.expect_clean(FILLER)


@must("upload.object-missing", "object.missing-refused", "abort.precise-code")
def test_object_missing(sdo: Dialogue) -> None:
    """The upload of an object that does not exist is aborted as such."""
    missing = missing_object(sdo)
    sdo.send(UploadInitiate(missing))
    sdo.expect_abort(*MISSING_REFUSED.codes, of=missing)


@must("upload.sub-index-missing", "object.sub-index-missing", "abort.precise-code")
def test_sub_index_missing(sdo: Dialogue) -> None:
    """The upload of a sub-index that a record does not have is aborted as such."""
    missing = missing_sub_index(sdo, IDENTITY_COUNT.index)
    sdo.send(UploadInitiate(missing))
    sdo.expect_abort(*SUB_INDEX_MISSING.codes, of=missing)


@must("upload.sub-index-of-variable", "object.sub-index-missing", sub_index=[1, 2, 0x80])
def test_sub_index_of_variable(sdo: Dialogue, sub_index: int) -> None:
    """A simple variable has sub-index 0 only."""
    mux = Multiplexer(DEVICE_TYPE.index, sub_index)
    sdo.send(UploadInitiate(mux))
    sdo.expect_abort(*SUB_INDEX_MISSING.codes, of=mux)


@must("upload.write-only", "object.write-only")
def test_write_only(sdo: Dialogue, write_only: KnownObject) -> None:
    """The upload of a write-only object is aborted as such."""
    sdo.send(UploadInitiate(write_only.mux))
    sdo.expect_abort(*WRITE_ONLY.codes, of=write_only)


@must("upload.refused-once", "response.answered", clause=ABORT)
def test_refused_once(sdo: Dialogue) -> None:
    """A refused upload is answered by one abort and nothing else."""
    missing = missing_object(sdo)
    sdo.send(UploadInitiate(missing))
    sdo.expect_abort(*MISSING_REFUSED.codes, of=missing)
    sdo.expect_nothing()


@must("upload.refused-is-over", "server.idle-afterwards", clause=ABORT)
def test_refused_is_over(sdo: Dialogue) -> None:
    """After a refused upload the next one is served as if nothing had been."""
    before = sdo.upload(VENDOR_ID)
    missing = missing_object(sdo)
    sdo.send(UploadInitiate(missing))
    sdo.expect_abort(*MISSING_REFUSED.codes, of=missing)
    sdo.expect_value(VENDOR_ID, before)


@may("upload.request-reserved-bits", "request.reserved-bits", bits=[0x01, 0x10, 0x1F])
def test_request_reserved_bits(sdo: Dialogue, bits: int) -> None:
    """Reserved bits of the request may be ignored or refused; silence is neither."""
    due = sdo.upload(VENDOR_ID)
    sdo.send(UploadInitiate(VENDOR_ID.mux, reserved_bits=bits))
    sdo.expect_upload_or_abort(VENDOR_ID, due, *UPLOAD_RESERVED_BITS.codes)


@may(
    "upload.request-reserved-bytes",
    "request.reserved-bytes",
    fill=["FFFFFFFF", "01000000", "00000080"],
)
def test_request_reserved_bytes(sdo: Dialogue, fill: str) -> None:
    """Reserved bytes of the request are ignored, or at most refused; silence is neither."""
    due = sdo.upload(VENDOR_ID)
    sdo.send(UploadInitiate(VENDOR_ID.mux, reserved=bytes.fromhex(fill)))
    sdo.expect_upload_or_abort(
        VENDOR_ID,
        due,
        warned=RESERVED_BYTES.tolerated,
    )


@may("upload.behind-another", "request.behind-another", clause=UPLOAD)
def test_behind_another(sdo: Dialogue) -> None:
    """Of two requests without a pause one may get lost or be refused; none is mixed up."""
    due = {mux: sdo.upload(mux) for mux in (VENDOR_ID.mux, IDENTITY_COUNT)}
    with sdo.channel.without_pause():
        sdo.send(UploadInitiate(IDENTITY_COUNT))
        sdo.send(UploadInitiate(VENDOR_ID.mux))
    # Only behind the first answer: a third request would take the place of both where there is one.
    answers = [sdo.receive(), *sdo.fence()]
    for response in answers:
        if isinstance(response, Abort):
            sdo.checks.abort(response, None)
        elif not isinstance(response, UploadInitiateResponse) or response.mux not in due:
            raise sdo.breach("the answer to one of two uploads", Received(response))
        elif response.expedited and not response.data.startswith(due[response.mux]):
            expected = f"{response.mux} reads {due[response.mux].hex(' ')}"
            raise sdo.breach(expected, Received(response))
    if len(answers) > 2:
        raise sdo.breach("one or two answers", said("{}", len(answers)))
