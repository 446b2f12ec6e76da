"""What a device may be expected to do, by how it has answered so far."""

import pytest

from conformance.bus.pace import LOOKED_AT, PROVEN, SHORTEST, SHORTEST_OF_LOOK, TOO_MANY, Pace
from conformance.sdo.nmt import NmtState


@pytest.mark.parametrize(
    ("taken", "patience"), [(0.0001, SHORTEST), (0.007, SHORTEST), (0.03, 0.32), (0.9, 1.0)]
)
def test_a_device_that_leaves_requests_unanswered_is_waited_for_as_long_as_makes_sure(
    taken: float, patience: float
) -> None:
    pace = Pace()
    for _ in range(200):
        pace.answered(taken)
    pace.answered(0.5)  # the machine was busy
    for _ in range(PROVEN):
        assert pace.patience(1.0) == 1.0
        pace.unanswered()
    assert pace.patience(1.0) == pytest.approx(patience)


def test_the_typical_answer() -> None:
    pace = Pace()
    assert pace.typical == 0.0
    pace.answered(0.25)
    pace.answered(0.75)
    assert (pace.typical, pace.nearly_all) == (0.5, 1.024)


def test_behind_a_late_answer_a_device_is_waited_for_again() -> None:
    pace = Pace()
    pace.answered(0.001)
    pace.silences = PROVEN
    assert pace.patience(1.0) == SHORTEST
    pace.late(0.15)
    assert pace.patience(1.0) == 1.0


def test_a_device_that_drops_each_fifth_read_is_not_sound() -> None:
    pace = Pace()
    for number in range(LOOKED_AT):
        assert pace.unsound == ""
        pace.read(answered=number % 5 != 4)
    assert f"{TOO_MANY} of the last {LOOKED_AT} reads of 1000h" in pace.unsound


def test_one_that_misses_a_read_now_and_then_is() -> None:
    pace = Pace()
    for number in range(10 * LOOKED_AT):
        pace.read(answered=number % 6 != 0)
    assert pace.unsound == ""


def test_a_state_is_waited_for_as_long_as_the_slowest_change_so_far_makes_sure() -> None:
    pace = Pace()
    waits = []
    for seconds in (0.004, 0.03, 0.02, 0.07):
        pace.entered(NmtState.OPERATIONAL, seconds)
        waits.append(pace.entering(NmtState.OPERATIONAL, 0.1))
    assert waits == [SHORTEST_OF_LOOK, 0.06, 0.06, 0.1]
    assert pace.entering(NmtState.PRE_OPERATIONAL, 0.1) == 0.1
