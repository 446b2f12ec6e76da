"""What a pause of the bench brought about is a note of the case, never a failure."""

import time
from collections.abc import Callable
from dataclasses import replace

import pytest
from support.run_bench import (
    BASELINE,
    HASTY,
    READ,
    TEXT,
    Scripted,
    discovered,
    recording,
    undiscovered,
)

from conformance.bus.channel import Channel
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.pauses import Pauses
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import ANSWERED, Violation

GAVE_UP = Abort(Multiplexer(0x2005), AbortCode.TIMED_OUT).encode()
REFUSED = Abort(Multiplexer(0x2005), AbortCode.GENERAL_ERROR).encode()


def silent(pauses: Pauses, seconds: float, *, within: bool = True) -> None:
    """Let the bench send a frame, nothing for ``seconds``, and another one."""
    pauses.sent(within=within)
    assert pauses.active_at is not None
    pauses.active_at -= seconds
    pauses.sent(within=within)


@pytest.mark.parametrize(
    ("declared", "seconds", "response", "excused"),
    [
        (1.0, 0.9, REFUSED, True),  # it may be anything that a server says that has given up
        (1.0, 0.6, GAVE_UP, False),  # the case slow-client waits for half the time
        (1.0, 0.9, GAVE_UP, True),
        (None, 0.1, GAVE_UP, True),
        (None, 0.1, REFUSED, False),
        (None, 0.001, GAVE_UP, False),
    ],
)
def test_what_a_silence_of_the_bench_excuses(
    declared: float | None, seconds: float, response: bytes, excused: bool
) -> None:
    pauses = Pauses(declared)
    silent(pauses, seconds)
    pauses.received(response, time.monotonic(), within=True)
    assert pauses.excuse is excused
    assert len(pauses.notes) == excused
    pauses.forget()
    assert not pauses.excuse


@pytest.mark.parametrize("within", [True, False])
def test_a_response_that_waited_for_the_bench(within: bool) -> None:
    pauses = Pauses(1.0)
    pauses.received(BASELINE, time.monotonic() - 0.9, within=within)
    assert pauses.excuse is within


def test_between_transfers_no_time_out_runs() -> None:
    pauses = Pauses(1.0)
    silent(pauses, 5.0, within=False)
    assert not pauses.excuse


def test_a_silence_that_the_server_was_to_end_is_no_pause() -> None:
    pauses = Pauses(1.0)
    pauses.sent(within=True)
    assert pauses.active_at is not None
    pauses.active_at -= 5.0
    pauses.waited()
    pauses.sent(within=True)
    assert not pauses.excuse


def in_doubt(monkeypatch: pytest.MonkeyPatch, waits: int) -> None:
    """Let the first waits of any channel end in doubt, and no others, however busy the machine."""
    left = [waits]
    receive = Channel.receive

    def doubtful(self: Channel, timeout: float | None = None) -> CanFrame | None:
        frame = receive(self, timeout)
        if frame is None:
            self.waited_again = self.in_doubt = left[0] > 0
            self.missed = 0.5 if left[0] else 0.0
            left[0] = max(left[0] - 1, 0)
        return frame

    monkeypatch.setattr(Channel, "receive", doubtful)


def answering(from_the: int) -> Callable[[bytes], list[bytes]]:
    """Return what a node does that answers only from the nth request on."""
    seen: list[bytes] = []

    def answers(data: bytes) -> list[bytes]:
        seen.append(data)
        return [BASELINE] if len(seen) >= from_the else []

    return answers


def test_a_read_is_repeated_once_when_its_answer_may_have_been_missed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    in_doubt(monkeypatch, 1)
    node = Scripted(answering(2))
    with undiscovered(node, timeout=HASTY) as bench:
        sdo = bench.dialogue()
        sdo.send(READ)
        assert sdo.receive().encode() == BASELINE
    assert node.requests == [READ, READ]
    assert "the read was repeated" in sdo.wire.pauses.notes[-1]


def test_nothing_else_is_repeated(monkeypatch: pytest.MonkeyPatch) -> None:
    in_doubt(monkeypatch, 9)
    node = Scripted(lambda data: [])
    with undiscovered(node, timeout=HASTY) as bench:
        sdo = bench.dialogue()
        sdo.send(DownloadInitiate.with_size(TEXT.mux, 5))
        with pytest.raises(Violation):
            sdo.receive()
        assert sdo.wire.pauses.excuse
    assert len(node.requests) == 1


def test_a_silence_that_is_certain_is_the_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    in_doubt(monkeypatch, 0)
    with undiscovered(Scripted(lambda data: []), timeout=HASTY) as bench:
        sdo = bench.dialogue()
        sdo.send(READ)
        with pytest.raises(Violation) as raised:
            sdo.receive()
        assert raised.value.rule is ANSWERED
        assert not sdo.wire.pauses.excuse


def test_a_transfer_that_was_given_up_does_not_disturb_a_fence() -> None:
    with discovered(recording()) as bench:
        sdo: Dialogue = bench.dialogue()
        silent(sdo.wire.pauses, 0.5)
        bench.send_from_elsewhere(CanFrame(0x585, GAVE_UP))
        assert sdo.fence() == []
        sdo.wire.pauses.forget()
        bench.send_from_elsewhere(CanFrame(0x585, GAVE_UP))
        assert sdo.fence() == [decode_response(GAVE_UP)]


@pytest.mark.parametrize("channels", [1, 2])
def test_the_wait_for_an_answer_that_does_not_come_is_no_pause_of_the_bench(channels: int) -> None:
    begun = UploadInitiateResponse.with_size(TEXT.mux, 20).encode()
    node = Scripted(lambda data: [begun] if data[0] == READ[0] else [])
    with undiscovered(node, timeout=4 * HASTY) as bench:
        bench.device = replace(bench.device, server_timeout=HASTY)
        sdo = bench.dialogue()
        waiting = sdo if channels == 1 else sdo.beside(bench.channel)
        for each in {id(one): one for one in (sdo, waiting)}.values():
            each.send(UploadInitiate(TEXT.mux))
            each.receive()
        waiting.send(UploadSegment(0))
        with pytest.raises(Violation, match="nothing within"):
            waiting.receive()
        # Meanwhile the device may have given up both transfers: the silence was its own.
        for each in (sdo, waiting):
            each.end_transfer()
            assert not each.wire.pauses.excuse


def test_a_look_at_what_need_not_come_is_a_silence_of_the_client() -> None:
    begun = UploadInitiateResponse.with_size(TEXT.mux, 20).encode()
    with undiscovered(Scripted(lambda data: [begun])) as bench:
        bench.device = replace(bench.device, server_timeout=HASTY)
        sdo = bench.dialogue()
        sdo.send(UploadInitiate(TEXT.mux))
        sdo.receive()
        assert sdo.wire.next_frame(2 * HASTY) is None
        sdo.end_transfer()
        assert sdo.wire.pauses.excuse


def test_the_wait_of_a_fence_is_no_pause_of_the_bench_either() -> None:
    begun = UploadInitiateResponse.with_size(TEXT.mux, 20).encode()
    node = Scripted(lambda data: [begun] if data == UploadInitiate(TEXT.mux).encode() else [])
    with undiscovered(node, timeout=4 * HASTY) as bench:
        bench.device = replace(bench.device, server_timeout=HASTY)
        sdo = bench.dialogue()
        sdo.send(UploadInitiate(TEXT.mux))
        sdo.receive()
        with pytest.raises(Violation):
            sdo.beside(bench.channel).fence()
        sdo.end_transfer()
        assert not sdo.wire.pauses.excuse
