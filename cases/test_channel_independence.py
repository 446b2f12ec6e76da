"""Several SDO channels at once: each has a transfer of its own, and none knows of the others."""

from collections.abc import Callable, Generator

from conformance.device.device import DEVICE_TYPE, IDENTITY_COUNT, Device
from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.device.suggestions import lacking
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.channels import Channels, interleave
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.values import same_value
from conformance.model_cases.conversations.conversation import Kind
from conformance.model_cases.conversations.search import ConversationSearch
from conformance.model_cases.elsewhere import CONVERSATIONS, LONG, expect_carried
from conformance.model_cases.matrix.field import perform_stimulus
from conformance.model_cases.matrix.sample import Field, risk_of, sample
from conformance.run.case import may, must
from conformance.run.risks import LOST_SEGMENT
from conformance.sdo.block_client import Step
from conformance.sdo.client import Uploaded
from conformance.sdo.describe import in_words, shown
from conformance.sdo.frames import (
    Abort,
    DownloadSegment,
    Response,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.rules.idle import BUSY
from conformance.sdo.rules.segmented_upload import TOGGLE
from conformance.sdo.seen import Data, Received

INDEPENDENT = "7.2.4.2"
SIZE = 19
KINDS = ("upload", "download", "block-upload", "block-download")
PAIRS = {f"{one}-and-{other}": (one, other) for one in KINDS for other in KINDS}
Transfer = Generator[Step, Response, object]


def long_read_only(device: Device, but: KnownObject | None = None) -> tuple[KnownObject, bytes]:
    """Return a read-only object whose upload takes two segments or more, and its value.

    It is another one than ``but``.
    """
    for known in device.objects:
        value = device.values.get(known.mux, b"")
        if not known.access.writable and len(value) > 7 and known != but:
            return known, value
    raise lacking(
        device,
        "another read-only object longer than 7 bytes",
        "2021=visible_string,ro",
        lambda known: not known.access.writable and len(device.values.get(known.mux, b"")) > 7,
    )


def value_for(sdo: Dialogue, room: Room, known: KnownObject) -> bytes:
    """Return another value than the present one."""
    if known.varies:
        return sdo.payload(room.fit(known, SIZE))
    before = sdo.device.values[known.mux]
    return bytes([before[0] ^ 1]) + before[1:]


def put(sdo: Dialogue, room: Room, known: KnownObject, value: bytes) -> None:
    """Write a value; raises NotTestable for a string or domain that has no room for it."""
    if known.varies:
        room.store(known, value)
    else:
        sdo.download(known, value)


def transfer(sdo: Dialogue, kind: str, known: KnownObject, data: bytes) -> Transfer:
    """Return a transfer of a kind: of the object, or of these data to it."""
    client = sdo.client
    transfers: dict[str, Callable[[], Transfer]] = {
        "upload": lambda: client.upload(known.mux),
        "download": lambda: client.download(known.mux, data, segmented=True),
        "block-upload": lambda: client.block_upload(known.mux, block_size=2),
        "block-download": lambda: client.block_download(known.mux, data),
    }
    return transfers[kind]()


def require_blocks(sdo: Dialogue, kinds: tuple[str, ...]) -> None:
    """Raise Unimplemented where the server has no block transfers of these kinds."""
    blocks = Blocks(sdo)
    if "block-download" in kinds:
        blocks.require_download()
    if "block-upload" in kinds:
        blocks.initiate_upload(Roles(sdo.device).writable(), block_size=2)
        sdo.end_transfer()


def size_of(sdo: Dialogue, known: KnownObject) -> int:
    """Return how many bytes to write to an object."""
    return Room(sdo).fit(known, SIZE) if known.varies else len(sdo.device.values[known.mux])


def start(sdo: Dialogue, kind: str, known: KnownObject) -> None:
    """Begin a transfer of an object and leave it unfinished."""
    if kind == "upload":
        sdo.start_segmented_upload(known)
        sdo.upload_segment(toggle=0)
    elif kind == "download":
        size = size_of(sdo, known)
        sdo.initiate_download(known, size)
        if size > 7:
            sdo.download_segment(sdo.payload(7), toggle=0)
    elif kind == "block-upload":
        blocks = Blocks(sdo)
        blocks.initiate_upload(known, block_size=2)
        blocks.start_upload(known, 2)
    else:
        size = size_of(sdo, known)
        blocks = Blocks(sdo)
        response = blocks.initiate_download(known, size)
        if response.block_size > 1 and size > 7:  # else a segment would be acknowledged
            blocks.send_segments([sdo.payload(7)])


@must("independence.interleaved", "channel.independent", pair=PAIRS)
def test_interleaved(
    sdo: Dialogue,
    room: Room,
    channels: Channels,
    device: Device,
    pair: tuple[str, str],
) -> None:
    """Two transfers of any kinds run at the same time on two channels, step by step."""
    require_blocks(sdo, pair)
    objects = Roles(device).two_writable()
    with channels.side_by_side() as other:
        data = [value_for(sdo, room, known) for known in objects]
        for kind, known, value in zip(pair, objects, data, strict=True):
            if kind.endswith("upload") or known.varies:
                put(sdo, room, known, value if kind.endswith("upload") else value[::-1])
        results = interleave(
            (sdo, transfer(sdo, pair[0], objects[0], data[0])),
            (other, transfer(other, pair[1], objects[1], data[1])),
        )
        for result, known, value in zip(results, objects, data, strict=True):
            if isinstance(result, Abort):
                raise sdo.breach("both transfers served", Received(result))
            if isinstance(result, Uploaded) and not same_value(known, result.data, value):
                raise sdo.breach(f"{known} reads {shown(value)}", Data(result.data))
            sdo.expect_value(known, value)


@must("independence.three", "channel.independent")
def test_three(sdo: Dialogue, room: Room, channels: Channels, device: Device, roles: Roles) -> None:
    """Three channels upload at the same time, each its own object."""
    written = Roles(device).two_writable()
    objects = (*written, KnownObject(roles.shortest_readable()))
    with channels.side_by_side() as second, channels.side_by_side(1) as third:
        for known in written:
            put(sdo, room, known, value_for(sdo, room, known))
        due = [sdo.upload(known) for known in objects]
        results = interleave(
            *(
                (channel, channel.client.upload(known.mux))
                for channel, known in zip((sdo, second, third), objects, strict=True)
            )
        )
        for result, known, value in zip(results, objects, due, strict=True):
            if isinstance(result, Abort):
                raise sdo.breach("all transfers served", Received(result))
            if isinstance(result, Uploaded) and not same_value(known, result.data, value):
                raise sdo.breach(f"{known} reads {shown(value)}", Data(result.data))


@must("independence.abort", "channel.independent", kind=KINDS)
def test_abort(
    sdo: Dialogue,
    room: Room,
    channels: Channels,
    device: Device,
    text: KnownObject,
    kind: str,
) -> None:
    """An abort on one channel ends the transfer there and not the one on another channel."""
    require_blocks(sdo, (kind,))
    known, due = long_read_only(device)
    room.prepare(text, SIZE, least=8)
    with channels.side_by_side() as other:
        for one, another in ((sdo, other), (other, sdo)):
            start(one, kind, text)
            response = another.start_segmented_upload(known)
            one.end_transfer()
            found = another.finish_upload(known, response)
            if found != due:
                raise sdo.breach(f"the upload goes on: {shown(due)}", Data(found))


@must("independence.refusal", "channel.independent")
def test_refusal(
    sdo: Dialogue, room: Room, channels: Channels, device: Device, text: KnownObject
) -> None:
    """A transfer that the server aborts on one channel does not end the one on another channel."""
    known, _ = long_read_only(device)
    data = sdo.payload(room.fit(text, 14, least=8))
    sdo.start_segmented_upload(known)
    sdo.send(UploadSegment(1))
    sdo.expect_abort(*TOGGLE.codes, of=known, rule=TOGGLE)
    with channels.side_by_side() as other:
        for one, another in ((sdo, other), (other, sdo)):
            another.initiate_download(text, len(data))
            another.download_segment(data[:7], toggle=0)
            one.start_segmented_upload(known)
            one.send(UploadSegment(1))
            one.expect_abort(*TOGGLE.codes, of=known)
            another.download_segments(data, first=1)
            sdo.expect_value(text, data)


@must("independence.toggle", "channel.independent")
def test_toggle(sdo: Dialogue, room: Room, channels: Channels, device: Device) -> None:
    """Each channel has a toggle bit of its own: one is a segment ahead of the other."""
    ahead, _ = room.long_object()
    known, data = long_read_only(device, but=ahead)
    with channels.side_by_side() as other:
        sdo.start_segmented_upload(ahead)
        sdo.upload_segment(toggle=0)
        other.start_segmented_upload(known)
        sdo.upload_segment(toggle=1)
        first = other.upload_segment(toggle=0).data
        sdo.upload_segment(toggle=0)
        second = other.upload_segment(toggle=1).data
        if not data.startswith(first + second):
            raise sdo.breach(shown(data[:14]), Data(first + second))


@must("independence.client-vanished", "channel.independent", kind=KINDS)
def test_client_vanished(
    sdo: Dialogue, room: Room, channels: Channels, device: Device, kind: str
) -> None:
    """A client that falls silent in mid-transfer blocks its own channel and no other."""
    require_blocks(sdo, (kind,))
    busy, free = Roles(device).two_writable()
    if kind == "upload":
        busy, _ = room.long_object()
        free = next(known for known in Roles(device).two_writable() if known.mux != busy.mux)
    values = [value_for(sdo, room, free) for _ in range(2)]
    with channels.side_by_side() as other:
        for one, another, value in ((other, sdo, values[0]), (sdo, other, values[1])):
            start(one, kind, busy)
            another.download(free, value, segmented=True)
            another.expect_value(free, value)
            another.fence()
            one.end_transfer()


@may(
    "independence.same-object",
    "object.busy",
    "channel.independent",
    clause=INDEPENDENT,
    kind=["upload", "download"],
)
def test_same_object(
    sdo: Dialogue, room: Room, channels: Channels, text: KnownObject, kind: str
) -> None:
    """Two clients use one object at once: both are served, or one is refused as busy.

    Whatever happens, the data of the one do not turn up in those of the other.
    """
    before = room.prepare(text, SIZE)
    first, second = (sdo.payload(len(before)) for _ in range(2))
    with channels.side_by_side() as other:
        results = interleave(
            (sdo, transfer(sdo, "download", text, first)),
            (other, transfer(other, kind, text, second)),
        )
        aborts = [result for result in results if isinstance(result, Abort)]
        for abort in aborts:
            if abort.code not in BUSY.codes or len(aborts) > 1:
                raise sdo.breach("both served, or one refused as busy", Received(abort))
        allowed = [before, first, second]
        uploads = [result.data for result in results if isinstance(result, Uploaded)]
        for found in (sdo.upload(text), *uploads):
            if not any(same_value(text, found, value) for value in allowed):
                raise sdo.breach("one of the values, whole", Data(found))
        if aborts:
            sdo.info(f"busy object: {in_words(aborts[0])}")


@must("independence.next-request", "channel.independent")
def test_next_request(sdo: Dialogue, channels: Channels) -> None:
    """Requests on two channels right behind one another are both answered, each on its own."""
    with channels.side_by_side() as other:
        for one, another in ((sdo, other), (other, sdo)):
            one.send(UploadInitiate(DEVICE_TYPE))
            another.send(UploadInitiate(IDENTITY_COUNT))
            another.checks.upload_initiate(another.receive(), IDENTITY_COUNT)
            one.checks.upload_initiate(one.receive(), DEVICE_TYPE)
            one.end_transfer()
            another.end_transfer()


@must("independence.segment-elsewhere", "channel.independent", kind=["upload", "download"])
def test_segment_elsewhere(
    sdo: Dialogue, room: Room, channels: Channels, text: KnownObject, kind: str
) -> None:
    """A segment on a channel without a transfer does not go on with the one of another channel."""
    room.prepare(text, SIZE, least=8)
    with channels.side_by_side() as other:
        for one, another in ((sdo, other), (other, sdo)):
            start(one, kind, text)
            download = DownloadSegment.with_data(sdo.payload(7), toggle=1)
            another.expect_dead(UploadSegment(1) if kind == "upload" else download)
            one.end_transfer()


# Transfers on a further channel, right and wrong ones


@must(
    "independence.frame",
    "response.specifier",
    "response.answered",
    "server.idle-afterwards",
    risk=risk_of,
    field=sample(turn=1),
)
def test_frame(text: KnownObject, channels: Channels, field: Field) -> None:
    """On a further channel, a frame in a state of the server gets an answer allowed there."""
    with channels.further() as other:
        perform_stimulus(field.state, field.stimulus, other, text)


@must("independence.long", "upload.size", "block-upload.next-sub-block", protocol=LONG)
def test_long(
    sdo: Dialogue, room: Room, variable: KnownObject, channels: Channels, protocol: int
) -> None:
    """On a further channel, a long value is written and read, in segments and in blocks."""
    data = sdo.payload(room.fit(variable, protocol, least=8))
    with channels.further() as other:
        expect_carried(other, variable, data, in_blocks=protocol == LONG["block"])


@must(
    "independence.conversation",
    "upload.size",
    "server.idle-afterwards",
    "server.value-kept",
    risk=LOST_SEGMENT,
    kind=CONVERSATIONS,
)
def test_conversation(conversations: ConversationSearch, channels: Channels, kind: Kind) -> None:
    """On a further channel, random transfers carry their values, disturbed or not."""
    with channels.further() as other:
        conversations.run(kind, other)
