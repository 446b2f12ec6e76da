"""The beginning of a run: who is there, what it is, and what the named objects hold."""

import pytest
from support.run_bench import (
    BASELINE,
    HASTY,
    NODE_ID,
    NUMBER,
    READ,
    TEXT,
    Recording,
    Scripted,
    discovered,
    recording,
    undiscovered,
)

from conformance.beginning.baseline import record_baseline
from conformance.beginning.discovery import discover
from conformance.beginning.first_request import ask_first
from conformance.bus.errors import SilentNode
from conformance.device.effort import FIRST_TRIES
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.causes import Causes
from conformance.faults.catalogue import build_node
from conformance.faults.unusual.segmented_upload import ShortInSegments
from conformance.reference.built_in_device import REFERENCE_OBJECTS, reference_entries
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import Abort, DownloadInitiate, Request, Response, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, ObjectDictionary

FULL = KnownObject(Multiplexer(0x1008), DataType.VISIBLE_STRING, Access.CONST)  # of 4 segments
NAME, IDENTITY = Multiplexer(0x1008), Multiplexer(0x1018, 1)
ABORT = b"\x80\x00\x10\x00\x00\x00\x00\x08"


def test_what_is_known_afterwards() -> None:
    server = recording()
    with discovered(server) as bench:
        device = bench.device
    assert device.baseline == [(READ, BASELINE)]
    assert device.identity == {
        "vendor-id": "0x5D0C0000",
        "product-code": "0x5D0C0F0E",
        "revision-number": "0x00010000",
        "serial-number": "0x12345678",
    }
    assert device.values[NAME] == b"Conformance reference server"
    assert device.values[NUMBER.mux] == bytes.fromhex("11223344")
    assert device.learned.unreadable == {}
    added = {known.mux.index: known.access for known in [*device.objects][len(REFERENCE_OBJECTS) :]}
    for index in (0x1000, 0x1008, 0x1009, 0x100A, 0x1018):
        assert added.pop(index) is Access.CONST
    # What else is often there may change by itself, and is never written.
    assert added == {0x1001: Access.RO, 0x1017: Access.RO, 0x1200: Access.RO}


def test_what_the_error_list_holds_is_not_kept() -> None:
    """It comes and goes; a case that counts on it would fail once the list is cleared."""
    place = KnownObject(Multiplexer(0x1003, 1), DataType.UNSIGNED32, Access.RO)
    node = build_node("an-error-in-the-list", NODE_ID)
    with discovered(node, objects=[*REFERENCE_OBJECTS, place]) as bench:
        assert place.mux not in bench.device.values
        assert place.mux not in bench.device.learned.unreadable


def test_a_device_that_answers_aborts_is_known_as_one_that_does_not() -> None:
    """The answer to an abort is not taken for that to the next read, nor left to the cases."""
    with discovered(build_node(None, NODE_ID)) as bench:
        right = bench.device
    with discovered(build_node("every-abort-answered", NODE_ID)) as bench:
        assert bench.channel.receive(HASTY) is None
        assert bench.device.values == right.values
        assert bench.device.learned.unreadable == right.learned.unreadable
        assert bench.device.learned.nowhere == right.learned.nowhere


class NoSecondTransfer(ShortInSegments):
    """Sends everything in segments, and counts the initiates in the middle of a transfer."""

    superseded = 0

    def react(self, request: Request) -> list[Response]:
        self.superseded += self.transfer is not None and isinstance(request, UploadInitiate)
        return super().react(request)


def test_each_read_is_ended_before_the_next_begins() -> None:
    """A server may refuse an initiate in the middle of a transfer."""
    server = NoSecondTransfer(ObjectDictionary(reference_entries(NODE_ID)))
    with undiscovered(server) as bench:
        ask_first(bench.channel)
        discover(bench.channel, bench.device)
    assert server.superseded == 0


def test_nothing_is_written() -> None:
    server = recording()
    with discovered(server):
        pass
    assert server.writes == []
    assert not any(isinstance(decode_request(data), DownloadInitiate) for data in server.requests)


def test_a_write_only_object_is_not_read() -> None:
    server = recording()
    with discovered(server) as bench:
        assert Multiplexer(0x2020) not in bench.device.values
    assert not any(data[1:4] == b"\x20\x20\x00" for data in server.requests)


def test_a_transfer_that_an_earlier_client_left_is_ended_first() -> None:
    server = recording()
    server.receive(DownloadInitiate.with_size(TEXT.mux, 14).encode())
    assert server.transfer is not None
    server.requests.clear()
    with discovered(server):
        pass
    assert server.requests[:2] == [ABORT, READ]
    assert server.writes == []


def test_a_minimal_device() -> None:
    """Only the device type is mandatory for the suite to begin; the node adds what is its own."""
    entries = {Multiplexer(0x1000): reference_entries(NODE_ID)[Multiplexer(0x1000)]}
    with discovered(recording(entries=entries), objects=[]) as bench:
        assert bench.device.identity == {}
        found = {mux.index for mux in bench.device.values}
        assert found == {0x1000, 0x1001, 0x1017, 0x1200}
        assert "06020000h" in bench.device.learned.unreadable[IDENTITY]


def test_a_named_object_that_does_not_exist_is_never_written() -> None:
    """It has no value that could be put back; the cases that need it say so."""
    known = KnownObject(Multiplexer(0x2222), DataType.UNSIGNED64)
    with discovered(recording(), objects=[*REFERENCE_OBJECTS[:4], known]) as bench:
        assert "06020000h" in bench.device.learned.unreadable[known.mux]
        assert Roles(bench.device).number() == NUMBER


def test_an_object_of_the_users_own_is_taken_as_the_user_says() -> None:
    name = KnownObject(NAME, DataType.OCTET_STRING, Access.RO)
    with discovered(recording(), objects=[name]) as bench:
        assert [known for known in bench.device.objects if known.mux == NAME] == [name]


@pytest.mark.parametrize(
    ("name", "refusal"),
    [
        (None, False),
        ("no-block-transfer", Abort(Multiplexer(0x1000), AbortCode.COMMAND_NOT_VALID)),
    ],
)
def test_block_uploads_are_asked_for(name: str | None, refusal: Abort | bool) -> None:
    """By an initiate that is aborted at once: the server is idle afterwards."""
    node = build_node(name, NODE_ID)
    with discovered(node) as bench:
        assert bench.device.learned.block_upload_refusal == refusal
        assert bench.dialogue().fence() == []
        assert node.server.transfer is None


def test_silence_to_a_block_upload_is_for_the_cases_to_judge() -> None:
    def answer(data: bytes) -> list[bytes]:
        return [BASELINE] if data == READ else []

    with discovered(Scripted(answer), timeout=HASTY, objects=[]) as bench:
        assert bench.device.learned.block_upload_refusal is None


class _Garbling(Recording):
    """Answers uploads of the identity with a download confirmation."""

    def receive(self, frame: bytes) -> list[bytes]:
        answers = super().receive(frame)
        if frame[:3] == b"\x40\x18\x10":
            return [b"\x60" + frame[1:], *answers]
        return answers


def test_a_device_that_answers_badly_is_tested_all_the_same() -> None:
    """What is wrong with it is for the cases to say; what is left over spoils nothing."""
    with discovered(recording(_Garbling)) as bench:
        assert "response.specifier" in bench.device.learned.unreadable[IDENTITY]
        assert bench.device.values[NUMBER.mux] == bytes.fromhex("11223344")
        assert bench.device.values[TEXT.mux] == b"text"


def test_the_device_type_in_segments() -> None:
    with discovered(build_node("short-uploads-in-segments", NODE_ID)) as bench:
        requests = [request for request, _ in bench.device.baseline]
        assert requests == [READ, b"\x60" + bytes(7)]
        assert bench.device.values[Multiplexer(0x1000)] == bytes.fromhex("91010F00")


def test_an_endless_device_type_ends() -> None:
    """What reads as one segment after another serves as a fence up to a point."""

    def answer(data: bytes) -> list[bytes]:
        begun = b"\x40\x00\x10\x00" + bytes(4)
        return [begun if data == READ else bytes([data[0] & 0x10]) + bytes(7)]

    with undiscovered(Scripted(answer)) as bench:
        record_baseline(bench.channel, bench.device)
        assert len(bench.device.baseline) == 8


@pytest.mark.parametrize("answered", [1, FIRST_TRIES])
def test_a_device_that_answers_in_the_end(answered: int) -> None:
    """It may have been busy, or another transfer may have been open."""
    attempts: list[bytes] = []

    def answer(data: bytes) -> list[bytes]:
        if data == READ:
            attempts.append(data)
        return [BASELINE] if data == READ and len(attempts) >= answered else []

    with undiscovered(Scripted(answer), timeout=0.5) as bench:
        record_baseline(bench.channel, bench.device)
        assert bench.device.baseline == [(READ, BASELINE)]
    assert len(attempts) == answered


def silence(*heard: CanFrame) -> str:
    """Return the message about a silent node on a bus where other frames are on their way."""
    node = Scripted(lambda data: [])
    with undiscovered(node, timeout=HASTY) as bench:
        bench.send_from_elsewhere(*heard)
        with pytest.raises(SilentNode) as raised:
            discover(bench.channel, bench.device)
    assert node.requests == [ABORT, READ, READ, ABORT, READ], "once without an abort"
    return str(raised.value)


def test_a_silent_node() -> None:
    lines = silence().splitlines()
    assert lines[:3] == [
        "Node 5 does not answer.",
        "  sent: 3 times a read of 1000h on 605h (605#4000100000000000), waiting 50 ms for 585h "
        "each time",
        "  heard: 0 other frames",
    ]
    for word in ("power", "bit rate", "termination", "node-ID", "NMT state"):
        assert word in lines[3]


def test_a_silent_node_on_a_bus_with_others() -> None:
    text = silence(
        CanFrame(0x709, b"\x05"),
        CanFrame(0x70A, b"\x00"),
        CanFrame(0x185, b"\x01\x02"),
        CanFrame(0x00000711, b"\x05", extended=True),
        CanFrame(0x100, b""),
        CanFrame(0x101, b""),
    )
    lines = text.splitlines()
    assert lines[2] == (
        "  heard: 6 other frames; nodes with heartbeat or boot-up: 9, 10; booted just now: 10"
    )
    # The last five, as one would see them in a log.
    assert lines[3:8] == [
        f"    {frame}" for frame in ("70A#00", "185#0102", "00000711#05", "100#", "101#")
    ]
    assert lines[8] == "  check: is the node-ID 5 right, is that node in NMT state Stopped?"


def test_a_device_that_answers_an_abort_is_known_all_the_same() -> None:
    """The abort with which a run begins must not be taken for the read behind it."""
    with discovered(build_node("abort-answered-when-idle", NODE_ID)) as bench:
        assert bench.device.baseline == [(READ, BASELINE)]
        assert bench.device.values[NUMBER.mux] == bytes.fromhex("11223344")
        assert bench.device.learned.unreadable == {}


def test_an_upload_that_cannot_be_ended_is_told_beside_the_cases() -> None:
    """No case may ever read such an object."""
    causes = Causes()
    with undiscovered(build_node("upload-last-flag-missing-when-full", NODE_ID)) as bench:
        bench.device.known[FULL.mux] = FULL
        discover(bench.channel, bench.device, causes)
        assert FULL.mux in bench.device.learned.unreadable
    assert "response.not-refused: abort 05040001h to upload segment request" in [
        str(cause) for cause, _ in causes.aside()
    ]


def test_what_is_wrong_with_each_long_value_is_told_beside_the_cases() -> None:
    """None that may be written can be read then, so no case would come to it."""
    causes = Causes()
    with undiscovered(build_node("strings-padded+upload-size-8-bit", NODE_ID)) as bench:
        discover(bench.channel, bench.device, causes)
        with pytest.raises(NotTestable, match=r"would do, but could not be read: upload\.size"):
            Roles(bench.device).text()
    assert "upload.size" in [cause.rule_id for cause, _ in causes.aside()]
