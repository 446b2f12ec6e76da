"""CAN frames as such: identifiers, formats, data length (CiA 301, 7.2.4.3 and 7.3.3)."""

from conformance.bus.strangers import asked_by_others
from conformance.device.device import DEVICE_TYPE, IDENTITY_COUNT, VENDOR_ID, Device
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.missing_objects import missing_object
from conformance.run.case import may, must, should
from conformance.run.risks import EXTENDED, REMOTE, of_length
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE
from conformance.sdo.describe import in_words
from conformance.sdo.frames import (
    Abort,
    BlockEnd,
    BlockEndResponse,
    DownloadInitiate,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.rules import FRAME_SHAPE, MISSING_REFUSED
from conformance.sdo.seen import Received, Said

SHAPE = "7.2.4.3"
CHANNEL = "7.3.3"
READ_VENDOR_ID = UploadInitiate(VENDOR_ID.mux).encode()


@must("frame.one-answer", "response.answered", "response.unsolicited", clause=SHAPE)
def test_one_answer(sdo: Dialogue) -> None:
    """A request is answered by one frame and not by two."""
    sdo.initiate_upload(VENDOR_ID)
    sdo.end_transfer()
    sdo.expect_nothing()


@must("frame.one-identifier", "response.frame", clause=CHANNEL)
def test_one_identifier(sdo: Dialogue) -> None:
    """A response is sent on the channel's own identifier and on no other."""
    sdo.send(UploadInitiate(VENDOR_ID.mux))
    answer = sdo.receive()
    sdo.expect_nothing()
    others = asked_by_others(sdo.channel.overheard)
    for frame in sdo.channel.overheard:
        if frame.data == answer.encode() and frame.can_id & 0x7F not in others:
            raise sdo.breach(
                f"nothing but {sdo.channel.ids.response}", Said(f"also {frame}", "also …#…")
            )


@must("frame.abort-identifier", "response.frame", clause=CHANNEL)
def test_abort_identifier(sdo: Dialogue) -> None:
    """A refusal is sent on the identifier of the responses, as any other answer."""
    missing = missing_object(sdo)
    sdo.send(UploadInitiate(missing))
    sdo.expect_abort(*MISSING_REFUSED.codes, of=missing)
    sdo.expect_clean(FRAME_SHAPE)


@must("frame.other-node", "channel.request-identifier", bit=[0, 1, 2, 3, 4, 5, 6])
def test_other_node(sdo: Dialogue, device: Device, bit: int) -> None:
    """A request to another node is not answered. Each bit of the node-ID counts."""
    other = device.node_id ^ 1 << bit
    if other == 0:
        return  # 600h belongs to no node
    if other in device.neighbours:
        raise NotTestable(f"node {other} is under test as well: test node {device.node_id} alone")
    sdo.send_frame(CanFrame(REQUEST_BASE + other, READ_VENDOR_ID))
    sdo.expect_nothing()


@must("frame.remote", "channel.remote", risk=REMOTE, dlc=[0, 8])
def test_remote(sdo: Dialogue, dlc: int) -> None:
    """A remote frame carries no request: nothing may be served in answer to it."""
    sdo.upload(VENDOR_ID)
    request = sdo.channel.ids.request
    sdo.send_frame(CanFrame(request.can_id, b"", request.extended, remote=True, length=dlc))
    sdo.expect_silence_or_abort()


@should("frame.remote-ignored", "channel.remote-ignored", risk=REMOTE)
def test_remote_ignored(sdo: Dialogue) -> None:
    """A remote frame on the request identifier is ignored."""
    sdo.upload(VENDOR_ID)
    request = sdo.channel.ids.request
    sdo.send_frame(CanFrame(request.can_id, b"", request.extended, remote=True, length=8))
    sdo.expect_nothing()


@should("frame.extended-ignored", "channel.extended-ignored", risk=EXTENDED)
def test_extended_ignored(sdo: Dialogue) -> None:
    """A 29-bit identifier of the same number is another identifier: the frame is ignored."""
    request = sdo.channel.ids.request
    if request.extended:
        raise NotTestable("needs an SDO channel with 11-bit identifiers")
    sdo.send_frame(CanFrame(request.can_id, READ_VENDOR_ID, extended=True))
    sdo.expect_nothing()


@may("frame.short", risk=of_length, dlc=[0, 1, 2, 3, 4, 5, 6, 7])
def test_short(sdo: Dialogue, dlc: int) -> None:
    """A request of fewer than 8 bytes is ignored, refused or, when whole, served rightly.

    Data of another request must not fill in what was not sent.
    """
    due = sdo.upload(VENDOR_ID)
    sdo.send(READ_VENDOR_ID[:dlc])
    whole = dlc >= 4
    if whole:
        sdo.line.open = VENDOR_ID.mux  # the server may have begun a transfer
    answer = sdo.reaction()
    if answer is None:
        return
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, None)
        return
    if not whole:
        raise sdo.breach("no answer, or an abort", Received(answer))
    response = sdo.checks.upload_initiate(answer, VENDOR_ID.mux)
    if response.expedited and response.data[: len(due)] != due:
        raise sdo.breach(f"1018h:01 reads {due.hex(' ')}", Received(answer))


@may(
    "frame.short-download",
    risk=lambda lengths: of_length(lengths[1]),
    lengths={"4-of-4": (4, 7), "1-of-2": (2, 5), "none-of-4": (4, 4)},
)
def test_short_download(sdo: Dialogue, roles: Roles, lengths: tuple[int, int]) -> None:
    """A download whose data is cut off must not change the object."""
    length, dlc = lengths
    known = roles.number(length)
    with sdo.unchanged(known) as value:
        wanted = bytes(byte ^ 1 for byte in value)
        sdo.send(DownloadInitiate.with_data(known.mux, wanted).encode()[:dlc])
        answer = sdo.reaction()
        if answer is not None and not isinstance(answer, Abort):
            raise sdo.breach("no answer, or an abort", Received(answer))


@may("frame.short-download-whole", risk=lambda length: of_length(4 + length), length=[1, 2])
def test_short_download_whole(sdo: Dialogue, roles: Roles, length: int) -> None:
    """A short download that holds all its data may be served; if so, it is stored rightly."""
    known = roles.number(length)
    before = sdo.upload(known)
    wanted = bytes([before[0] ^ 1]) + before[1:]
    sdo.send(DownloadInitiate.with_data(known.mux, wanted).encode()[: 4 + length])
    answer = sdo.reaction()
    served = answer is not None and not isinstance(answer, Abort)
    sdo.expect_value(known, wanted if served else before)


@may("frame.short-segment", risk=of_length, dlc=[1, 4])
def test_short_segment(sdo: Dialogue, room: Room, text: KnownObject, dlc: int) -> None:
    """A segment that is cut off must not complete a download."""
    size = room.fit(text, 7)
    room.prepare(text, 14)
    with sdo.unchanged(text):
        sdo.initiate_download(text, size)
        sdo.send((b"\x01" + sdo.payload(7))[:dlc])
        answer = sdo.reaction()
        if answer is not None and not isinstance(answer, Abort):
            raise sdo.breach("no answer, or an abort", Received(answer))


@may("frame.short-segment-request", risk=of_length, dlc=[1, 4, 7])
def test_short_segment_request(sdo: Dialogue, room: Room, dlc: int) -> None:
    """A request for a segment that is cut short brings the segment that is due, or no data."""
    known, data = room.long_object()
    sdo.start_segmented_upload(known)
    sdo.send(UploadSegment(0).encode()[:dlc])
    answer = sdo.reaction()
    if answer is None:
        return
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, None)
        return
    segment = sdo.checks.upload_segment(answer, known.mux, 0)
    if not data.startswith(segment.data):
        raise sdo.breach(f"the first segment of {known}, or no data", Received(answer))


@may("frame.short-block-segment", risk=of_length, dlc=[1, 4])
def test_short_block_segment(
    sdo: Dialogue, room: Room, blocks: Blocks, text: KnownObject, dlc: int
) -> None:
    """A segment of a block download that is cut off must not complete it.

    The end request follows at once, without a CRC to refuse it for.
    """
    size = room.fit(text, 7)
    room.prepare(text, 14)
    with sdo.unchanged(text):
        blocks.initiate_download(text, size, crc=False)
        sdo.silence.calms_down = False  # what comes is the point, and no noise
        sdo.send((b"\x81" + sdo.payload(7))[:dlc])
        end = BlockEnd(0)
        # A refusal of the short segment may be here by now: it is none to the end.
        sdo.send_frame(sdo.channel.ids.request.frame(end.encode()))
        sdo.end_transfer()
        for answer in sdo.fence():
            if isinstance(answer, BlockEndResponse):
                served = sdo.breach("an abort of the end, or no answer", Received(answer))
                served.asked = end
                raise served


@may("frame.short-abort", risk=of_length(4))
def test_short_abort(sdo: Dialogue, room: Room) -> None:
    """An abort of 4 bytes may end a transfer or be ignored; it is not served."""
    known, _ = room.long_object()
    sdo.start_segmented_upload(known)
    sdo.send(Abort(known.mux, AbortCode.GENERAL_ERROR).encode()[:4])
    sdo.line.open = known.mux  # the server may have ignored it
    sdo.expect_silence_or_abort()


@must("frame.mirror", "response.specifier", clause=CHANNEL)
def test_mirror(sdo: Dialogue) -> None:
    """What a server answers is not its request sent back."""
    for mux in (DEVICE_TYPE, IDENTITY_COUNT, VENDOR_ID.mux):
        request = UploadInitiate(mux)
        sdo.send(request)
        answer = sdo.receive()
        if answer.encode() == request.encode():
            raise sdo.breach(
                "an answer", Said(f"the request itself: {in_words(answer)}", "the request itself")
            )
        sdo.end_transfer()
