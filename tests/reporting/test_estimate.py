"""How long a run will take yet: from what its cases have to do, and how long others have taken."""

import random
from math import inf

import pytest

from conformance.reporting.estimate import Estimate, Taken
from conformance.reporting.workload import UNKNOWN, counted, work_of
from conformance.run.case_files import case_files

FILES = ("abort", "block_download", "expedited_download", "matrix", "segmented_upload")
# So long takes a second of work, and an answer.
MACHINES = [(1.0, 0.0), (0.3, 0.0002), (1.0, 0.01), (2.0, 0.9)]


def names() -> list[str]:
    """Return cases of some services, as a run has them, file by file."""
    return [
        f"cases/test_{file}.py::{file}.case[{number}]" for file in FILES for number in range(80)
    ]


def taken(name: str, machine: tuple[float, float], chance: random.Random) -> Taken:
    """Return how long a case takes: what it has to do is known on the average."""
    work = work_of(name)
    answers = round(work.answers * chance.uniform(0.5, 1.5))
    answering = answers * machine[1]
    working = work.seconds * machine[0] * chance.uniform(0.5, 1.5)
    return Taken(working + answering + work.silences, answers, answering, work.silences)


@pytest.mark.parametrize("machine", MACHINES)
def test_after_a_part_of_the_work_the_rest_is_known(machine: tuple[float, float]) -> None:
    chance = random.Random(1)
    estimate, cases = Estimate(1.0), names()
    estimate.select(cases)
    times = {name: taken(name, machine, chance) for name in cases}
    while estimate.part < 0.05:
        name = cases.pop(0)
        estimate.finish(name, times[name])
    left = sum(times[name].seconds for name in cases)
    assert estimate.left() == pytest.approx(left, rel=0.2)
    assert estimate.done == len(names()) - len(cases)


def test_the_process_that_takes_longest_counts() -> None:
    cases = names()
    estimate = Estimate()
    estimate.select(cases[:100], "gw0")
    estimate.select(cases[100:], "gw1")
    for worker, some in (("gw0", cases[:50]), ("gw1", cases[100:150])):
        for name in some:
            estimate.finish(name, Taken(work_of(name).seconds), worker)
    rest = sum(work_of(name).seconds for name in cases[150:])
    assert estimate.left() == pytest.approx(rest, rel=0.1)
    assert (estimate.selected, estimate.done) == (400, 100)


def test_what_a_device_lacks_takes_no_time_later_on_either() -> None:
    """Cases that were not testable say nothing of the pace, but of others like them."""
    cases = [name for name in names() if "block" in name]
    estimate = Estimate()
    estimate.select(cases)
    for name in cases[:40]:
        estimate.finish(name, Taken(0.0, tried=False))
    due = sum(work_of(name).due(1.0, 0.0, 0.0) for name in cases[40:])
    assert estimate.left() < due / 5


def test_what_needs_more_room_than_there_is_takes_no_time_for_other_services_either() -> None:
    """The longest cases of all are those that a device with little room cannot be put to."""
    cases = [
        f"cases/test_{service}.py::{service.replace('_', '-')}.{point}"
        for point in ("beyond-16-bits[65544]", "size[1]")
        for service in ("block_download", "block_upload", "segmented_download")
    ]
    estimate = Estimate()
    estimate.select(cases)
    estimate.finish(cases[0], Taken(0.0, tried=False))
    estimate.finish(cases[3], Taken(work_of(cases[3]).seconds))
    due = sum(work_of(name).seconds for name in [*cases[1:3], *cases[4:]])
    assert estimate.left() < due / 10


ANY_FRAMES = "cases/test_random.py::random.any-frames"


def test_a_random_case_ends_in_its_time() -> None:
    assert Estimate().work(ANY_FRAMES).due(1.0, 1.0, 0.0) == 60.0


def test_a_random_case_takes_as_long_as_it_has_examples() -> None:
    usual, more = Estimate(search_seconds=inf), Estimate(times=25.0, search_seconds=inf)
    assert more.due(ANY_FRAMES) == pytest.approx(25 * usual.due(ANY_FRAMES))
    other = "cases/test_abort.py::abort.repeated"
    assert more.due(other) == usual.due(other)


def test_a_test_that_was_not_counted() -> None:
    answers, silences, milliseconds = UNKNOWN
    found = work_of("test_mine.py::test_of_my_own[1]")
    assert (found.answers, found.silences, found.seconds) == (
        answers,
        silences,
        milliseconds / 1000,
    )


def test_every_kind_of_case_was_counted() -> None:
    """Run ``tests/workload.py`` when there is a new file of cases."""
    services = {path.stem.removeprefix("test_") for path in case_files()}
    assert services <= counted()


def test_nothing_is_left_of_no_cases() -> None:
    assert Estimate().left() == 0.0
    assert Estimate().part == 0.0
