"""One request out, one response in: what counts as one, and what must not be sent."""

import pytest
from support.run_bench import (
    BASELINE,
    HASTY,
    NUMBER,
    READ,
    RULE,
    Scripted,
    discovered,
    recording,
    undiscovered,
)

from conformance.bus.channel import Channel
from conformance.bus.errors import SecondClient, WriteNotPermitted
from conformance.bus.strangers import asked_by_others
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.shape_breaches import check_shape
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import ChannelIds, CobId
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import Message, Multiplexer
from conformance.sdo.rules import ANSWERED, FRAME_SHAPE, Cause, Violation
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED

NOT_NAMED = Multiplexer(0x2003)


def test_request_and_response() -> None:
    server = recording()
    with undiscovered(server) as bench:
        sdo = bench.dialogue()
        sdo.send(UploadInitiate(Multiplexer(0x1000)))
        assert sdo.receive().encode() == BASELINE
    assert server.requests == [READ]
    assert 0 < sdo.wire.timing.latency < 10
    assert sdo.wire.timing.waited == 0


def test_bytes_go_out_as_they_are() -> None:
    node = Scripted(lambda data: [])
    with undiscovered(node, timeout=HASTY) as bench:
        sdo = bench.dialogue()
        for data in (b"", b"\x40", READ[:7], READ):
            sdo.send(data)
        assert sdo.channel.receive() is None
    assert node.requests == [b"", b"\x40", READ[:7], READ]


def test_silence_is_a_violation_and_the_wait_is_counted() -> None:
    with undiscovered(Scripted(lambda data: []), timeout=HASTY) as bench:
        sdo = bench.dialogue()
        sdo.send(READ)
        with pytest.raises(Violation) as raised:
            sdo.receive()
    assert raised.value.rule is ANSWERED
    assert raised.value.expected == "an answer to: upload initiate 1000h:00"
    assert raised.value.actual == "nothing within 50 ms"
    assert HASTY <= sdo.wire.timing.waited < 10
    assert sdo.wire.timing.latency == 0


@pytest.mark.parametrize(
    ("data", "words"), [(b"", "frame without data"), (b"\x40", "upload initiate 0000h:00")]
)
@pytest.mark.parametrize("as_frame", [False, True])
def test_a_short_frame_is_called_by_its_command_specifier_if_it_has_one(
    data: bytes, words: str, as_frame: bool
) -> None:
    with undiscovered(Scripted(lambda data: []), timeout=HASTY) as bench:
        sdo = bench.dialogue()
        if as_frame:
            sdo.send_frame(CanFrame(0x605, data))
        else:
            sdo.send(data)
        with pytest.raises(Violation) as raised:
            sdo.receive()
    assert raised.value.expected == f"an answer to: {words}"


def test_an_answer_on_a_wrong_identifier_is_silence_that_says_what_was_heard() -> None:
    node = Scripted(lambda data: [CanFrame(0x586, BASELINE), CanFrame(0x585, BASELINE, True)])
    with undiscovered(node, timeout=HASTY) as bench:
        ids = ChannelIds(CobId(0x605), CobId(0x584))
        channel = Channel(bench.channel.link, 5, HASTY, ids)
        sdo = Dialogue(channel, bench.device, CaseRecord(RULE), seed=1)
        sdo.send(READ)
        with pytest.raises(Violation) as raised:
            sdo.receive()
    heard = "received on other identifiers: 586#4300100091010F00, 00000585#4300100091010F00"
    assert raised.value.actual == f"nothing within 50 ms; {heard}"


def test_a_response_of_another_length_is_noted_and_taken_as_if_filled_up() -> None:
    """A device with that one flaw can still be tested for everything else."""
    with undiscovered(Scripted(lambda data: [CanFrame(0x585, BASELINE[:7])])) as bench:
        sdo = bench.dialogue()
        sdo.send(READ)
        assert sdo.receive().encode() == BASELINE[:7] + b"\0"
    (found,) = sdo.record.minor
    assert found.rule is FRAME_SHAPE
    assert "DLC 7" in found.actual


@pytest.mark.parametrize(
    ("answer", "wrong"),
    [
        (CanFrame(0x585, b""), "DLC 0"),
        (CanFrame(0x585, BASELINE, extended=True), "a 29-bit identifier"),
        (CanFrame(0x585, BASELINE[:4], extended=True), "a 29-bit identifier, DLC 4"),
    ],
    ids=str,
)
def test_a_response_has_the_shape_of_one(answer: CanFrame, wrong: str) -> None:
    with undiscovered(Scripted(lambda data: [answer])) as bench:
        sdo = bench.dialogue()
        sdo.send(READ)
        with pytest.raises(Violation) as raised:
            sdo.receive()
    assert raised.value.rule is FRAME_SHAPE
    assert raised.value.actual == f"{answer} ({wrong})"
    assert raised.value.expected == "a data frame of 8 bytes on 585h with an 11-bit identifier"


def test_a_remote_frame_is_no_response() -> None:
    with pytest.raises(Violation, match=r"585#R8 \(a remote frame\)"):
        check_shape(CanFrame(0x585, remote=True, length=8), CobId(0x585))


WRITES: dict[str, Message | bytes] = {
    "expedited": DownloadInitiate.with_data(NOT_NAMED, b"\1\2\3"),
    "not-counted": DownloadInitiate.with_uncounted_data(NOT_NAMED, b"\1\2\3\4"),
    "segmented": DownloadInitiate.with_size(NOT_NAMED, 3),
    "without-size": DownloadInitiate.with_size(NOT_NAMED, None),
    "reserved-bit": DownloadInitiate(NOT_NAMED, True, True, 1, b"\1\2\3\0", 1),
    "block": BlockDownloadInitiate.with_size(NOT_NAMED, 3),
    "7-bytes": DownloadInitiate.with_data(NOT_NAMED, b"\1\2\3").encode()[:7],
    "4-bytes": DownloadInitiate.with_data(NOT_NAMED, b"\1\2\3").encode()[:4],
    "other-sub-index": DownloadInitiate.with_data(Multiplexer(0x2004, 1), b"\1\2\3\4"),
    "store-parameters": DownloadInitiate.with_data(Multiplexer(0x1010, 1), b"save"),
}


@pytest.mark.parametrize("request_", WRITES.values(), ids=WRITES)
def test_nothing_is_sent_that_would_write_elsewhere(request_: Message | bytes) -> None:
    """Neither as a request nor as a frame of the case's own; the message says what to do."""
    server = recording()
    data = request_ if isinstance(request_, bytes) else request_.encode()
    with undiscovered(server, objects=[NUMBER]) as bench:
        sdo = bench.dialogue()
        with pytest.raises(
            WriteNotPermitted, match=r"is not permitted.* --sdo-object=|a permission is"
        ):
            sdo.send(request_)
        for frame in (CanFrame(0x605, data), CanFrame(0x605, data, extended=True)):
            with pytest.raises(WriteNotPermitted):
                sdo.send_frame(frame)
        assert sdo.fence() == []
    assert server.requests == [READ]
    assert sdo.record.written == set()


def test_what_others_say_is_kept_apart() -> None:
    with discovered(recording()) as bench:
        sdo = bench.dialogue()
        bench.send_from_elsewhere(
            CanFrame(0x609, READ), CanFrame(0x709, b"\x05"), CanFrame(0x605, READ, extended=True)
        )
        assert sdo.fence() == []
        assert asked_by_others(sdo.channel.overheard) == {9}
        overheard = [str(frame) for frame in sdo.channel.overheard]
        assert overheard == ["609#4000100000000000", "709#05", "00000605#4000100000000000"]
        assert asked_by_others(bench.dialogue().channel.overheard) == set()


def test_a_second_client_breaks_the_bench() -> None:
    with discovered(recording()) as bench:
        sdo = bench.dialogue()
        bench.send_from_elsewhere(CanFrame(0x605, READ))
        with pytest.raises(SecondClient, match="605h"):
            sdo.fence()


def test_drain_takes_what_is_there_and_does_not_wait() -> None:
    with discovered(recording(), timeout=10.0) as bench:
        sdo = bench.dialogue()
        late = [CanFrame(0x585, BASELINE), CanFrame(0x585, b"\x80")]
        bench.send_from_elsewhere(*late)
        assert sdo.drain() == late
        assert sdo.drain() == []
    assert sdo.wire.timing.waited == 0


def test_a_lost_device_is_described() -> None:
    with undiscovered(recording()) as bench:
        error = bench.session().loss()
    assert str(error).startswith("Node 5 answered before, but does not answer any more")
    assert "power-cycle" in str(error)


REFUSED = Abort(Multiplexer(0), AbortCode.COMMAND_NOT_VALID).encode()
ABORT = Abort(Multiplexer(0x2010), AbortCode.TIMED_OUT)
SECOND_AND_LAST = BlockSegment.with_data(2, b"1234567", last=True)  # 82h: an abort to look at


@pytest.mark.parametrize(
    ("first", "second", "sent"),
    [
        (ABORT, UploadSegment(0), [ABORT.encode(), READ, UploadSegment(0).encode()]),
        (ABORT, ABORT, [ABORT.encode()] * 2),
        (SECOND_AND_LAST, BlockEnd(0, 0), [SECOND_AND_LAST.encode(), BlockEnd(0, 0).encode()]),
    ],
    ids=["abort", "abort-again", "segment"],
)
def test_the_answer_to_an_abort_is_taken_away_before_the_next_request(
    first: Message, second: Message, sent: list[bytes]
) -> None:
    """Of a device that is known to answer aborts; a segment of a block only looks like one."""
    node = Scripted(lambda data: [BASELINE] if data == READ else [REFUSED])
    with undiscovered(node) as bench:
        sdo = bench.dialogue()
        answered = Violation(ABORT_NOT_ANSWERED, expected="no answer", actual="an answer")
        sdo.record.causes.add(
            Cause(ABORT_NOT_ANSWERED.id, "an answer"), "before", answered, aside=True
        )
        sdo.send(first)
        sdo.send(second)
        while sdo.channel.receive(HASTY) is not None:
            pass
    assert node.requests == sent


def test_segments_on_their_way_are_no_answer_to_an_abort() -> None:
    """The server has sent the whole sub-block before it sees that the client has ended it."""
    with discovered(recording()) as bench:
        sdo = bench.dialogue()
        sdo.send(BlockUploadInitiate(Multiplexer(0x1008), 2))
        sdo.receive()
        sdo.send(BlockUploadStart())
        sdo.receive()
        sdo.end_transfer()
        sdo.silence.calm()
    assert sdo.record.minor == []
