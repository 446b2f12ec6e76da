"""A self-test stays on one processor while no other process computes there."""

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from plugin_runs import hosted, run, self_test

from conformance.faults.catalogue import build_node
from conformance.plugin import one_processor as module
from conformance.plugin.one_processor import one_processor

if sys.platform != "linux":
    pytest.skip("only Linux says which processor a thread runs on", allow_module_level=True)

pytest_plugins = ["pytester"]

ALL = os.sched_getaffinity(0)
PATIENCE = 30.0
# More than any look takes.
BUSY = 1000.0
pytestmark = pytest.mark.skipif(len(ALL) < 2, reason="there is one processor anyhow")


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Other tests compute beside this one, but that does not count."""
    monkeypatch.setattr(module, "MUCH", 1e9)


@contextmanager
def started() -> Iterator[int]:
    """Yield the id by which the system knows a thread that runs until the end."""
    ended = threading.Event()
    thread = threading.Thread(target=ended.wait)
    thread.start()
    assert thread.native_id is not None
    try:
        yield thread.native_id
    finally:
        ended.set()
        thread.join()


@pytest.mark.usefixtures("alone")
def test_this_thread_and_what_it_starts_stay_on_one_processor() -> None:
    with one_processor():
        here = os.sched_getaffinity(0)
        with started() as other:
            assert len(here) == 1
            assert os.sched_getaffinity(other) == here
    assert os.sched_getaffinity(0) == ALL


@pytest.mark.usefixtures("alone")
def test_threads_that_go_on_are_let_go_at_the_end() -> None:
    with ExitStack() as running:
        with one_processor():
            other = running.enter_context(started())
        assert os.sched_getaffinity(other) == ALL


class Told:
    """What the system tells: this processor and each other one compute so long between looks."""

    def __init__(self, here: float, elsewhere: float) -> None:
        self.here = here
        self.elsewhere = elsewhere
        self.looks = 0
        self.looked_often = threading.Event()

    def computed(self) -> dict[int, float]:
        """Return it; the first one who asks is not there yet."""
        staying = os.sched_getaffinity(0)
        found = {
            number: self.looks * (self.here if number in staying else self.elsewhere)
            for number in ALL
        }
        self.looks += 1
        if self.looks > 3:
            self.looked_often.set()
        return found


@pytest.mark.parametrize(
    ("here", "elsewhere", "stays"),
    [
        pytest.param(BUSY, 0.0, False, id="another one has nothing to do"),
        pytest.param(BUSY, BUSY, True, id="all have to compute"),
        pytest.param(0.0, 0.0, True, id="no other process computes there"),
    ],
)
def test_it_makes_room_for_another_process_where_there_is_room_elsewhere(
    monkeypatch: pytest.MonkeyPatch, here: float, elsewhere: float, *, stays: bool
) -> None:
    system = Told(here, elsewhere)
    monkeypatch.setattr(module, "_computed", system.computed)
    monkeypatch.setattr(module, "LOOK", 0.01)
    threads = set(threading.enumerate())
    with one_processor(), started() as other:
        (watch,) = [each for each in threading.enumerate() if each not in threads][:1]
        if stays:
            assert system.looked_often.wait(PATIENCE)
        else:
            watch.join(PATIENCE)
        assert (os.sched_getaffinity(other) != ALL) is stays
        assert (os.sched_getaffinity(0) != ALL) is stays


def test_where_nothing_tells_of_processors_nothing_changes(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("THREAD", "PROCESSORS"):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, tmp_path / "missing")
            with one_processor():
                assert os.sched_getaffinity(0) == ALL


class Looks:
    """Sees on which processors a run may compute."""

    def __init__(self) -> None:
        self.seen: list[set[int]] = []

    def pytest_runtest_logreport(self) -> None:
        self.seen.append(os.sched_getaffinity(0))


@pytest.mark.usefixtures("alone")
def test_a_self_test_runs_on_one_processor_and_no_other_run(pytester: pytest.Pytester) -> None:
    own, real = Looks(), Looks()
    assert self_test(pytester, "-k", "abort", plugins=[own]).ret == pytest.ExitCode.OK
    with hosted(build_node(None, 5)) as bus:
        run(pytester, "--node-id=5", *bus, "-k", "abort", plugins=[real])
    assert own.seen
    assert all(len(each) == 1 for each in own.seen)
    assert real.seen
    assert all(each == ALL for each in real.seen)
    assert os.sched_getaffinity(0) == ALL
