"""Downloads of up to 4 bytes within the initiate (CiA 301, 7.2.4.3.3)."""

from conformance.device.device import DEVICE_TYPE, Device
from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.missing_objects import missing_object, missing_sub_index
from conformance.dialogue.values import same_value
from conformance.dialogue.wrong_lengths import refusing
from conformance.run.case import may, must, should
from conformance.sdo.describe import shown
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    DownloadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import same_data
from conformance.sdo.rules import MISSING_REFUSED, RESERVED, accepted
from conformance.sdo.rules.download_initiates import (
    DOWNLOAD_RESERVED_BIT,
    TOO_LONG,
    TOO_SHORT,
    UNUSED_WITHOUT_SIZE,
)
from conformance.sdo.rules.idle import READ_ONLY, SUB_INDEX_MISSING
from conformance.sdo.seen import Data

DOWNLOAD = "7.2.4.3.3"
ABORT = "7.2.4.3.17"
EXPEDITED = 4
AS_WRITTEN_SIZES = (5, 64)
MOST_STRINGS = 3


@must(
    "download.stored",
    "response.not-refused",
    "data.expedited-size",
    "data.type-length",
    clause=DOWNLOAD,
    length=[1, 2, 3, 4],
)
def test_stored(sdo: Dialogue, roles: Roles, length: int) -> None:
    """A number that was written reads back as it was written."""
    known = roles.number(length)
    sdo.expect_value(known, sdo.write_number(known, segmented=False))


@must("download.confirmation", "response.multiplexer", "response.reserved", clause=DOWNLOAD)
def test_confirmation(sdo: Dialogue, number: KnownObject) -> None:
    """The confirmation is 60h with the multiplexer of the request, all reserved bytes 0."""
    value = sdo.upload(number)
    sdo.send(
        DownloadInitiate.with_data(number.mux, value)
        if len(value) <= 4
        else DownloadInitiate.with_size(number.mux, len(value))
    )
    sdo.expect(DownloadInitiateResponse(number.mux))


@must("download.same-value", "response.not-refused", clause=DOWNLOAD)
def test_same_value(sdo: Dialogue, number: KnownObject) -> None:
    """A writable object takes the value that it has."""
    with sdo.unchanged(number) as value:
        sdo.download(number, value)


@must("download.twice", "response.not-refused", clause=DOWNLOAD)
def test_twice(sdo: Dialogue, number: KnownObject) -> None:
    """One value after another: the last one stays."""
    before = sdo.upload(number)
    changed = sdo.write_number(number)
    sdo.download(number, before)
    sdo.expect_value(number, before)
    # What a case before this one wrote decides which write a faulty server loses; the first one
    # may have been it, and is not seen above.
    for value in (changed, before):
        sdo.download(number, value)
        sdo.expect_value(number, value)


@must(
    "download.text",
    "response.not-refused",
    "data.expedited-size",
    "data.variable-length",
    clause=DOWNLOAD,
    size=[1, 2, 3, 4],
)
def test_text(sdo: Dialogue, room: Room, variable: KnownObject, size: int) -> None:
    """A string takes 1 to 4 bytes in one frame, and has that length afterwards."""
    data = sdo.payload(size)
    room.store(variable, data)
    sdo.expect_value(variable, data)


@should("download.as-written", "data.as-written")
def test_as_written(sdo: Dialogue, roles: Roles, variable: KnownObject) -> None:
    """A string keeps what was written: it is neither cut nor filled up with blanks."""
    for known in dict.fromkeys([variable, *roles.varying()[:MOST_STRINGS]]):
        for size in AS_WRITTEN_SIZES:
            data = sdo.payload(size)
            if sdo.try_download(known, data) is None:
                found = sdo.upload(known)
                if not same_data(known.data_type, found, data):
                    raise sdo.breach(f"{known} reads {shown(data)}", Data(found))


@must("download.size-not-indicated")
def test_size_not_indicated(sdo: Dialogue, roles: Roles) -> None:
    """22h with 4 bytes for an object of 4 bytes is served: the type says how many count."""
    known = roles.number(4)
    sdo.expect_value(known, sdo.write_number(known, segmented=False, sized=False))


@may("download.size-not-indicated-short", length=[1, 2, 3])
def test_size_not_indicated_short(sdo: Dialogue, roles: Roles, length: int) -> None:
    """22h for a shorter object stores the low bytes, or is refused for its length."""
    known = roles.number(length)
    before = sdo.upload(known)
    wanted = bytes([before[0] ^ 1]) + before[1:]
    sdo.send(DownloadInitiate.with_uncounted_data(known.mux, wanted))
    answer = sdo.receive()
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, known.mux)
        sdo.expect_value(known, before)
    else:
        sdo.checks.download_initiate(answer, known.mux)
        sdo.expect_value(known, wanted)


@must("download.unused-bytes-ignored", length=[1, 2, 3])
def test_unused_bytes_ignored(sdo: Dialogue, roles: Roles, length: int) -> None:
    """Bytes behind the data are not looked at, and never stored."""
    known = roles.number(length)
    with sdo.unchanged(known) as value:
        payload = value.ljust(4, b"\xff")
        sdo.send(DownloadInitiate(known.mux, True, True, 4 - length, payload))
        sdo.expect(DownloadInitiateResponse(known.mux))


@must("download.unused-bytes-of-text", "download.unused-bytes-ignored", size=[1, 2, 3])
def test_unused_bytes_of_text(sdo: Dialogue, room: Room, variable: KnownObject, size: int) -> None:
    """A string gets the bytes that count and none of those behind them."""
    data = sdo.payload(size)
    room.store(variable, data)
    payload = data.ljust(4, b"#")
    sdo.send(DownloadInitiate(variable.mux, True, True, 4 - size, payload))
    sdo.expect(DownloadInitiateResponse(variable.mux))
    sdo.expect_value(variable, data)


@must(
    "download.too-long",
    "abort.length-code",
    lengths={
        "2-into-1": (1, 2),
        "4-into-1": (1, 4),
        "3-into-2": (2, 3),
        "4-into-2": (2, 4),
        "4-into-3": (3, 4),
    },
)
def test_too_long(sdo: Dialogue, roles: Roles, lengths: tuple[int, int]) -> None:
    """More bytes than the type has are refused for their length, and nothing is written."""
    length, sent = lengths
    known = roles.number(length)
    with refusing(sdo, known) as other:
        sdo.send(DownloadInitiate.with_data(known.mux, other.longer(sent)))
        sdo.expect_abort(*TOO_LONG.codes, of=known)


@must(
    "download.too-short",
    "abort.length-code",
    lengths={
        "1-into-2": (2, 1),
        "2-into-3": (3, 2),
        "1-into-4": (4, 1),
        "2-into-4": (4, 2),
        "3-into-4": (4, 3),
        "4-into-8": (8, 4),
    },
)
def test_too_short(sdo: Dialogue, roles: Roles, lengths: tuple[int, int]) -> None:
    """Fewer bytes than the type has are refused for their length, and nothing is written."""
    length, sent = lengths
    known = roles.number(length)
    with refusing(sdo, known) as other:
        sdo.send(DownloadInitiate.with_data(known.mux, other.shorter(sent)))
        sdo.expect_abort(*TOO_SHORT.codes, of=known)


@must(
    "download.read-only", "object.read-only", target={"1000h": (0x1000, 0), "1018h-01": (0x1018, 1)}
)
def test_read_only(sdo: Dialogue, target: tuple[int, int]) -> None:
    """A read-only object refuses even the value that it has."""
    mux = Multiplexer(*target)
    value = sdo.upload(mux)
    sdo.send(DownloadInitiate.with_data(mux, value[:4]))
    sdo.expect_abort(*READ_ONLY.codes, of=mux)
    if sdo.upload(mux) != value:
        raise sdo.breach(f"{mux} keeps its value", "it has changed")


@must("download.object-missing", "object.missing-refused", "abort.precise-code")
def test_object_missing(sdo: Dialogue) -> None:
    """The download to an object that does not exist is aborted as such."""
    missing = missing_object(sdo)
    sdo.send(DownloadInitiate.with_data(missing, b"\0\0\0\0"))
    sdo.expect_abort(*MISSING_REFUSED.codes, of=missing)


@must("download.sub-index-missing", "object.sub-index-missing")
def test_sub_index_missing(sdo: Dialogue, number: KnownObject) -> None:
    """The download to a sub-index that a writable object does not have is aborted as such."""
    missing = missing_sub_index(sdo, number.mux.index)
    sdo.send(DownloadInitiate.with_data(missing, b"\0\0\0\0"))
    sdo.expect_abort(*SUB_INDEX_MISSING.codes, of=missing)


@must("download.sub-index-of-variable", "object.sub-index-missing", sub_index=[0x01, 0x02, 0xFE])
def test_sub_index_of_variable(sdo: Dialogue, device: Device, roles: Roles, sub_index: int) -> None:
    """A variable has sub-index 0 only: a download to another is aborted, and nothing changes.

    The value that the variable has is sent, and only when no other entry is read there.
    """
    known = roles.writable_variable()
    mux = Multiplexer(known.mux.index, sub_index)
    with sdo.unchanged(known) as value:
        present = sdo.read_if_there(mux)
        if present is not None and not same_value(known, present, value):
            raise sdo.breach(f"{mux} to be refused as missing", Data(present, "it"))
        device.policy.allow_missing(mux)
        if 1 <= len(value) <= EXPEDITED:
            sdo.send(DownloadInitiate.with_data(mux, value))
        else:
            sdo.send(DownloadInitiate.with_size(mux, len(value)))
        sdo.expect_abort(*SUB_INDEX_MISSING.codes, of=mux)


@must("download.write-only", "response.not-refused", clause=DOWNLOAD)
def test_write_only(sdo: Dialogue, write_only: KnownObject) -> None:
    """A write-only object takes a value."""
    length = write_only.length or 4
    sdo.download(write_only, bytes(length))


@must("download.refused-once", "response.answered", clause=ABORT)
def test_refused_once(sdo: Dialogue) -> None:
    """A refused download is answered by one abort and nothing else."""
    value = sdo.upload(DEVICE_TYPE)
    sdo.send(DownloadInitiate.with_data(DEVICE_TYPE, value[:4]))
    sdo.expect_abort(*READ_ONLY.codes, of=DEVICE_TYPE)
    sdo.expect_nothing()


@must("download.refused-is-over", "server.idle-afterwards", clause=ABORT)
def test_refused_is_over(sdo: Dialogue, roles: Roles) -> None:
    """After a refused download the right one is served."""
    known = roles.number(4)
    before = sdo.upload(known)
    sdo.send(DownloadInitiate.with_data(known.mux, before[:2]))
    sdo.expect_abort(*accepted.WRONG_LENGTH, of=known)
    sdo.expect_value(known, sdo.write_number(known))


@may("download.request-reserved-bit", "request.reserved-bits", command={"33h": 0x33, "37h": 0x37})
def test_request_reserved_bit(sdo: Dialogue, roles: Roles, command: int) -> None:
    """Bit 4 of the request may be ignored or refused; silence is neither."""
    known = roles.number(4 - ((command >> 2) & 3))
    with sdo.unchanged(known) as value:
        unused = 4 - len(value)
        request = DownloadInitiate(known.mux, True, True, unused, value.ljust(4, b"\0"), 1)
        sdo.send(request)
        sdo.expect_download_or_abort(known, *DOWNLOAD_RESERVED_BIT.codes)


@may("download.unused-without-size", unused=[1, 2, 3])
def test_unused_without_size(sdo: Dialogue, roles: Roles, unused: int) -> None:
    """n without an indicated size is ignored or refused; it never shortens the data."""
    known = roles.number(4)
    with sdo.unchanged(known) as value:
        sdo.send(DownloadInitiate(known.mux, True, False, unused, value))
        # A server that reads n finds too few bytes for the type.
        sdo.expect_download_or_abort(
            known, *UNUSED_WITHOUT_SIZE.codes, tolerated=UNUSED_WITHOUT_SIZE.tolerated
        )


@must("download.reserved", "response.reserved", clause=DOWNLOAD)
def test_reserved(sdo: Dialogue, roles: Roles) -> None:
    """Reserved bits and bytes of the confirmation are 0, whatever was written."""
    for length in (1, 2, 4):
        known = roles.number(length)
        sdo.download(known, sdo.upload(known))
    sdo.expect_clean(RESERVED)


@must("download.neighbours", "response.not-refused", clause=DOWNLOAD)
def test_neighbours(sdo: Dialogue, device: Device, number: KnownObject) -> None:
    """A download changes its own object and no other."""
    brief = device.briefly_read()
    others = [known for known in device.objects if known.mux != number.mux and known.mux in brief]
    before = {known: sdo.upload(known) for known in others}
    sdo.write_number(number)
    for known, value in before.items():
        sdo.expect_value(known, value)
