"""NMT states: where an SDO server answers and where it does not (CiA 301, 7.3.2)."""

from conformance.device.device import VENDOR_ID
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import Unimplemented
from conformance.device.serving import Service
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.network import Network
from conformance.run.case import may, must
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import (
    DownloadInitiate,
    DownloadSegment,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.nmt import TRANSITIONS, NmtCommand
from conformance.sdo.rules.channels import NMT_INTERRUPTED
from conformance.sdo.rules.idle import UNKNOWN_SPECIFIER as UNKNOWN
from conformance.sdo.seen import Received, said

UNKNOWN_SPECIFIER = bytes((0xE0, *bytes(7)))
RESETS = {"node": NmtCommand.RESET_NODE, "communication": NmtCommand.RESET_COMMUNICATION}
SERVING = {
    "operational": NmtCommand.START,
    "pre-operational": NmtCommand.ENTER_PRE_OPERATIONAL,
}


# How a device says that it has no 1017h, or one that cannot be written.
NO_HEARTBEAT_TIME = (
    AbortCode.OBJECT_MISSING,
    AbortCode.WRITE_OF_READ_ONLY,
    AbortCode.UNSUPPORTED_ACCESS,
    AbortCode.VALUE_INVALID,
    AbortCode.VALUE_TOO_LOW,
    AbortCode.GENERAL_ERROR,
)


def start_transfer(sdo: Dialogue, room: Room, kind: str, text: KnownObject) -> None:
    """Begin a transfer of three segments, or of two, and leave it unfinished."""
    if kind == "download":
        sdo.initiate_download(text, room.fit(text, 17, least=8))
        sdo.download_segment(sdo.payload(7), toggle=0)
    else:
        room.prepare(text, 17, least=8)
        sdo.start_segmented_upload(text)
        sdo.upload_segment(toggle=0)


def next_segment(sdo: Dialogue, kind: str) -> UploadSegment | DownloadSegment:
    """Return the segment with which the transfer would go on."""
    if kind == "download":
        return DownloadSegment.with_data(sdo.payload(7), toggle=1)
    return UploadSegment(1)


@must("nmt.serves", "nmt.pre-operational", "nmt.operational", command=SERVING)
def test_serves(
    sdo: Dialogue, room: Room, network: Network, text: KnownObject, command: NmtCommand
) -> None:
    """In Pre-operational and in Operational the server reads and writes as before."""
    network.enter(TRANSITIONS[command])
    refused = sdo.device.learned.serving.refusal(Service.DOWNLOAD, text.mux)
    if refused is None:
        sdo.expect_value(text, room.prepare(text, 17))
    else:
        sdo.info(str(refused))
        sdo.upload(text)
    sdo.fence()


@must("nmt.stopped-silent", "nmt.stopped", command=SERVING)
def test_stopped_silent(sdo: Dialogue, network: Network, command: NmtCommand) -> None:
    """In Stopped a request is not answered, not even by an abort, and not later either."""
    network.produce_heartbeats()
    network.send(NmtCommand.STOP)
    network.settle()
    sdo.send(UploadInitiate(VENDOR_ID.mux))
    network.linger()
    network.send(command)
    network.settle()
    sdo.expect_nothing()


@must("nmt.stopped-writes-nothing", "nmt.stopped")
def test_stopped_writes_nothing(sdo: Dialogue, network: Network, number: KnownObject) -> None:
    """A download that was sent in Stopped is not carried out, then or later."""
    network.produce_heartbeats()
    with sdo.unchanged(number) as before:
        changed = bytes([before[0] ^ 1]) + before[1:]
        network.send(NmtCommand.STOP)
        network.settle()
        sdo.send(DownloadInitiate.with_data(number.mux, changed[:4]))
        network.linger()
        network.send(NmtCommand.ENTER_PRE_OPERATIONAL)
        network.settle()
        sdo.expect_nothing()


@must("nmt.stopped-in-transfer", "nmt.interrupted", "nmt.stopped", kind=["upload", "download"])
def test_stopped_in_transfer(
    sdo: Dialogue, room: Room, network: Network, text: KnownObject, kind: str
) -> None:
    """A stop in mid-transfer is met with silence or one abort; the next transfer is served.

    Its next segment is not answered in Stopped.
    """
    data = sdo.payload(room.fit(text, 9))
    network.produce_heartbeats()
    start_transfer(sdo, room, kind, text)
    network.send(NmtCommand.STOP)
    network.settle()
    farewell = sdo.drain()
    for frame in farewell:
        response = decode_response(frame.data)
        if len(farewell) > 1:
            raise sdo.breach("silence, or one abort", Received(response))
        sdo.take_abort(response, NMT_INTERRUPTED.codes, None, NMT_INTERRUPTED.tolerated)
    sdo.send(next_segment(sdo, kind))
    network.linger()
    network.send(NmtCommand.ENTER_PRE_OPERATIONAL)
    network.settle()
    sdo.line.open = None
    sdo.expect_nothing()
    room.store(text, data, segmented=True)
    sdo.expect_value(text, data)


@must("nmt.reset-boots", "nmt.initialising", clause="7.3.2.2.1", command=RESETS)
def test_reset_boots(sdo: Dialogue, network: Network, command: NmtCommand) -> None:
    """A reset leads to a boot-up message, and from then on the server serves."""
    network.reset(command)
    sdo.fence()
    network.reset(command)
    sdo.fence()


@must("nmt.reset-from-stopped", "nmt.pre-operational", clause="7.3.2.2.1", command=RESETS)
def test_reset_from_stopped(sdo: Dialogue, network: Network, command: NmtCommand) -> None:
    """A reset in Stopped leads to Pre-operational, where the server serves."""
    network.send(NmtCommand.STOP)
    network.reset(command)
    sdo.fence()


@must(
    "nmt.first-request",
    "nmt.initialising",
    "response.not-refused",
    "specifier.unknown",
    kind=["download", "unknown-specifier"],
)
def test_first_request(sdo: Dialogue, network: Network, number: KnownObject, kind: str) -> None:
    """The first request after a boot-up message is served, whatever it is."""
    value = sdo.upload(number)
    network.reset(NmtCommand.RESET_COMMUNICATION)
    if kind == "download":
        sdo.download(number, value)
        return
    sdo.send(UNKNOWN_SPECIFIER)
    sdo.expect_abort(*UNKNOWN.codes, of=None)


@must("nmt.reset-ends-transfer", "nmt.interrupted", clause="7.3.2.2.1", kind=["upload", "download"])
def test_reset_ends_transfer(
    sdo: Dialogue, room: Room, network: Network, text: KnownObject, kind: str
) -> None:
    """A transfer that a reset interrupted is forgotten: its next segment is not served."""
    data = sdo.payload(room.fit(text, 12))
    start_transfer(sdo, room, kind, text)
    network.reset(NmtCommand.RESET_COMMUNICATION)
    sdo.drain()  # an abort on the way down is allowed
    sdo.line.open = None
    sdo.expect_dead(next_segment(sdo, kind))
    room.store(text, data, segmented=True)
    sdo.expect_value(text, data)


@must("nmt.reset-keeps-objects", "object.constant", clause="7.3.2.2.1")
def test_reset_keeps_objects(sdo: Dialogue, network: Network) -> None:
    """After a reset of the communication constants read as before."""
    due = {mux: sdo.upload(mux) for mux in sdo.device.briefly_read() if sdo.device.is_constant(mux)}
    network.reset(NmtCommand.RESET_COMMUNICATION)
    for mux, value in due.items():
        if (found := sdo.upload(mux)) != value:
            raise sdo.breach(f"{mux} reads {value.hex(' ')}", said("{}", found.hex(" ")))


@may("nmt.heartbeat", "nmt.pre-operational", "nmt.operational", clause="7.2.8.2.2", command=SERVING)
def test_heartbeat(sdo: Dialogue, network: Network, command: NmtCommand) -> None:
    """With a time in 1017h the device tells its state, and SDO goes on; with 0 it tells nothing."""
    refusal = network.produce_heartbeats()
    if refusal is not None:
        if refusal.code not in NO_HEARTBEAT_TIME:
            raise sdo.breach("1017h to be served, or refused", Received(refusal))
        raise Unimplemented(Received(refusal))
    network.enter(TRANSITIONS[command])
    sdo.fence()
    network.end_heartbeats()
    sdo.fence()
