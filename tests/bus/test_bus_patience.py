"""A silence counts only while the suite was listening: pauses of the bench, on a fake clock."""

from collections.abc import Iterator
from itertools import pairwise

import can
import pytest
from bus_fakes import ANSWER, Bench, message

from conformance.bus.channel import MOST_WAITS, Channel
from conformance.bus.link import Link
from conformance.bus.patience import LOOK, MOST_LATE
from conformance.reference.host import NodeClock
from conformance.sdo.can_frame import CanFrame

RESPONSE = CanFrame(0x585, ANSWER)


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    opened = Bench(monkeypatch)
    yield opened
    opened.link.close()


def pausing(bench: Bench, *pauses: float) -> None:
    """Stop the process at the end of the first looks, for the seconds of ``pauses``."""
    left = list(pauses)

    def source() -> None:
        bench.clock.now += left.pop(0) if left else 0.0

    bench.bus.source = source


def test_a_wait_is_made_of_short_looks(bench: Bench) -> None:
    seen = [bench.clock.now]
    bench.bus.source = lambda: seen.append(bench.clock.now)
    assert bench.channel.receive() is None
    assert all(later - earlier <= LOOK + 1e-6 for earlier, later in pairwise(seen))
    assert (bench.channel.missed, bench.channel.in_doubt) == (0, False)


def test_a_pause_does_not_count(bench: Bench) -> None:
    pausing(bench, 0.1)
    assert bench.channel.receive() is None
    assert bench.clock.now == pytest.approx(1000.6, abs=0.01)
    assert bench.channel.missed == pytest.approx(0.1, abs=0.01)
    assert not bench.channel.in_doubt


def test_what_came_in_a_pause_at_the_very_end_is_found(bench: Bench) -> None:
    looks = round(0.5 / LOOK)
    calls = iter(range(looks))

    def source() -> None:
        if next(calls, None) == looks - 1:
            bench.clock.now += 3.0
            bench.bus.incoming.append(message(0x585, ANSWER))

    bench.bus.source = source
    assert bench.channel.receive() == RESPONSE


def test_a_silence_in_doubt_is_waited_out_again(bench: Bench) -> None:
    pausing(bench, 2.0)
    assert bench.channel.receive() is None
    assert bench.clock.now == pytest.approx(1003.0, abs=0.02)
    assert bench.channel.waited_again
    assert not bench.channel.in_doubt
    assert bench.channel.missed == pytest.approx(2.0, abs=0.01)


def test_an_answer_that_takes_longer_after_a_pause_is_one(bench: Bench) -> None:
    pausing(bench, 2.0)
    source = bench.bus.source

    def late() -> None:
        source()
        if bench.clock.now > 1002.6:
            bench.bus.incoming.append(message(0x585, ANSWER))

    bench.bus.source = late
    assert bench.channel.receive() == RESPONSE


def test_a_bench_that_never_listens_gives_up_and_says_so(bench: Bench) -> None:
    pausing(bench, *[1.0] * 10_000)
    assert bench.channel.receive() is None
    assert bench.channel.in_doubt
    assert bench.clock.now < 1000 + MOST_WAITS * (MOST_LATE + 12) * (1 + LOOK)


def test_a_pause_of_the_client_is_as_long_as_the_clock_says(bench: Bench) -> None:
    pausing(bench, 0.3)
    assert bench.channel.pause(0.5) is None
    assert bench.clock.now == pytest.approx(1000.5, abs=0.02)
    bench.bus.incoming.append(message(0x585, ANSWER))
    assert bench.channel.pause(0.5) == RESPONSE


def test_frames_have_the_time_at_which_they_arrived(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("conformance.bus.arrivals.STAMPED", (can.BusABC,))
    link = Link(bench.bus, "stamped")
    channel = Channel(link, 5, 0.5)
    early = message(0x585, ANSWER)
    early.timestamp = 999.25
    unstamped, foreign = message(0x585, ANSWER), message(0x585, ANSWER)
    foreign.timestamp = 12.0  # by the clock of an adapter
    for frame, arrived in ((early, 999.25), (unstamped, 1000.0), (foreign, 1000.0)):
        bench.bus.incoming.append(frame)
        assert channel.receive() == RESPONSE
        assert channel.arrived == arrived


@pytest.mark.parametrize("backlog", [1, 3])
def test_a_nodes_time_stands_still_while_frames_wait(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, backlog: int
) -> None:
    """Its time-out is the client's silence, not the time that it was not running itself."""
    monkeypatch.setattr("conformance.bus.arrivals.STAMPED", (can.BusABC,))
    clock = NodeClock(bench.bus)
    assert clock.at(None, bench.clock.now) == 1000.0
    frames = [message(0x605, ANSWER) for _ in range(backlog)]
    for number, frame in enumerate(frames):
        frame.timestamp = 1000.5 + number / 1000
    bench.clock.now = 1003.0
    times = [clock.at(frame, bench.clock.now) for frame in frames]
    assert times == [pytest.approx(1000.5, abs=0.005)] * backlog
    bench.clock.now = 1004.0
    assert clock.at(None, bench.clock.now) == pytest.approx(1001.5, abs=0.005)


def test_a_nodes_time_stands_still_while_it_answers(bench: Bench) -> None:
    """A burst of segments takes long on a busy machine: the client is silent from its end on."""
    clock = NodeClock(bench.bus)
    assert clock.at(message(0x605, ANSWER), 1000.0) == 1000.0
    clock.hold(1002.0)
    assert clock.at(None, 1002.5) == pytest.approx(1000.5)
    clock.hold(1002.501)
    assert clock.at(None, 1002.6) == pytest.approx(1000.6)
