"""Known deviations, as a table: what was found, what is listed, what becomes of it."""

import pytest

from conformance.device.known_deviations import KnownDeviation
from conformance.run.known_failures import account, stale_entries
from conformance.run.verdict import CaseResult, Verdict
from conformance.sdo.rules import Cause

LISTED = KnownDeviation("a.case", "ticket 1")
FOR_THE_RULE = KnownDeviation("a.case", "ticket 1", "the.rule")
FOR_ANOTHER = KnownDeviation("a.case", "ticket 1", "another.rule")
ELSEWHERE = KnownDeviation("a.case[8]", "ticket 1")
GLOB = KnownDeviation("a.*", "ticket 1")
GLOB_FOR_ANOTHER = KnownDeviation("a.*", "ticket 2", "another.rule")
RULE = KnownDeviation(None, "ticket 1", "the.rule")
RULE_OF_THE_CAUSE = KnownDeviation(None, "ticket 1", "a.cause")


def result(verdict: Verdict, rule: str = "the.rule", case_id: str = "a.case") -> CaseResult:
    made = CaseResult(case_id, "service", 5, "MUST", "7.2.4", "", verdict, broken_rule=rule)
    made.cause = Cause("a.cause", "no answer") if rule else None
    made.name = case_id.partition("[")[0]
    made.rules = ["the.rule"] if rule == "the.rule" else []
    return made


@pytest.mark.parametrize(
    ("found", "listed", "strict", "becomes"),
    [
        (Verdict.FAIL, [LISTED], False, Verdict.KNOWN_DEVIATION),
        (Verdict.FAIL, [FOR_THE_RULE], False, Verdict.KNOWN_DEVIATION),
        (Verdict.FAIL, [FOR_ANOTHER], False, Verdict.FAIL),
        (Verdict.FAIL, [ELSEWHERE], False, Verdict.FAIL),
        (Verdict.FAIL, [ELSEWHERE, LISTED], False, Verdict.KNOWN_DEVIATION),
        (Verdict.FAIL, [], False, Verdict.FAIL),
        (Verdict.FAIL, [GLOB], False, Verdict.KNOWN_DEVIATION),
        (Verdict.FAIL, [GLOB_FOR_ANOTHER], False, Verdict.FAIL),
        (Verdict.FAIL, [RULE], False, Verdict.KNOWN_DEVIATION),
        (Verdict.FAIL, [RULE_OF_THE_CAUSE], False, Verdict.KNOWN_DEVIATION),
        (Verdict.FAIL, [FOR_ANOTHER, GLOB], False, Verdict.KNOWN_DEVIATION),
        (Verdict.PASS, [GLOB], False, Verdict.PASS),
        (Verdict.PASS, [RULE], False, Verdict.PASS),
        (Verdict.INFO, [RULE], False, Verdict.INFO),
        (Verdict.NON_STRICT, [LISTED], False, Verdict.NON_STRICT),
        (Verdict.NON_STRICT, [LISTED], True, Verdict.KNOWN_DEVIATION),
        (Verdict.NON_STRICT, [FOR_ANOTHER], True, Verdict.NON_STRICT),
        (Verdict.PASS, [LISTED], False, Verdict.STALE),
        (Verdict.PASS, [FOR_ANOTHER], False, Verdict.STALE),
        (Verdict.PASS, [ELSEWHERE], False, Verdict.PASS),
        (Verdict.INFO, [LISTED], False, Verdict.STALE),
        (Verdict.UNIMPLEMENTED, [LISTED], False, Verdict.UNIMPLEMENTED),
        (Verdict.NOT_TESTABLE, [LISTED], False, Verdict.NOT_TESTABLE),
        (Verdict.BENCH_ERROR, [LISTED], False, Verdict.BENCH_ERROR),
        (Verdict.BENCH_ERROR, [LISTED], True, Verdict.BENCH_ERROR),
    ],
)
def test_accounting(
    found: Verdict, listed: list[KnownDeviation], strict: bool, becomes: Verdict
) -> None:
    case = result(found)
    account(case, listed, strict=strict)
    assert case.verdict is becomes
    assert case.reason == ("ticket 1" if becomes is Verdict.KNOWN_DEVIATION else "")


def test_a_test_of_the_users_own_that_failed_by_itself() -> None:
    case = result(Verdict.FAIL, rule="")
    verdicts = []
    for listed in (FOR_THE_RULE, LISTED):
        account(case, [listed], strict=False)
        verdicts.append(case.verdict)
    assert verdicts == [Verdict.FAIL, Verdict.KNOWN_DEVIATION]


@pytest.mark.parametrize("listed", [LISTED, GLOB])
def test_without_a_rule_only_what_the_case_tests_is_excused(listed: KnownDeviation) -> None:
    case = result(Verdict.FAIL, rule="some.other-rule")
    account(case, [listed], strict=False)
    assert case.verdict is Verdict.FAIL
    own = result(Verdict.FAIL, rule="a.case")
    account(own, [listed], strict=False)
    assert own.verdict is Verdict.KNOWN_DEVIATION, "the case is a rule itself"


def test_another_cause_is_told() -> None:
    case = result(Verdict.FAIL)
    account(case, [FOR_ANOTHER], strict=False)
    assert case.notes == [
        "listed as a known deviation from another.rule (ticket 1), which does not excuse the.rule: "
        'if that is known as well, list it with rule = "the.rule"'
    ]


def test_a_stale_entry_says_what_to_do() -> None:
    case = result(Verdict.PASS, rule="")
    account(case, [LISTED], strict=False)
    assert "ticket 1" in case.expected
    assert "delete its entry" in case.actual


def test_the_narrowest_entry_counts() -> None:
    wide, narrow = KnownDeviation("a.*", "wide"), KnownDeviation("a.case", "narrow")
    for listed in (
        [wide, narrow],
        [narrow, wide],
        [KnownDeviation(None, "rule", "the.rule"), wide],
    ):
        case = result(Verdict.FAIL)
        account(case, listed, strict=False)
        assert case.reason == ("narrow" if narrow in listed else "wide")


FAILS = result(Verdict.FAIL)
KNOWN = result(Verdict.KNOWN_DEVIATION)
PASSES = result(Verdict.PASS, rule="")
PASSES_TOO = result(Verdict.PASS, rule="", case_id="a.case[8]")
ELSEWHERE_PASSES = result(Verdict.PASS, rule="", case_id="the.rule[1]")
SKIPPED = result(Verdict.UNIMPLEMENTED, rule="")
KEPT_AWAY = result(Verdict.NOT_TESTABLE)
NOT_REACHED = result(Verdict.NOT_RUN, rule="", case_id="a.case[9]")


@pytest.mark.parametrize(
    ("known", "found", "stale"),
    [
        (GLOB, [PASSES, PASSES_TOO], True),
        (GLOB, [PASSES, KNOWN], False),
        (GLOB, [PASSES, SKIPPED], True),
        (GLOB, [SKIPPED], False),
        (GLOB, [ELSEWHERE_PASSES], False),
        (GLOB, [PASSES, NOT_REACHED], False),
        (GLOB, [PASSES, KEPT_AWAY], False),
        (GLOB_FOR_ANOTHER, [PASSES, FAILS], True),
        (GLOB_FOR_ANOTHER, [PASSES, KNOWN], True),
        (RULE, [ELSEWHERE_PASSES, PASSES], True),
        (RULE, [ELSEWHERE_PASSES, KNOWN], False),
        (RULE, [PASSES], True),
        (LISTED, [PASSES], False),
    ],
)
def test_an_entry_that_excuses_nothing(
    known: KnownDeviation, found: list[CaseResult], stale: bool
) -> None:
    """Entries for one case are judged with it; those for several when all of them were run."""
    assert stale_entries([known], found) == ([known] if stale else [])


def test_a_selection_says_nothing_of_what_it_leaves_out() -> None:
    assert stale_entries([GLOB], [PASSES]) == [GLOB]
    assert stale_entries([GLOB], [PASSES], partly=[str(GLOB)]) == []


def test_a_rule_alone_is_for_what_is_met_beside_the_cases() -> None:
    assert stale_entries([RULE, GLOB], [ELSEWHERE_PASSES, PASSES], beside=["the.rule"]) == [GLOB]


def test_a_rule_that_any_case_may_break_is_about_all_of_them() -> None:
    anywhere = KnownDeviation(None, "ticket 1", "response.answered")
    tests_it = result(Verdict.PASS, rule="", case_id="response.answered")
    assert stale_entries([anywhere], [tests_it]) == [anywhere]
    assert stale_entries([anywhere], [tests_it, NOT_REACHED]) == []
    assert stale_entries([RULE], [ELSEWHERE_PASSES, NOT_REACHED]) == [RULE]
