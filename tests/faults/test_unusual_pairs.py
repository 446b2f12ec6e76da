"""Two right servers in one: which can be, and what a run of them shows."""

import pytest
from case_runs import Run, run_cases
from unusual_pairs import DRAWN, SEED, can_be_built, drawn, problem_with_pair

from conformance.faults.catalogue import find_deviation, unusual
from conformance.faults.registry import Deviation, acts_beside
from conformance.run.verdict import Verdict

BY_NAME = {server.name: server for server in unusual()}


def known(name: str) -> Deviation:
    return BY_NAME[name]


@pytest.mark.parametrize(
    ("first", "second", "together"),
    [
        ("foreign-abort-ignored", "no-empty-values", True),
        ("foreign-abort-ignored", "channels-11-bit-only", True),
        ("heartbeats-queued", "channels-11-bit-only", True),
        # Either refuses by a table of codes, and only one table counts.
        ("generic-length-code", "generic-access-code", False),
        ("blocks-of-7-segments", "blocks-of-21-segments", False),
        ("no-block-transfer", "blocks-of-7-segments", False),
        ("parameters-stored", "defaults-loaded-at-once", False),
    ],
)
def test_which_act_beside_each_other(first: str, second: str, *, together: bool) -> None:
    assert acts_beside(known(first), known(second)) == together
    assert acts_beside(known(second), known(first)) == together


def test_a_pair_of_which_one_lacks_what_the_other_alters_is_not_drawn() -> None:
    assert not can_be_built("an-error-in-the-list+smallest-device")
    assert can_be_built("an-error-in-the-list+no-serial-number")


def test_a_draw_is_the_same_again() -> None:
    names = drawn(DRAWN, SEED)
    assert names == drawn(DRAWN, SEED) != drawn(DRAWN, SEED + 1)
    assert len(set(names)) == DRAWN


def test_two_miss_a_should_where_one_does() -> None:
    pair = find_deviation("foreign-abort-ignored+new-initiate-refused")
    assert pair is not None
    assert pair.soft


@pytest.mark.parametrize(
    ("verdicts", "problem"),
    [
        ({}, "NO CASES: exit code 0"),
        ({"a": Verdict.PASS}, ""),
        ({"a": Verdict.NON_STRICT}, "FALSE ALARM: a"),
        ({"a": Verdict.PASS, "b": Verdict.FAIL}, "FALSE ALARM: b"),
    ],
)
def test_a_pair_is_right_when_it_fails_nothing(verdicts: dict[str, Verdict], problem: str) -> None:
    run = Run("foreign-abort-ignored+no-empty-values", verdicts=verdicts)
    assert problem_with_pair(run) == problem


def test_a_pair_with_a_missed_should_may_miss_it() -> None:
    verdicts = {"a": Verdict.NON_STRICT}
    run = Run("foreign-abort-ignored+new-initiate-refused", verdicts=verdicts)
    assert problem_with_pair(run) == ""


def test_a_number_that_counts_is_not_written_by_what_is_refused_next_to_it() -> None:
    run = run_cases("rw-values-count-now-and-then", "-k", "number-too and not-indicated")
    assert run.verdicts
    assert run.failed() == []


def test_a_string_that_takes_one_length_alone_is_sent_no_other_at_random() -> None:
    run = run_cases("values-of-fixed-length-64", "-k", "random.interrupted")
    assert run.verdicts
    assert run.failed() == []
