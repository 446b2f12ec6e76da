"""Known deviations, as a table: what was found, what is listed, what becomes of it."""

import pytest

from conformance.device.known_deviations import NO_REASON, Deviation
from conformance.run.accounting import account, draft
from conformance.run.verdict import CaseResult, Verdict

LISTED = Deviation("a.case", "ticket 1")
FOR_THE_RULE = Deviation("a.case", "ticket 1", "the.rule")
FOR_ANOTHER = Deviation("a.case", "ticket 1", "another.rule")
ELSEWHERE = Deviation("a.case[8]", "ticket 1")


def result(verdict: Verdict, rule: str = "the.rule", case_id: str = "a.case") -> CaseResult:
    broken = f"{rule}: Its sentence: with a colon." if rule else ""
    return CaseResult(case_id, "service", 5, "MUST", "7.2.4", "", verdict, broken_rule=broken)


@pytest.mark.parametrize(
    ("found", "listed", "strict", "becomes"),
    [
        (Verdict.FAIL, [LISTED], False, Verdict.KNOWN_DEVIATION),
        (Verdict.FAIL, [FOR_THE_RULE], False, Verdict.KNOWN_DEVIATION),
        (Verdict.FAIL, [FOR_ANOTHER], False, Verdict.FAIL),
        (Verdict.FAIL, [ELSEWHERE], False, Verdict.FAIL),
        (Verdict.FAIL, [ELSEWHERE, LISTED], False, Verdict.KNOWN_DEVIATION),
        (Verdict.FAIL, [], False, Verdict.FAIL),
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
    found: Verdict, listed: list[Deviation], strict: bool, becomes: Verdict
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


def test_another_cause_is_told() -> None:
    case = result(Verdict.FAIL)
    account(case, [FOR_ANOTHER], strict=False)
    assert case.notes == [
        "listed as a known deviation from another.rule (ticket 1), which does not excuse the.rule"
    ]


def test_a_stale_entry_says_what_to_do() -> None:
    case = result(Verdict.PASS, rule="")
    account(case, [LISTED], strict=False)
    assert "ticket 1" in case.expected
    assert "delete its entry" in case.actual


def test_a_draft() -> None:
    excused = result(Verdict.FAIL, case_id="excused")
    account(excused, [Deviation("excused", "ticket 7")], strict=False)
    results = [
        result(Verdict.FAIL, "one.rule", "failed"),
        result(Verdict.NON_STRICT, "soft.rule", "soft"),
        result(Verdict.FAIL, "", "own"),
        result(Verdict.FAIL, "one.rule", "two-causes"),
        result(Verdict.FAIL, "other.rule", "two-causes"),
        *(
            result(verdict, case_id=verdict.value)
            for verdict in (Verdict.PASS, Verdict.BENCH_ERROR, Verdict.STALE, Verdict.INFO)
        ),
        excused,
    ]
    drafted = [
        Deviation("failed", NO_REASON, "one.rule"),
        Deviation("own", NO_REASON),
        Deviation("two-causes", NO_REASON),
        Deviation("excused", "ticket 7", "the.rule"),
    ]
    assert draft(results, strict=False) == drafted
    assert Deviation("soft", NO_REASON, "soft.rule") in draft(results, strict=True)
