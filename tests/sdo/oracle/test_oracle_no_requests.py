"""Frames that ask for nothing: remote frames, the other identifier, requests to another node."""

import pytest
from support.oracle_lockstep import known_entries
from support.oracle_objects import NODE_ID

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.oracle import Awaited, Oracle
from conformance.sdo.rules import Level, Violation

REQUEST_ID, RESPONSE_ID = 0x600 + NODE_ID, 0x580 + NODE_ID
READ = bytes.fromhex("4018100100000000")
READ_MISSING = bytes.fromhex("40FF1F0000000000")
ABORT = bytes.fromhex("8000000001000405")
MISSING = bytes.fromhex("80FF1F0000000206")
REMOTE = CanFrame(REQUEST_ID, remote=True, length=8)
EXTENDED = CanFrame(REQUEST_ID, READ_MISSING, extended=True)
OTHER_NODE = CanFrame(REQUEST_ID + 1, READ)


def oracle() -> Oracle:
    return Oracle(known_entries(), NODE_ID)


def answered(following: Oracle, frame: CanFrame, *answers: bytes) -> list[Violation]:
    """Return what the oracle minds of answers to a frame; none of them had to come."""
    found = following.observe(frame)
    assert following.awaited is not Awaited.ANSWER
    for answer in answers:
        found += following.observe(CanFrame(RESPONSE_ID, answer))
    return found + following.settled()


def grades(found: list[Violation]) -> list[tuple[str, Level]]:
    return [(violation.rule.id, violation.rule.level) for violation in found]


@pytest.mark.parametrize("frame", [REMOTE, EXTENDED, OTHER_NODE, CanFrame(0, b"\1\0")])
def test_to_ignore_it_is_right(frame: CanFrame) -> None:
    following = oracle()
    assert answered(following, frame) == []
    assert following.idle


@pytest.mark.parametrize(
    ("frame", "answer", "rule", "level"),
    [
        (REMOTE, ABORT, "channel.remote-ignored", Level.SHOULD),
        (REMOTE, b"\x43" + READ[1:], "channel.remote", Level.MUST),
        (EXTENDED, MISSING, "channel.extended-ignored", Level.SHOULD),
        (OTHER_NODE, ABORT, "channel.request-identifier", Level.MUST),
        (CanFrame(0, b"\1\0"), ABORT, "response.unsolicited", Level.MUST),
    ],
)
def test_an_answer_breaks_the_rule_for_such_a_frame(
    frame: CanFrame, answer: bytes, rule: str, level: Level
) -> None:
    assert grades(answered(oracle(), frame, answer)) == [(rule, level)]


def test_a_second_answer_is_one_that_was_not_asked_for() -> None:
    found = grades(answered(oracle(), REMOTE, ABORT, ABORT))
    assert found[-1] == ("response.unsolicited", Level.MUST)


def test_the_refusal_of_a_remote_frame_may_come_late() -> None:
    following = oracle()
    following.observe(REMOTE)
    following.request(bytes.fromhex("8018100100000008"))
    following.request(READ_MISSING)
    found = following.response(bytes.fromhex("8000000022000008"))
    assert grades(found) == [("channel.remote-ignored", Level.SHOULD)]
    assert following.response(MISSING) == []
    assert following.idle


@pytest.mark.parametrize("goes_on", [True, False])
def test_a_transfer_may_go_on_behind_a_refused_remote_frame_or_be_over(goes_on: bool) -> None:
    following = oracle()
    following.request(bytes.fromhex("2110200007000000"))
    assert following.response(bytes.fromhex("6010200000000000")) == []
    assert grades(answered(following, REMOTE, ABORT)) == [("channel.remote-ignored", Level.SHOULD)]
    following.request(bytes.fromhex("0141424344454647"))
    answer = "2000000000000000" if goes_on else "8010200001000405"
    assert following.response(bytes.fromhex(answer)) == []
    assert following.settled() == []


def test_a_frame_of_the_other_format_that_is_served_has_its_effect() -> None:
    following = oracle()
    write = CanFrame(REQUEST_ID, bytes.fromhex("2F01200042000000"), extended=True)
    found = answered(following, write, bytes.fromhex("6001200000000000"))
    assert grades(found) == [("channel.extended-ignored", Level.SHOULD)]
    following.request(bytes.fromhex("4001200000000000"))
    assert following.response(bytes.fromhex("4F01200042000000")) == []
