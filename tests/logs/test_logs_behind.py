"""A server that answers each request when the next frame comes, and those that are only slow."""

from collections.abc import Iterator, Sequence

import pytest
from judged_logs import found_in, told_of

IDLE = "0.0 > 80 00 00 00 00 00 04 05"
END = "99.0 081#0000000000000000"
OBJECTS = ("00 10 00", "00 20 01", "18 10 01", "00 20 00")


def _behind(
    waits: Sequence[float], *, after: float = 0.0005, aborts: bool = False
) -> Iterator[str]:
    """Yield reads one after another, each answered so many seconds after the next frame.

    A client that ``aborts`` does so where it has waited for half a second.
    """
    now, due = 0.1, ""
    yield IDLE
    for number, wait in enumerate(waits):
        mux = OBJECTS[number % len(OBJECTS)]
        yield f"{now:.4f} > 40 {mux}"
        if due:
            yield f"{now + after:.4f} < 43 {due} 01"
        now, due = now + wait, mux
        if aborts and wait >= 0.5:
            yield f"{now:.4f} > 80 {mux} 00 00 04 05"
            yield f"{now + after:.4f} < 43 {due} 01"
            now, due = now + 0.1, ""
    yield END


@pytest.mark.parametrize("aborts", [False, True])
@pytest.mark.parametrize("waits", [[1.0, 0.1] * 6, [1.0, 1.0, 0.01] * 4, [0.01] * 20])
def test_answers_that_wait_for_the_next_frame_are_one_finding(
    waits: list[float], aborts: bool
) -> None:
    lines = list(_behind(waits, aborts=aborts))
    (found,) = found_in(*lines)
    assert found.endswith(" response.answered")
    told = told_of(*lines)
    assert [line for line in told if "answers are one request behind" in line]


def test_a_client_that_waits_equally_long_finds_it_by_the_last_one() -> None:
    (found,) = found_in(*_behind([1.0] * 10))
    assert found.endswith(" response.answered")


def test_what_comes_of_it_is_no_finding() -> None:
    """The answers have a length that their objects cannot have, as far as they are known."""
    lines = [line.replace("< 43 18 10 01", "< 4F 18 10 01") for line in _behind([0.01] * 40)]
    found = found_in(*lines)
    assert len(found) <= 3
    assert found[-1].endswith(" response.answered")


def _slow(waits: Sequence[float]) -> Iterator[str]:
    """Yield reads that the client gives up, each answered right behind its abort."""
    yield IDLE
    for number, wait in enumerate(waits):
        mux, asked = OBJECTS[number % len(OBJECTS)], 0.1 + 2 * number
        yield f"{asked:.4f} > 40 {mux}"
        yield f"{asked + wait:.4f} > 80 {mux} 00 00 04 05"
        yield f"{asked + wait + 0.001:.4f} < 43 {mux} 01"
    yield END


@pytest.mark.parametrize(
    "lines",
    [
        list(_slow([1.0] * 12)),
        list(_behind([1.0, 0.1] * 6, after=0.05)),
        list(_behind([1.0, 0.1, 1.0, 0.1])),
        [IDLE, *(f"{1 + number:.1f} > 40 00 20 00" for number in range(3)),
         *(f"{3.1 + number / 10:.1f} < 43 00 20 00 01" for number in range(3)), END],
    ],
    ids=["as-slow-as-the-client-waits", "not-at-once", "seldom", "late-together"],
)  # fmt: skip
def test_slow_answers_are_not_behind(lines: list[str]) -> None:
    assert "answers are one request behind" not in "\n".join(told_of(*lines))


def test_a_server_that_is_behind_no_longer_is_judged_again() -> None:
    lines = [*_behind([1.0, 0.1] * 6)][:-1]
    sound = ("20.0 > 40 00 20 00", "20.001 < 43 00 20 00 01", "20.1 > 40 00 20 00", "20.101 < A1")
    assert [found.split()[1] for found in found_in(*lines, *sound)] == [
        "response.answered", "response.specifier",
    ]  # fmt: skip
