"""A request to stop is noticed between frames, in good order; who knows nothing of it, at once."""

from collections.abc import Iterator

import can
import pytest
from bus_fakes import ANSWER, READ, Bench, message

from conformance.bus.patience import LOOK
from conformance.bus.stop import RunStopped, Stop
from conformance.sdo.can_frame import CanFrame


def requested(times: int = 1) -> Stop:
    stop = Stop()
    for _ in range(times):
        stop.request("SIGTERM")
    return stop


def test_no_stop_was_asked_for() -> None:
    Stop().check()


def test_who_has_asked_is_told() -> None:
    with pytest.raises(RunStopped, match=r"the run was stopped \(SIGTERM\)"):
        requested().check()


def test_what_is_put_back_is_put_back_to_the_end() -> None:
    stop = requested()
    with stop.putting_back():
        stop.check()
    with pytest.raises(RunStopped):
        stop.check()


def test_the_second_request_gives_that_up() -> None:
    stop = requested()
    with stop.putting_back():
        stop.request("SIGINT")
        with pytest.raises(RunStopped, match="SIGINT"):
            stop.check()
    assert stop.gives_up


def test_other_code_is_interrupted_at_once() -> None:
    stop = Stop()
    with stop.interruptible(), pytest.raises(RunStopped):
        stop.request("SIGTERM")


def test_other_code_is_not_interrupted_within_a_driver() -> None:
    stop = Stop()
    with stop.interruptible():
        stop.enter()
        stop.request("SIGTERM")
        with pytest.raises(RunStopped):
            stop.leave()


def test_nor_while_it_has_values_put_back() -> None:
    stop = Stop()
    with stop.interruptible():
        with stop.putting_back():
            stop.request("SIGTERM")
        with pytest.raises(RunStopped):
            stop.check()


def test_listeners_are_told_of_each_request() -> None:
    stop, told = Stop(), []
    stop.when_requested(lambda: told.append(stop.requests))
    stop.request("SIGTERM")
    stop.request("SIGTERM")
    assert told == [1, 2]


# On a bus


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    bench = Bench(monkeypatch)
    yield bench
    bench.link.close()


def test_nothing_is_sent_any_more(bench: Bench) -> None:
    bench.link.stop.request("SIGTERM")
    with pytest.raises(RunStopped):
        bench.link.send(CanFrame(0x605, READ))
    assert bench.bus.sent == []


def test_a_wait_is_over_with_the_next_look(bench: Bench) -> None:
    begin = bench.clock.now

    def signalled() -> None:
        bench.link.stop.request("SIGTERM")

    bench.bus.source = signalled
    with pytest.raises(RunStopped):
        bench.link.receive(60.0)
    assert bench.clock.now - begin <= 2 * LOOK


def test_a_frame_that_has_come_is_still_handed_on(bench: Bench) -> None:
    """The signal came while the driver had it in its hands: the log has it, and the answer."""

    def signalled() -> can.Message:
        bench.link.stop.request("SIGTERM")
        return message(0x585, ANSWER)

    bench.bus.source = signalled
    assert bench.link.receive(1.0) == CanFrame(0x585, ANSWER)
    assert len(bench.captured) == 1
    with pytest.raises(RunStopped):
        bench.link.look()
