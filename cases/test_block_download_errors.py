"""What goes wrong in a block download (CiA 301, 7.2.4.3.9 to 7.2.4.3.11 and 7.2.4.3.17)."""

from conformance.device.device import TWO_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.dialogue.block_downloads import (
    begin_block_download,
    send_blocks,
    send_step_by_step,
    unused_in,
)
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.missing_objects import missing_object, missing_sub_index
from conformance.dialogue.wrong_lengths import refusing
from conformance.model_cases.server_states import (
    BLOCK_DOWNLOAD_END,
    BLOCK_DOWNLOAD_FIRST,
    BLOCK_DOWNLOAD_INSIDE,
    State,
    by_name,
)
from conformance.model_cases.variations import UNKNOWN_SPECIFIERS
from conformance.run.case import must
from conformance.run.risks import risk_of_request
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockUploadStart,
    DownloadSegment,
    Request,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import MISSING_REFUSED
from conformance.sdo.rules.block_download import FOREIGN_AT_END as FOREIGN
from conformance.sdo.rules.block_download import TOO_FEW, TOO_MANY, WRONG_CRC
from conformance.sdo.rules.idle import READ_ONLY, SUB_INDEX_MISSING

CRC = "7.2.4.3.16"
FOREIGN_AT_END = {
    "download-segment-00h": DownloadSegment.with_data(b"ABCDEFG", toggle=0).encode(),
    "upload-segment-60h": UploadSegment(0).encode(),
    "block-ack-A2h": BlockAck(1, 127).encode(),
    "block-start-A3h": BlockUploadStart().encode(),
    "unknown-E0h": UNKNOWN_SPECIFIERS["E0h"],
}
STATES: dict[str, State[Request]] = by_name(
    BLOCK_DOWNLOAD_FIRST, BLOCK_DOWNLOAD_INSIDE, BLOCK_DOWNLOAD_END
)


@must(
    "block-download.crc", "crc.algorithm", "crc.placement", flipped=[0x0001, 0x0100, 0x8000, 0xFFFF]
)
def test_crc(sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject, flipped: int) -> None:
    """A wrong CRC is refused as such, and nothing is stored."""
    size = len(room.prepare(text, 14))
    with sdo.unchanged(text):
        if not blocks.offers_crc(text, size):
            sdo.info("the server computes no CRC")
            return
        data = begin_block_download(sdo, text, None, size)
        sdo.send(BlockEnd(unused_in(data), crc16(data) ^ flipped))
        sdo.expect_abort(*WRONG_CRC.codes, of=text, tolerated=WRONG_CRC.tolerated)


@must("block-download.unused-too-many", unused=[1, 7])
def test_unused_too_many(sdo: Dialogue, room: Room, text: KnownObject, unused: int) -> None:
    """An end frame whose n leaves fewer bytes than announced is refused, and nothing is stored."""
    size = len(room.prepare(text, 14))
    with sdo.unchanged(text):
        data = begin_block_download(sdo, text, None, size)
        right = unused_in(data)
        wrong = min(right + unused, 7)
        sdo.send(BlockEnd(wrong, crc16(data[: size + right - wrong])))
        sdo.expect_abort(*TOO_FEW.codes, of=text, tolerated=TOO_FEW.tolerated)


@must("block-download.too-few", "download.size-error-moment")
def test_too_few(sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject) -> None:
    """Fewer bytes than announced are refused, and nothing is stored."""
    size = len(room.prepare(text, 20, least=2))
    with sdo.unchanged(text):
        data = sdo.payload(max(size - 7, 1))
        blocks.expect_download_refused(text, data, *TOO_FEW.codes, size=size)


@must("block-download.too-many", "download.size-error-moment")
def test_too_many(sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject) -> None:
    """More bytes than announced are refused, at the end at the latest, and nothing is stored."""
    announced = room.fit(text, 10)
    room.prepare(text, 21)
    with sdo.unchanged(text):
        data = sdo.payload(announced + 11)
        blocks.expect_download_refused(text, data, *TOO_MANY.codes, size=announced)


@must("block-download.too-many-inside", "block-download.too-many", "download.size-error-moment")
def test_too_many_inside(sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject) -> None:
    """Inside a sub-block, too, a refusal names the download and has a code of CiA 301."""
    room.store(text, sdo.payload(21))
    with sdo.unchanged(text):
        blocks.expect_download_refused(text, sdo.payload(84), *TOO_MANY.codes, size=14)
        sdo.expect_refusals()


@must(
    "block-download.number-too-long",
    "block-download.number-length",
    "abort.length-code",
    length=[1, 2, 4, 5, 6, 7],
)
def test_number_too_long(sdo: Dialogue, blocks: Blocks, roles: Roles, length: int) -> None:
    """More bytes than a number has are refused, at the end at the latest."""
    known = roles.number(length)
    with refusing(sdo, known) as other:
        data = other.longer(length + 1)
        blocks.expect_download_refused(known, data, *TOO_MANY.codes, size=length + 1)


@must(
    "block-download.number-too-short",
    "block-download.number-length",
    "abort.length-code",
    length=[2, 4, 5, 6, 7, 8],
)
def test_number_too_short(sdo: Dialogue, blocks: Blocks, roles: Roles, length: int) -> None:
    """Fewer bytes than a number has are refused, at the end at the latest."""
    known = roles.number(length)
    with refusing(sdo, known) as other:
        data = other.shorter(length - 1)
        blocks.expect_download_refused(known, data, *TOO_FEW.codes, size=length - 1)


@must(
    "block-download.read-only",
    "object.read-only",
    target={"1000h": (0x1000, 0), "1018h-01": (0x1018, 1)},
)
def test_read_only(sdo: Dialogue, blocks: Blocks, target: tuple[int, int]) -> None:
    """A read-only object refuses a block download, at the end at the latest."""
    mux = Multiplexer(*target)
    value = sdo.upload(mux)
    blocks.expect_download_refused(mux, value, *READ_ONLY.codes, size=len(value))
    if sdo.upload(mux) != value:
        raise sdo.breach(f"{mux} keeps its value", "it has changed")


@must(
    "block-download.read-only-size-not-indicated",
    "object.read-only",
    "block-download.size-not-indicated",
    target={"1000h": (0x1000, 0), "1018h-01": (0x1018, 1)},
)
def test_read_only_size_not_indicated(
    sdo: Dialogue, blocks: Blocks, roles: Roles, target: tuple[int, int]
) -> None:
    """A read-only object refuses a block download without a size (C4h), and its value stays."""
    # Without this a server that takes no such download at all would fail for the read-only object.
    blocks.initiate_download(roles.writable(), None)
    sdo.end_transfer()
    mux = Multiplexer(*target)
    value = sdo.upload(mux)
    blocks.expect_download_refused(mux, value, *READ_ONLY.codes, size=None)
    if sdo.upload(mux) != value:
        raise sdo.breach(f"{mux} keeps its value", "it has changed")


@must("block-download.object-missing", "object.missing-refused")
def test_object_missing(sdo: Dialogue, blocks: Blocks) -> None:
    """A block download to an object that does not exist is aborted as such."""
    missing = missing_object(sdo)
    blocks.expect_download_refused(missing, bytes(8), *MISSING_REFUSED.codes, size=8)


@must("block-download.sub-index-missing", "object.sub-index-missing")
def test_sub_index_missing(sdo: Dialogue, blocks: Blocks, number: KnownObject) -> None:
    """A block download to a sub-index that does not exist is aborted as such."""
    missing = missing_sub_index(sdo, number.mux.index)
    blocks.expect_download_refused(missing, bytes(8), *SUB_INDEX_MISSING.codes, size=8)


@must("block-download.foreign-at-end", risk=risk_of_request, request=FOREIGN_AT_END)
def test_foreign_at_end(sdo: Dialogue, room: Room, text: KnownObject, request: bytes) -> None:
    """A request of another service where the end is due ends the download with 05040001h."""
    size = len(room.prepare(text, 14))
    with sdo.unchanged(text):
        data = begin_block_download(sdo, text, None, size)
        sdo.send(request)
        sdo.expect_abort(*FOREIGN.codes, of=text)
        sdo.expect_dead(BlockEnd(unused_in(data), crc16(data)))


@must(
    "block-download.client-abort",
    "block-download.abort-in-sub-block",
    "block-download.abort-before-end",
    "server.value-kept",
    "server.part-written",
    state=STATES,
)
def test_client_abort(sdo: Dialogue, room: Room, text: KnownObject, state: State[Request]) -> None:
    """An abort of the client is not answered, ends the download, and nothing is stored."""
    size = len(room.prepare(text, 14, least=state.least))
    with sdo.unchanged(text):
        state.reach(sdo, text, size)
        sdo.send(Abort(text.mux, AbortCode.GENERAL_ERROR))
        sdo.expect_nothing()


@must(
    "block-download.number-kept",
    "server.value-kept",
    ending={"client-abort": False, "wrong-crc": True},
)
def test_number_kept(sdo: Dialogue, roles: Roles, ending: bool) -> None:
    """A number keeps its value where its download is aborted, or its CRC is wrong."""
    known = roles.longest_number()
    with sdo.unchanged(known) as value:
        data = bytes(byte ^ 1 for byte in value)
        checked = send_blocks(sdo, known, data, None).crc_supported
        if ending and not checked:
            sdo.info("the server computes no CRC")
        elif ending:
            sdo.send(BlockEnd(unused_in(data), crc16(data) ^ 1))
            sdo.expect_abort(*WRONG_CRC.codes, of=known, tolerated=WRONG_CRC.tolerated)
        else:
            sdo.end_transfer()


@must(
    "block-download.client-abort-then-end",
    "block-download.abort-before-end",
    "time-out.client",
    "server.value-kept",
)
def test_client_abort_then_end(sdo: Dialogue, room: Room, text: KnownObject) -> None:
    """An end frame right behind an abort completes nothing."""
    size = len(room.prepare(text, 14))
    with sdo.unchanged(text):
        data = begin_block_download(sdo, text, None, size)
        sdo.send(Abort(text.mux, AbortCode.TIMED_OUT))
        sdo.expect_dead(BlockEnd(unused_in(data), crc16(data)))


@must(
    "block-download.end-repeated",
    "server.nothing-afterwards",
    "block-download.stored",
    clause="7.2.4.3.11",
)
def test_end_repeated(sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject) -> None:
    """The end once more, behind its confirmation, is not confirmed again, and stores nothing."""
    data = sdo.payload(room.fit(text, 14))
    response = blocks.initiate_download(text, len(data))
    *_, last = send_step_by_step(sdo, text, data, response)
    sdo.expect_dead(last.request)
    sdo.expect_value(text, data)
    other = sdo.payload(len(data))
    sdo.download(text, other)
    sdo.expect_dead(last.request)
    sdo.expect_value(text, other)


@must("block-download.restart", "server.nothing-afterwards", "time-out.client")
def test_restart(sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject) -> None:
    """After an abort the next block download holds nothing of the old one."""
    size = len(room.prepare(text, 14, least=TWO_SEGMENTS))
    begin_block_download(sdo, text, 1, size)
    sdo.send(Abort(text.mux, AbortCode.TIMED_OUT))
    data = sdo.payload(size)
    sdo.send(BlockDownloadInitiate.with_size(text.mux, size))
    sdo.checks.block_download_initiate(sdo.receive(), text.mux)
    sdo.send(Abort(text.mux, AbortCode.TIMED_OUT))
    blocks.download(text, data)
    sdo.expect_value(text, data)
