"""Downloads in segments: what is stored, and how they are refused (CiA 301, 7.2.4.3.3 and .4)."""

from conformance.device.device import DEVICE_TYPE, IDENTITY_COUNT
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.missing_objects import missing_object, missing_sub_index
from conformance.dialogue.object_expectations import expect_stored_and_read
from conformance.model_cases.variations import BEYOND_16_BITS, EDGE_SIZES, LONG_SIZES, SHORT_SIZES
from conformance.run.case import may, must, should
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    DownloadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import MISSING_REFUSED, RESERVED, Violation, accepted
from conformance.sdo.rules.download_initiates import (
    DOWNLOAD_RESERVED_BIT,
    UNUSED_WITHOUT_SIZE,
)
from conformance.sdo.rules.idle import READ_ONLY, SUB_INDEX_MISSING
from conformance.sdo.rules.segmented_download import TOO_FEW
from conformance.sdo.seen import Received

INITIATE = "7.2.4.3.3"
SEGMENT = "7.2.4.3.4"
ABORT = "7.2.4.3.17"


@must("segmented-download.beyond-16-bits", "segmented-download.stored", size=[BEYOND_16_BITS])
def test_beyond_16_bits(sdo: Dialogue, room: Room, blocks: Blocks, roles: Roles, size: int) -> None:
    """A download of more bytes than 16 bits count is stored whole, where there is room."""
    variable = roles.variable(size)
    if size in sdo.device.learned.lengths[variable.mux].whole:
        return  # block-upload.beyond-16-bits has written and read it
    room.check_length(variable, size)
    data = sdo.payload(size)
    abort = sdo.try_download(variable, data)
    if abort is not None:
        raise room.refused(variable, size, abort)
    blocks.expect_value(variable, data)
    sdo.device.learned.lengths[variable.mux].whole.add(size)


@must(
    "segmented-download.size",
    "segmented-download.stored",
    "segmented-download.confirmed",
    "response.toggle",
    size=[*SHORT_SIZES, *LONG_SIZES],
)
def test_size(sdo: Dialogue, room: Room, roles: Roles, size: int) -> None:
    """A download of an indicated size is stored whole."""
    expect_stored_and_read(sdo, room, roles.variable(size), size)


@must("segmented-download.size-not-indicated", size=[*EDGE_SIZES, 257])
def test_size_not_indicated(
    sdo: Dialogue, room: Room, blocks: Blocks, roles: Roles, size: int
) -> None:
    """A download that does not say its size (20h) is stored whole."""
    variable, data = roles.variable(size), sdo.payload(size)
    room.store(variable, data, segmented=True, sized=False)
    blocks.expect_value(variable, data)


@must(
    "segmented-download.number",
    "segmented-download.stored",
    "data.short-in-segments",
    length=range(1, 9),
)
def test_number(sdo: Dialogue, roles: Roles, length: int) -> None:
    """A number may come in a segment, however short it is."""
    known = roles.number(length)
    sdo.expect_value(known, sdo.write_number(known, segmented=True))


@must(
    "segmented-download.number-size-not-indicated",
    "segmented-download.size-not-indicated",
    "data.short-in-segments",
    length=range(1, 9),
)
def test_number_size_not_indicated(sdo: Dialogue, roles: Roles, length: int) -> None:
    """A number may come in a segment without its size (20h)."""
    known = roles.number(length)
    sdo.expect_value(known, sdo.write_number(known, segmented=True, sized=False))


@must("segmented-download.write-only", "response.not-refused", clause=INITIATE)
def test_write_only(sdo: Dialogue, write_only: KnownObject) -> None:
    """A write-only object takes a value in a segment."""
    sdo.download(write_only, bytes(write_only.length or 4), segmented=True)


@should("segmented-download.empty-last", size=[7, 14])
def test_empty_last(sdo: Dialogue, room: Room, variable: KnownObject, size: int) -> None:
    """The last segment may hold no data when all bytes have come."""
    data = sdo.payload(size)
    room.store(variable, data)
    data = sdo.payload(size)
    sdo.initiate_download(variable, size)
    for start in range(0, size, 7):
        sdo.download_segment(data[start : start + 7], toggle=start // 7 % 2)
    _take_or_miss(sdo, variable, DownloadSegment.with_data(b"", toggle=size // 7 % 2, last=True))
    sdo.expect_value(variable, data)


def _take_or_miss(sdo: Dialogue, known: KnownObject, segment: DownloadSegment) -> None:
    """Send a segment that has to be taken; to refuse it for its length misses a SHOULD."""
    with sdo.served():
        sdo.send(segment)
        answer = sdo.receive()
        if isinstance(answer, Abort) and answer.code in accepted.ANY_LENGTH_ERROR:
            sdo.checks.abort(answer, known.mux)
            raise sdo.breach("the segment to be taken", Received(answer))
        sdo.checks.download_segment(answer, known.mux, segment.toggle)


@should(
    "segmented-download.short-segments",
    lengths={"3-then-5": (3, 5), "1-1-1-1-1": (1, 1, 1, 1, 1), "6-7-2": (6, 7, 2)},
)
def test_short_segments(
    sdo: Dialogue, room: Room, variable: KnownObject, lengths: tuple[int, ...]
) -> None:
    """Segments before the last may hold fewer than 7 bytes; only their data is stored."""
    room.store(variable, sdo.payload(sum(lengths)))
    sdo.initiate_download(variable, sum(lengths))
    data = b""
    for number, length in enumerate(lengths):
        chunk = sdo.payload(length)
        data += chunk
        last = number == len(lengths) - 1
        _take_or_miss(sdo, variable, DownloadSegment.with_data(chunk, toggle=number % 2, last=last))
    sdo.expect_value(variable, data)


FILLED = {
    f"{size}-{name}": (size, sized)
    for size in (1, 4, 8, 13)
    for name, sized in (("sized", True), ("unsized", False))
}


@must("segmented-download.filler-ignored", how=FILLED)
def test_filler_ignored(
    sdo: Dialogue, room: Room, variable: KnownObject, how: tuple[int, bool]
) -> None:
    """Bytes of the last segment behind its data are not stored."""
    size, sized = how
    data = sdo.payload(size)
    room.store(variable, data)
    sdo.initiate_download(variable, size if sized else None)
    for start in range(0, size - 7, 7):
        sdo.download_segment(data[start : start + 7], toggle=start // 7 % 2)
    start = (size - 1) // 7 * 7
    rest = data[start:]
    toggle = start // 7 % 2
    sdo.send(DownloadSegment(rest.ljust(7, b"#"), toggle, 7 - len(rest), True))
    sdo.checks.download_segment(sdo.receive(), variable.mux, toggle)
    sdo.expect_value(variable, data)


@may("segmented-download.unused-not-stated")
def test_unused_not_stated(sdo: Dialogue, room: Room, text: KnownObject) -> None:
    """n = 0 in a last segment that is not full: the announced bytes are stored, or none."""
    data = sdo.payload(room.fit(text, 8))
    before = room.prepare(text, 9)
    chunks = [data[start : start + 7] for start in range(0, len(data), 7)]
    toggle = 1 - len(chunks) % 2
    if len(chunks[-1]) == 7:
        raise NotTestable(
            f"values of {len(data)} bytes fill their last segment: name another string"
        )
    sdo.initiate_download(text, len(data))
    for number, chunk in enumerate(chunks[:-1]):
        sdo.download_segment(chunk, toggle=number % 2)
    sdo.send(DownloadSegment(chunks[-1].ljust(7, b"#"), toggle, 0, True))
    answer = sdo.receive()
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, text.mux)
        sdo.expect_kept(text, before)
    else:
        sdo.checks.download_segment(answer, text.mux, toggle)
        sdo.expect_value(text, data)


@may("segmented-download.empty", "data.empty")
def test_empty(sdo: Dialogue, room: Room, text: KnownObject) -> None:
    """A download of no bytes stores an empty value or is refused; it never hangs."""
    before = room.prepare(text, 9)
    if sdo.try_download(text, b"", segmented=True) is not None:
        sdo.expect_kept(text, before)
    else:
        room.restore_own(text)  # what is empty may be refused to the next case


@must(
    "segmented-download.read-only",
    "object.read-only",
    target={"1000h": (0x1000, 0), "1018h-01": (0x1018, 1)},
)
def test_read_only(sdo: Dialogue, target: tuple[int, int]) -> None:
    """A read-only object refuses a segmented download, at the latest with the last segment."""
    mux = Multiplexer(*target)
    value = sdo.upload(mux)
    sdo.expect_download_refused(mux, value, *READ_ONLY.codes, size=len(value))
    if sdo.upload(mux) != value:
        raise sdo.breach(f"{mux} keeps its value", "it has changed")


@must("segmented-download.read-only-text", "object.read-only")
def test_read_only_text(sdo: Dialogue, read_only_text: KnownObject) -> None:
    """A constant text refuses the value that it has."""
    value = sdo.upload(read_only_text)
    sdo.expect_download_refused(read_only_text, value, *READ_ONLY.codes, size=len(value))
    sdo.expect_value(read_only_text, value)


@must("segmented-download.object-missing", "object.missing-refused")
def test_object_missing(sdo: Dialogue) -> None:
    """A segmented download to an object that does not exist is aborted as such."""
    missing = missing_object(sdo)
    sdo.expect_download_refused(missing, bytes(8), *MISSING_REFUSED.codes, size=8)


@must("segmented-download.sub-index-missing", "object.sub-index-missing")
def test_sub_index_missing(sdo: Dialogue, number: KnownObject) -> None:
    """A segmented download to a sub-index that does not exist is aborted as such."""
    missing = missing_sub_index(sdo, number.mux.index)
    sdo.expect_download_refused(missing, bytes(8), *SUB_INDEX_MISSING.codes, size=8)


@must("segmented-download.reserved", "response.reserved", clause=SEGMENT)
def test_reserved(sdo: Dialogue, room: Room, variable: KnownObject) -> None:
    """Reserved bits and bytes of the confirmations (60h, 20h, 30h) are 0."""
    room.prepare(variable, 20)
    sdo.expect_clean(RESERVED)


@may(
    "segmented-download.request-reserved-bit",
    "download.request-reserved-bit",
    "request.reserved-bits",
)
def test_request_reserved_bit(sdo: Dialogue, room: Room, variable: KnownObject) -> None:
    """Bit 4 of a segmented initiate may be ignored or refused; silence is neither."""
    size = room.fit(variable, 8).to_bytes(4, "little")
    sdo.send(DownloadInitiate(variable.mux, sized=True, payload=size, reserved_bits=1))
    sdo.expect_download_or_abort(variable, *DOWNLOAD_RESERVED_BIT.codes)


@may("segmented-download.unused-without-data", "download.unused-without-size", unused=[1, 3])
def test_unused_without_data(sdo: Dialogue, room: Room, variable: KnownObject, unused: int) -> None:
    """n in a segmented initiate has no meaning: it is ignored or refused."""
    size = room.fit(variable, 8).to_bytes(4, "little")
    sdo.send(DownloadInitiate(variable.mux, sized=True, unused=unused, payload=size))
    sdo.expect_download_or_abort(variable, *UNUSED_WITHOUT_SIZE.codes)


@may(
    "segmented-download.request-reserved-bytes",
    "request.reserved-bytes",
    "segmented-download.size-not-indicated",
    clause=INITIATE,
)
def test_request_reserved_bytes(sdo: Dialogue, room: Room, text: KnownObject) -> None:
    """Without a size (20h) bytes 4 to 7 are reserved: ignored, or at most refused."""
    data = room.prepare(text, 9)
    sdo.send(DownloadInitiate(text.mux, payload=b"\xff\xff\xff\xff"))
    answer = sdo.receive()
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, text.mux)
        return
    sdo.checks.download_initiate(answer, text.mux)
    sdo.download_segments(data)
    sdo.expect_value(text, data)


@must(
    "segmented-download.refused-is-over",
    "server.idle-afterwards",
    "server.nothing-afterwards",
    clause=ABORT,
)
def test_refused_is_over(sdo: Dialogue, room: Room, text: KnownObject) -> None:
    """After a refused download the next one is stored, with nothing of the old one in it."""
    data = sdo.payload(room.fit(text, 12))
    size = len(room.prepare(text, 14, least=2))
    try:
        sdo.expect_download_refused(
            text, sdo.payload(max(size - 4, 1)), *accepted.WRONG_LENGTH, size=size
        )
    except Violation as breach:
        if breach.rule is sdo.record.rule:
            breach.rule = TOO_FEW
        raise
    sdo.download(text, data)
    sdo.expect_value(text, data)


@must("segmented-download.other-objects", "segmented-download.stored")
def test_other_objects(sdo: Dialogue, room: Room, text: KnownObject, number: KnownObject) -> None:
    """A segmented download changes its own object and no other."""
    before = {mux: sdo.upload(mux) for mux in (DEVICE_TYPE, IDENTITY_COUNT, number.mux)}
    room.prepare(text, 16)
    for mux, value in before.items():
        if sdo.upload(mux) != value:
            raise sdo.breach(f"{mux} keeps its value", "it has changed")
