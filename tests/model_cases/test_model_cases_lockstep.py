"""A conversation in lockstep with the oracle ends, and says what a server goes on with."""

import pytest
from support.run_bench import BASELINE, NODE_ID, NUMBER, READ, TEXT, Scripted, undiscovered

from conformance.faults.catalogue import build_node
from conformance.model_cases.lockstep import Lockstep
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.oracle import Oracle
from conformance.sdo.rules import Violation

SUPERSEDED = Abort(TEXT.mux, AbortCode.COMMAND_NOT_VALID).encode()
BEGUN = bytes.fromhex("4110200014000000")
UNKNOWN = bytes.fromhex("E010200000000000")
SEGMENT = b"\0ABCDEFG"
HASTY = 0.05


def frame(data: bytes) -> CanFrame:
    return CanFrame(0x600 + NODE_ID, data)


class Careless(Scripted):
    """Aborts a transfer that a new one supersedes, and sends its next segment all the same."""

    def __init__(self) -> None:
        super().__init__(self._answer)

    def _answer(self, data: bytes) -> list[bytes]:
        answers = {
            READ: [BASELINE],
            UploadInitiate(TEXT.mux).encode(): [BEGUN],
            UploadInitiate(NUMBER.mux).encode(): [SUPERSEDED, SEGMENT],
            UNKNOWN: [SUPERSEDED],
            UploadSegment(0).encode(): [SEGMENT],
        }
        return answers.get(data, [])


def test_a_known_breach_behind_the_abort_of_a_superseded_transfer_ends_the_wait() -> None:
    with undiscovered(Careless(), timeout=HASTY) as bench:
        sdo = bench.dialogue()
        for _ in range(2):
            lockstep = Lockstep(sdo, Oracle(None, NODE_ID))
            with lockstep.following():
                lockstep.send(frame(UploadInitiate(TEXT.mux).encode()))
                try:
                    answers = lockstep.send(frame(UploadInitiate(NUMBER.mux).encode()))
                except Violation as found:
                    sdo.record.causes.add(
                        sdo.record.cause_of(found, sdo.wire.last_sent), "a.case", found, aside=False
                    )
                sdo.end_transfer()
                sdo.drain()
    assert [answer.encode() for answer in answers] == [SUPERSEDED, SEGMENT]
    assert len(list(sdo.record.causes)) == 1


def test_a_segment_behind_an_abort_of_the_server_is_of_what_goes_on() -> None:
    with undiscovered(Careless(), timeout=HASTY) as bench:
        sdo = bench.dialogue()
        lockstep = Lockstep(sdo, Oracle(None, NODE_ID))
        with lockstep.following():
            lockstep.send(frame(UploadInitiate(TEXT.mux).encode()))
            assert lockstep.send(frame(UNKNOWN)) == [decode_response(SUPERSEDED)]
            lockstep.send(frame(UploadSegment(0).encode()))
            with pytest.raises(Violation) as found:
                lockstep.settle(TEXT.mux)
    cause = sdo.record.cause_of(found.value, sdo.wire.last_sent)
    assert str(cause).startswith("server.nothing-afterwards: a transfer goes on"), cause


def test_a_segment_where_nothing_was_aborted_is_one_without_a_transfer() -> None:
    with undiscovered(Careless(), timeout=HASTY) as bench:
        sdo = bench.dialogue()
        lockstep = Lockstep(sdo, Oracle(None, NODE_ID))
        with lockstep.following():
            lockstep.send(frame(UploadSegment(0).encode()))
            with pytest.raises(Violation) as found:
                lockstep.settle(TEXT.mux)
    assert str(sdo.record.cause_of(found.value, sdo.wire.last_sent)) == (
        "segmented-upload.without-initiate: upload segment response"
    )


INVALID_BLOCK_SIZE = Abort(TEXT.mux, AbortCode.INVALID_BLOCK_SIZE).encode()
NO_BLOCK_SIZE = BlockUploadInitiate(TEXT.mux, block_size=0)


def superseding(abort: bytes, *late: bytes) -> Scripted:
    """Return a node that aborts an upload where another begins; what comes ``late`` is served."""
    return Scripted(
        lambda data: {
            READ: [*late, BASELINE],
            UploadInitiate(TEXT.mux).encode(): [BEGUN],
            NO_BLOCK_SIZE.encode(): [abort],
        }.get(data, [])
    )


def begin_another(lockstep: Lockstep, *, point: bool = True) -> None:
    """Ask for blocks of no segments within an upload, and settle."""
    with lockstep.following():
        lockstep.send(frame(UploadInitiate(TEXT.mux).encode()))
        lockstep.send(frame(NO_BLOCK_SIZE.encode()), point=point)
        lockstep.settle(TEXT.mux)


@pytest.mark.parametrize(
    ("abort", "point", "waits"),
    [
        (SUPERSEDED, True, True),
        (SUPERSEDED, False, True),
        (INVALID_BLOCK_SIZE, False, True),
        (INVALID_BLOCK_SIZE, True, False),
    ],
)
def test_a_refusal_is_not_waited_out(abort: bytes, *, point: bool, waits: bool) -> None:
    with undiscovered(superseding(abort), timeout=10.0) as bench:
        sdo = bench.dialogue()
        begin_another(Lockstep(sdo, Oracle(None, NODE_ID)), point=point)
    assert sdo.wire.timing.waited <= 1.0
    assert (sdo.wire.timing.waited > 0.0) == waits


def test_a_code_that_no_initiate_is_refused_by_may_be_of_the_transfer_before() -> None:
    known = UploadInitiate(NUMBER.mux).encode()
    answers = {
        UploadInitiate(TEXT.mux).encode(): [BEGUN],
        known: [INVALID_BLOCK_SIZE],
        READ: [BASELINE],
    }
    with undiscovered(Scripted(lambda data: answers.get(data, []))) as bench:
        sdo = bench.dialogue()
        lockstep = Lockstep(sdo, Oracle(None, NODE_ID))
        with lockstep.following():
            lockstep.send(frame(UploadInitiate(TEXT.mux).encode()))
            lockstep.send(frame(known), point=True)
            assert sdo.wire.timing.waited > 0.0
            lockstep.settle(NUMBER.mux)


def test_a_second_abort_comes_before_the_fence() -> None:
    with undiscovered(superseding(INVALID_BLOCK_SIZE, INVALID_BLOCK_SIZE)) as bench:
        lockstep = Lockstep(bench.dialogue(), Oracle(None, NODE_ID))
        begin_another(lockstep)
    topic = "a new initiate in a segmented upload"
    assert lockstep.oracle.profile[topic] == {"served behind an abort"}
    assert lockstep.oracle.idle


def test_what_is_served_though_it_was_refused_is_found_by_the_fence() -> None:
    blocks = bytes.fromhex("C610200014000000")
    with undiscovered(superseding(INVALID_BLOCK_SIZE, blocks)) as bench:
        lockstep = Lockstep(bench.dialogue(), Oracle(None, NODE_ID))
        with pytest.raises(Violation, match="invalid block size") as found:
            begin_another(lockstep)
    assert found.value.asked == NO_BLOCK_SIZE


def test_the_suite_aborts_what_runs_and_not_what_it_is_told_of() -> None:
    """A frame of the conversation has begun a block download of another object than its own."""
    with undiscovered(build_node("foreign-abort-ignored", NODE_ID), timeout=HASTY) as bench:
        lockstep = Lockstep(bench.dialogue(), Oracle(None, NODE_ID))
        with lockstep.following():
            lockstep.send(frame(BlockDownloadInitiate.with_size(TEXT.mux, None).encode()))
            lockstep.settle(NUMBER.mux)
        assert lockstep.oracle.idle
