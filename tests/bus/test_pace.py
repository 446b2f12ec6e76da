"""What a device may be expected to do, by how it has answered so far."""

import pytest

from conformance.bus.kinds import READING, Kind, Task, Tasks
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


def after(pace: Pace, seconds: float, *tasks: Task, times: int = 1) -> Pace:
    for _ in range(times):
        pace.answered(seconds, Tasks(tasks))
    return pace


BURST = Tasks({Task(Kind.BURST): 127})
SAVE = Task(Kind.STORE, 0x1010)
EEPROM, MEMORY = Task(Kind.WRITE, 0x2010), Task(Kind.WRITE, 0x2011)


def test_a_bound_grows_with_what_was_sent() -> None:
    pace = after(Pace(), 0.001, READING, times=200)
    assert pace.patience(1.0, Tasks((READING,))) == 1.0
    assert pace.patience(1.0, BURST) > 127 * 0.01, "which is not known yet"
    after(pace, 1.27, *[Task(Kind.BURST)] * 127)
    assert pace.patience(1.0, BURST) > 2 * 1.27
    pace.silences = PROVEN
    assert pace.patience(1.0, BURST) > 2 * 1.27, "however often it has not answered"
    assert pace.patience(1.0, Tasks((READING,))) == SHORTEST


def test_a_burst_that_is_acknowledged_at_once_is_waited_for_no_longer_than_others() -> None:
    pace = after(Pace(), 0.001, *[Task(Kind.BURST)] * 127)
    assert pace.patience(1.0, BURST) == 1.0


@pytest.mark.parametrize("slow", [EEPROM, SAVE, Task(Kind.ENDING), Task(Kind.BLOCK_END)])
def test_each_kind_has_its_pace(slow: Task) -> None:
    pace = after(Pace(), 0.001, READING, times=5000)
    after(pace, 0.3, slow)
    assert pace.look(1.0, Tasks((READING,))) == SHORTEST_OF_LOOK
    assert pace.look(1.0, Tasks((slow, READING))) > 2 * 0.3


def test_each_object_has_its_pace_too() -> None:
    pace = after(Pace(), 0.001, MEMORY, times=5000)
    after(pace, 0.3, EEPROM)
    assert pace.look(1.0, Tasks((MEMORY,))) == SHORTEST_OF_LOOK
    assert pace.look(1.0, Tasks((EEPROM,))) > 2 * 0.3


def test_a_store_that_was_never_met_may_take_its_whole_time() -> None:
    pace = after(Pace(), 0.001, READING, times=200)
    assert pace.look(5.0, Tasks((SAVE,))) == 5.0


def test_a_further_channel_is_as_fast_as_the_others() -> None:
    pace = after(Pace(), 0.3, EEPROM)
    assert Pace(pace).look(1.0, Tasks((EEPROM,))) > 2 * 0.3
    assert Pace(pace).answers == 0
