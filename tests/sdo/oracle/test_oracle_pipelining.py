"""Requests that do not wait for answers: what is owed piles up, and is never held against a server.

A server takes what was sent in order, and so the answers come, however late they do. The ways in
which a burst of requests may be meant grow with each of them, until nothing can be said any more.
"""

import pytest
from hypothesis import given, note, settings
from hypothesis import strategies as st
from oracle_notation import judged
from support.oracle_lockstep import known_entries, reference_node
from support.oracle_objects import NODE_ID, TARGETS, TEXT, VENDOR_ID
from support.sdo_strategies import UNHURRIED

from conformance.model_cases.matrix.stimuli import STIMULI
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockSegment,
    UploadInitiate,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.oracle import Oracle, requests_in_turn, standing
from conformance.sdo.rules import Violation

ABORT = Abort(TEXT, AbortCode.GENERAL_ERROR).encode()
READ = UploadInitiate(VENDOR_ID).encode()
# Each of these may be answered by an abort, or by nothing.
AMBIGUOUS = bytes.fromhex("A100000000000000")
REQUESTS = [
    frame.data
    for frame in (stimulus(TARGETS) for stimulus in STIMULI.values())
    if frame == CanFrame(0x600 + NODE_ID, frame.data) and len(frame.data) == 8
]
BURSTS = st.lists(st.sampled_from(REQUESTS), min_size=1, max_size=10)


class Pipeline:
    """A reference server whose answers come when the client has sent a whole burst."""

    def __init__(self) -> None:
        self.node = reference_node()
        self.oracle = Oracle(known_entries(), NODE_ID)
        self.log: list[str] = []

    def burst(self, requests: list[bytes]) -> list[Violation]:
        answers = []
        for request in requests:
            self.oracle.request(request)
            self.log.append(f"> {request.hex(' ')}")
            answers += self.node.receive(CanFrame(0x600 + NODE_ID, request))
        found = []
        for answer in answers:
            broken = self.oracle.response(answer)
            self.log += [f"< {answer}", *map(str, broken)]
            found += broken
        return found


@settings(UNHURRIED, max_examples=20)
@given(st.lists(st.tuples(BURSTS, st.booleans()), min_size=1, max_size=3))
def test_answers_to_bursts_are_accepted(bursts: list[tuple[list[bytes], bool]]) -> None:
    pipeline = Pipeline()
    found = []
    for burst, pause in bursts:
        found += pipeline.burst([*burst, ABORT, READ])
        found += pipeline.oracle.settled() if pause else []
    note("\n".join(pipeline.log))
    assert found == []


def test_an_abort_for_a_late_segment_may_come_behind_that_of_the_client() -> None:
    """The segments 2, 1, 2 of a sub-block may end in 05040003h, the last one for itself."""
    oracle = Oracle(known_entries(), NODE_ID)
    oracle.request(BlockDownloadInitiate.with_size(TEXT, 15).encode())
    assert oracle.response(BlockDownloadInitiateResponse(TEXT, 127).encode()) == []
    for number in (2, 1, 2):
        oracle.request(BlockSegment(number, b"segment").encode())
    oracle.request(ABORT)
    late = Abort(TEXT, AbortCode.INVALID_SEQUENCE_NUMBER).encode()
    assert oracle.response(late) == []
    assert oracle.ended is None, "there is a reason for it"
    idle = Abort(Multiplexer(0), AbortCode.COMMAND_NOT_VALID).encode()
    assert oracle.response(idle) == []
    assert oracle.settled() == []


def test_segments_behind_a_late_acknowledgement_may_be_refused_one_by_one() -> None:
    """What follows an abort inside a sub-block has met an idle server, however late it is heard."""
    oracle = Oracle(known_entries(), NODE_ID)
    oracle.request(BlockDownloadInitiate.with_size(TEXT, None).encode())
    assert oracle.response(BlockDownloadInitiateResponse(TEXT, 127).encode()) == []
    oracle.request(BlockSegment(68, b"segment", last=True).encode())
    for number in (2, 1, 3):
        oracle.request(BlockSegment(number, b"segment").encode())
    oracle.request(ABORT)
    assert oracle.response(BlockAck(0, 127).encode()) == []
    assert oracle.response(Abort(TEXT, AbortCode.INVALID_SEQUENCE_NUMBER).encode()) == []
    assert oracle.response(Abort(Multiplexer(0), AbortCode.COMMAND_NOT_VALID).encode()) == []
    assert oracle.settled() == []


def test_many_ambiguous_requests_are_more_than_can_be_followed() -> None:
    oracle = Oracle(known_entries(), NODE_ID)
    followed = 0
    while not oracle.lost:
        oracle.request(AMBIGUOUS)
        followed += 1
    # No client sends more than these without a look at the answers.
    assert followed > 5
    assert oracle.settled() == []


def test_what_could_not_be_followed_is_not_held_against_the_server(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module in (requests_in_turn, standing):
        monkeypatch.setattr(module, "MOST_BRANCHES", 100)
    pipeline = Pipeline()
    assert pipeline.burst([READ] * 20 + [AMBIGUOUS] * 20 + [ABORT] + [READ] * 20) == []
    assert pipeline.oracle.settled() == []


def test_when_all_answers_are_in_the_server_is_judged_again() -> None:
    pipeline = Pipeline()
    pipeline.burst([READ] * 20)
    pipeline.oracle.settled()
    assert pipeline.burst([READ]) == []
    assert not pipeline.oracle.lost
    pipeline.oracle.request(READ)
    assert pipeline.oracle.response(AMBIGUOUS) != []


def test_answers_behind_a_breach_and_an_abort_may_be_to_earlier_requests() -> None:
    oracle = Oracle(known_entries(), NODE_ID)
    for request in (READ, READ, READ, ABORT):
        oracle.request(request)
    assert oracle.response(bytes(8)) != []
    answer = bytes.fromhex("4318100100000000")
    assert [oracle.response(answer) for _ in range(2)] == [[], []]
    oracle.request(READ)
    assert oracle.response(answer) == []


def test_an_answer_may_cross_the_abort_of_a_transfer_that_was_not_seen_to_begin() -> None:
    oracle = Oracle(known_entries(), NODE_ID)
    oracle.lose()
    oracle.request(bytes.fromhex("6000000000000000"))
    oracle.request(ABORT)
    assert oracle.response(bytes.fromhex("0041424344454647")) == []
    oracle.request(READ)
    assert oracle.response(bytes.fromhex("4318100100000C5D")) == []
    assert oracle.idle


def test_an_answer_proves_that_nothing_before_its_request_is_owed() -> None:
    """Four segments cross with an abort; each of them may be refused, before the next answer."""
    oracle = Oracle()
    begun = "> C2 10 20 00 46 00 00 00 \n < A0 10 20 00 7F 00 00 00"
    assert judged(begun, oracle) == []
    for number in range(1, 5):
        oracle.request(bytes((number, *range(7))))
    assert oracle.response(bytes.fromhex("8010200020000008")) == []
    assert oracle.lost
    assert judged("> 40 00 20 00 00 00 00 00 \n < 43 00 20 00 01 00 00 00", oracle) == []
    assert not oracle.lost
    assert [found.rule.id for found in judged("< 80 00 00 00 01 00 04 05", oracle)] == [
        "response.unsolicited"
    ]
