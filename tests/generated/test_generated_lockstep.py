"""A conversation in lockstep with the oracle ends, and says what a server goes on with."""

import pytest
from run_bench import BASELINE, NODE_ID, NUMBER, READ, TEXT, Scripted, undiscovered

from conformance.generated.lockstep import Lockstep
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import Abort, UploadInitiate, UploadSegment
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


@pytest.mark.parametrize("point", [True, False])
def test_a_new_initiate_that_is_refused_is_not_waited_out(*, point: bool) -> None:
    node = Scripted(
        lambda data: {
            READ: [BASELINE],
            UploadInitiate(TEXT.mux).encode(): [BEGUN],
            UploadInitiate(NUMBER.mux).encode(): [SUPERSEDED],
        }.get(data, [])
    )
    with undiscovered(node, timeout=10.0) as bench:
        sdo = bench.dialogue()
        lockstep = Lockstep(sdo, Oracle(None, NODE_ID))
        with lockstep.following():
            lockstep.send(frame(UploadInitiate(TEXT.mux).encode()))
            lockstep.send(frame(UploadInitiate(NUMBER.mux).encode()), point=point)
            lockstep.settle(TEXT.mux)
    assert sdo.wire.timing.waited <= 1.0
