"""What failed once and not again: whether it is the bus, and how often that may be."""

import pytest

from conformance.run.frame_loss import (
    ALWAYS,
    MOST_SHOWN,
    PER_THOUSAND,
    Doubts,
    Stumble,
    is_certain,
)
from conformance.sdo.rules import Cause

SILENT = "response.answered: no answer to upload initiate"


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
