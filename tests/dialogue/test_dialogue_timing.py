"""How long the answers of a case take, by a clock that is set."""

import time

import pytest
from support.run_bench import NODE_ID, READ, RULE, recording

from conformance.bus.channel import Channel
from conformance.bus.link import Link
from conformance.bus.pace import SHORTEST_OF_ROOM, Pace
from conformance.device.device import DEVICE_TYPE, Device
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.timing import Timing
from conformance.reference.node import Node
from conformance.reference.simulated_bus import SimulatedBus
from conformance.sdo.abort_codes import AbortCode


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    return now


def test_what_comes_behind_an_answer_is_none_of_its_own(clock: list[float]) -> None:
    timing = Timing(Pace())
    timing.sent()
    timing.received(100.25)
    timing.received(100.75)
    assert (timing.answers, timing.answering, timing.latency) == (1, 0.25, 0.75)
    clock[0] = 101.0
    timing.sent()
    timing.received(101.5)
    assert (timing.answers, timing.answering) == (2, 0.75)


def test_the_first_answer_behind_a_silence_is_late(clock: list[float]) -> None:
    timing = Timing(Pace())
    timing.sent()
    timing.came_late()
    assert timing.answered_after is None, "no wait was given up"
    timing.gave_up()
    clock[0] = 102.0
    timing.came_late()
    clock[0] = 103.0
    timing.came_late()
    assert timing.answered_after == 2.0


def test_another_channel_counts_for_the_case(clock: list[float]) -> None:
    pace = Pace()
    timing, other = Timing(pace), Timing(Pace())
    timing.sent()
    timing.received(100.5)
    other.sent()
    other.received(100.75)
    clock[0] = 101.0
    other.waited_since(100.0)
    timing.include(other)
    assert (timing.latency, timing.waited) == (0.75, 1.0)
    assert (timing.answers, timing.answering) == (1, 0.5)
    assert (pace.answers, pace.beside) == (1, 1)


def test_a_pause_before_a_request_is_no_time_that_its_answer_takes() -> None:
    """Else the pause behind each abort is twice as long as the one before, up to the time-out."""
    link = Link(SimulatedBus([Node(NODE_ID, recording())]), "simulated")
    channel = Channel(link, NODE_ID, 1.0)
    sdo = Dialogue(channel, Device(NODE_ID), CaseRecord(RULE), seed=1)
    for _ in range(5):
        channel.abort(DEVICE_TYPE, AbortCode.GENERAL_ERROR)
        sdo.send(READ)
        sdo.receive()
    link.close()
    assert sdo.wire.timing.latency < SHORTEST_OF_ROOM
    assert channel.pace.room(1.0) == SHORTEST_OF_ROOM
