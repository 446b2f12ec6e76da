"""What failed once and not again: whether it is the bus, and how often that may be."""

import pytest

from conformance.device.device import Device
from conformance.device.effort import TRIES_OF_CASE
from conformance.device.learned import Reason, Unread
from conformance.dialogue.causes import Causes
from conformance.run.frame_loss import (
    ALWAYS,
    MOST_SHOWN,
    PER_THOUSAND,
    Beginning,
    Doubts,
    Stumble,
    beginning,
    in_doubt,
    is_certain,
    is_settled,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import ANSWERED, Cause, Violation

SILENT = "response.answered: no answer to upload initiate"
A, B = ("a", "here"), ("b", "there")


@pytest.mark.parametrize("frames", [0, 500, 10_000])
def test_a_cause_is_excused_as_often_as_adapters_lose_frames(frames: int) -> None:
    doubts = Doubts(frames)
    for number in range(ALWAYS + PER_THOUSAND * frames // 1000):
        assert doubts.excuses(SILENT)
        doubts.add(f"case-{number}", SILENT)
    assert not doubts.excuses(SILENT)
    assert doubts.excuses("another cause")


def test_what_is_told() -> None:
    doubts = Doubts(frames=90)
    assert doubts.lines() == []
    for number in range(MOST_SHOWN + 2):
        doubts.add(f"case-{number}", SILENT)
    first, one, *_, last = doubts.lines()
    assert first == "failed once, but not when repeated, 22 in 90 frames:"
    assert one == f"case-0 ({SILENT})"
    assert last == "2 more, in the notes of their cases"


@pytest.mark.parametrize(
    ("tries", "certain"),
    [
        ("a9", False),
        ("a0", False),
        ("a9 a8", True),
        ("a9 b8", False),
        ("a30 a31", False),
        ("a30 a31 a32", True),
        ("a30 b30 a31 a31", True),
        ("a300 a301 a302 a303 a304", False),
        ("a300 a300", False),
        ("a300 a300 a300", True),
        ("a300 a299 a300 b300 a300", True),
    ],
)
def test_what_fails_at_the_same_place_again_and_again_is_the_device_s(
    tries: str, certain: bool
) -> None:
    assert (
        is_certain([Stumble(Cause(each[0], ""), int(each[1:])) for each in tries.split()])
        is certain
    )


@pytest.mark.parametrize(
    ("beginnings", "settled", "doubtful"),
    [
        ([{}], True, []),
        ([{A}], False, []),
        ([{A}, {}], True, ["a"]),
        ([{A}, {A}], True, []),
        ([{A, B}, {A}], True, ["b"]),
        ([{A}, {B}], False, ["a"]),
        ([{A}, {B}, {A}], True, ["b"]),
        ([{A}, {("a", "elsewhere")}], False, []),
        ([{A}, {("a", "elsewhere")}, {("a", "nowhere")}], True, []),
        ([{(str(number), "")} for number in range(TRIES_OF_CASE)], True, ["0", "1", "2", "3"]),
    ],
)
def test_what_was_met_before_the_first_case(
    beginnings: list[Beginning], settled: bool, doubtful: list[str]
) -> None:
    met = [frozenset(one) for one in beginnings]
    assert is_settled(met) is settled
    assert in_doubt(met) == doubtful


def test_the_beginning_of_a_run() -> None:
    device, causes = Device(5), Causes()
    assert beginning(device, causes) == frozenset()
    device.learned.unread[Multiplexer(0x1008)] = Unread(Reason.BREACH)
    silence = Violation(ANSWERED, expected="an answer", actual="nothing")
    causes.add(Cause(ANSWERED.id, "no answer"), "before", silence, aside=True)
    assert beginning(device, causes) == {
        ("a read of 1008h:00", ""),
        ("response.answered: no answer", str(silence)),
    }
