"""That a frame was not answered is proven by a fence: only the answer to the next read may come."""

from collections.abc import Callable, Iterator

import pytest
from support.run_bench import (
    BASELINE,
    HASTY,
    NODE_ID,
    READ,
    TEXT,
    Scripted,
    Workbench,
    discovered,
    recording,
    undiscovered,
)

from conformance.dialogue.blocks import Blocks
from conformance.dialogue.silence import MOST_STRAY
from conformance.faults.catalogue import build_node
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import Abort, DownloadInitiate, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import ANSWERED, UNSOLICITED, Violation

ABORT = Abort(Multiplexer(0x1018, 1), AbortCode.GENERAL_ERROR).encode()
PROBE = b"\x80" + bytes(7)
ERRORS = bytes.fromhex("4001100000000000")
NO_ERRORS = bytes.fromhex("4F01100000000000")
SEGMENT = b"\x60" + bytes(7)


def after_probe(*answers: bytes) -> Scripted:
    """Return a device that answers one frame with ``answers``, and reads of 1000h as it should."""
    return Scripted(lambda data: answers if data == PROBE else [BASELINE])


@pytest.fixture
def idle() -> Iterator[Workbench]:
    with discovered(recording()) as bench:
        yield bench


def test_nothing_came_before_the_answer_to_the_fence(idle: Workbench) -> None:
    sdo = idle.dialogue()
    sdo.send(PROBE)
    assert sdo.fence() == []
    assert sdo.reaction() is None
    assert sdo.wire.timing.waited == 0


@pytest.mark.parametrize("count", [1, 2, MOST_STRAY])
def test_what_came_before_it_is_returned(count: int) -> None:
    stray = [b"\x80\0\0\0\0\0" + number.to_bytes(2, "big") for number in range(count)]
    with undiscovered(after_probe(*stray)) as bench:
        sdo = bench.dialogue()
        sdo.send(PROBE)
        assert [response.encode() for response in sdo.fence()] == stray
    assert sdo.wire.timing.waited == 0


def test_a_babbler_is_not_listened_to_for_ever() -> None:
    with undiscovered(after_probe(*[ABORT] * (MOST_STRAY + 5))) as bench:
        sdo = bench.dialogue()
        sdo.send(PROBE)
        with pytest.raises(Violation) as raised:
            sdo.fence()
    assert raised.value.rule is UNSOLICITED


def test_a_fence_in_segments() -> None:
    """The device type may come in segments: the whole exchange is the fence."""
    node = build_node("short-uploads-in-segments", NODE_ID)
    with discovered(node) as bench:
        assert [request.hex()[:2] for request, _ in bench.device.baseline] == ["40", "60"]
        sdo = bench.dialogue()
        sdo.send(PROBE)
        assert sdo.fence() == []
        assert sdo.fence() == []


def test_a_fence_in_segments_that_goes_wrong() -> None:
    node = Scripted(lambda data: [BASELINE if data == READ else ABORT])
    with undiscovered(node) as bench:
        bench.device.baseline.append((b"\x60" + bytes(7), b"\x01" + bytes(7)))
        with pytest.raises(Violation) as raised:
            bench.dialogue().fence()
    assert raised.value.rule is UNSOLICITED
    assert "abort 1018h:01" in raised.value.actual


def test_a_request_lost_behind_another_is_repeated_once() -> None:
    """A small device may lose a frame that follows another without a pause."""
    lost = [READ]
    node = Scripted(lambda data: [] if data == PROBE or (lost and lost.pop()) else [BASELINE])
    with undiscovered(node, timeout=0.5) as bench:
        sdo = bench.dialogue()
        sdo.send(PROBE)
        assert sdo.fence() == []
    assert node.requests == [PROBE, READ, READ, ERRORS]
    assert sdo.wire.timing.waited >= 0.5


def test_both_answers_of_a_device_that_was_busy_are_taken() -> None:
    """The second would be taken for the answer to the next request."""
    late = [READ]

    def answers(data: bytes) -> list[bytes]:
        if data == READ:
            return [] if late and late.pop() else [BASELINE, BASELINE]
        return [NO_ERRORS] if data == ERRORS else [ABORT]

    with undiscovered(Scripted(answers), timeout=HASTY) as bench:
        sdo = bench.dialogue()
        assert sdo.fence() == []
        sdo.send(PROBE)
        assert sdo.receive().encode() == ABORT


def test_both_answers_in_segments() -> None:
    first, second = BASELINE.replace(b"\x43", b"\x41", 1), b"\x09\x91\x01\x0f\0\0\0\0"
    answers = iter([[], [first, first], [NO_ERRORS], [first], [second]])
    with undiscovered(Scripted(lambda data: next(answers)), timeout=HASTY) as bench:
        bench.device.baseline[:] = [(READ, first), (SEGMENT, second)]
        assert bench.dialogue().fence() == []


def test_what_comes_instead_of_the_answer_is_told_in_brief() -> None:
    """A sub-block that was on its way has up to 127 segments."""
    segments = [bytes([number, *bytes(7)]) for number in range(1, 101)]
    node = Scripted(lambda data: segments if data == READ else ())
    with (
        undiscovered(node, timeout=HASTY) as bench,
        pytest.raises(Violation, match=r"no answer; .*; \d+ more$"),
    ):
        bench.dialogue().silence.fence(most=300)


def test_a_silent_device_is_asked_twice() -> None:
    node = Scripted(lambda data: [])
    with undiscovered(node, timeout=HASTY) as bench, pytest.raises(Violation) as raised:
        bench.dialogue().fence()
    assert raised.value.rule is ANSWERED
    assert raised.value.actual == "no answer"
    assert raised.value.asked == UploadInitiate(Multiplexer(0x1000))  # nothing else was sent
    assert node.requests == [READ, READ]


def test_the_only_answer_is_the_reaction() -> None:
    with undiscovered(after_probe(ABORT)) as bench:
        sdo = bench.dialogue()
        sdo.send(PROBE)
        assert sdo.reaction() == decode_response(ABORT)


def test_two_answers_are_no_reaction() -> None:
    with undiscovered(after_probe(ABORT, ABORT)) as bench:
        sdo = bench.dialogue()
        sdo.send(PROBE)
        with pytest.raises(Violation) as raised:
            sdo.reaction()
    assert raised.value.rule is UNSOLICITED
    assert raised.value.expected == "one answer at most"


def test_the_reaction_ends_the_open_transfer_first() -> None:
    """The fence has to find the server idle; it is told so before, not after."""
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        sdo.initiate_download(TEXT, 14)
        assert sdo.line.open == TEXT.mux
        server.requests.clear()
        sdo.send(b"\x00ABCDEFG")
        assert sdo.reaction() == decode_response(b"\x20" + bytes(7))
        assert sdo.line.open is None
    abort = Abort(TEXT.mux, AbortCode.GENERAL_ERROR).encode()
    assert server.requests == [b"\x00ABCDEFG", abort, READ]
    assert server.writes == []


@pytest.mark.parametrize(
    ("start", "aborted"),
    [
        (lambda: DownloadInitiate.with_size(TEXT.mux, 14), True),
        (lambda: UploadInitiate(Multiplexer(0x1008)), True),
        (lambda: UploadInitiate(Multiplexer(0x1000)), False),
    ],
    ids=["download", "upload", "expedited"],
)
def test_only_an_open_transfer_is_ended(
    idle: Workbench, start: Callable[[], DownloadInitiate | UploadInitiate], aborted: bool
) -> None:
    sdo = idle.dialogue()
    sdo.send(start())
    sdo.receive()
    assert (sdo.line.open is not None) is aborted
    sdo.end_transfer()
    sdo.end_transfer()
    assert sdo.line.open is None
    assert sdo.fence() == []


def test_a_block_download_behind_an_ended_one_is_known(idle: Workbench) -> None:
    """Its initiate is no segment of the one before."""
    sdo = idle.dialogue()
    for _ in range(2):
        Blocks(sdo).initiate_download(TEXT, 14)
        assert sdo.line.open == TEXT.mux
        sdo.end_transfer()
