"""An alarm goes off in time, though timers fire late; and it does not trust them too much."""

import time

import pytest

from conformance.bus.alarm import MOST_LATE, Alarm


class Timer:
    """A clock of its own; each wait on it takes ``late`` seconds longer than asked for."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, late: float) -> None:
        self.now = 100.0
        self.late = late
        self.waits: list[float] = []
        monkeypatch.setattr(time, "monotonic", lambda: self.now)

    def wait(self, seconds: float) -> None:
        self.waits.append(seconds)
        self.now += seconds + self.late


def test_it_learns_how_late_timers_are(monkeypatch: pytest.MonkeyPatch) -> None:
    timer = Timer(monkeypatch, late=0.0001)
    alarm = Alarm(timer.wait)
    for _ in range(100):
        due = timer.now + 0.002
        alarm.wait_until(due)
    assert timer.now == pytest.approx(due, abs=1e-6)
    assert timer.waits[0] == pytest.approx(0.002)
    assert timer.waits[-1] == pytest.approx(0.0019, abs=1e-6)


def test_a_machine_that_is_busy_does_not_make_it_early(monkeypatch: pytest.MonkeyPatch) -> None:
    timer = Timer(monkeypatch, late=0.5)
    alarm = Alarm(timer.wait)
    for _ in range(100):
        alarm.wait_until(timer.now + 0.002)
    assert timer.waits[-1] == pytest.approx(0.002 - MOST_LATE)


def test_what_is_past_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    timer = Timer(monkeypatch, late=0.0)
    Alarm(timer.wait).wait_until(timer.now - 1)
    assert timer.waits == []
