"""A draft of known deviations: one entry for a cause, and the list of a run excuses that run."""

import pytest

from conformance.device.known_deviations import NO_REASON, KnownDeviation
from conformance.run.drafting import draft
from conformance.run.known_failures import account, stale_entries
from conformance.run.verdict import CaseResult, Verdict
from conformance.sdo.rules import Cause


def result(
    case_id: str, verdict: Verdict = Verdict.FAIL, cause: str = "the.rule: no answer"
) -> CaseResult:
    rule, _, answer = cause.partition(": ")
    made = CaseResult(case_id, "service", 5, "MUST", "7.2.4", "", verdict)
    made.cause = Cause(rule, answer) if rule else None
    made.broken_rule = "" if verdict is Verdict.NOT_TESTABLE else rule
    return made


def copies(results: list[CaseResult]) -> list[CaseResult]:
    """What the accounting may write into."""
    return [CaseResult.from_dict(each.as_dict()) for each in results]


ONE = [result("a.case")]
VARIATIONS = [result("a.case[8]"), result("a.case[9]"), result("a.case[10]")]
SERVICES = [result("block-download.size[1]"), result("block-upload.size[1]")]
NOTHING_IN_COMMON = [result("download.size"), result("upload.size")]
KEPT_AWAY = [result("a.case"), result("a.other", Verdict.NOT_TESTABLE)]
KEPT_FAR_AWAY = [result("a.case"), result("b.other", Verdict.NOT_TESTABLE)]
TWO_CAUSES = [
    *VARIATIONS,
    result("a.case[11]", cause="other.rule: abort"),
    result("b.case", cause="other.rule: abort"),
]
TWO_KINDS = [
    *VARIATIONS,
    result("x", cause="the.rule: abort"),
    result("y", cause="the.rule: abort"),
]
TWO_DEVICES = [result("a.case"), result("a.case", cause="other.rule: abort")]


@pytest.mark.parametrize(
    ("found", "drafted"),
    [
        (ONE, [KnownDeviation("a.case", NO_REASON, "the.rule")]),
        (VARIATIONS, [KnownDeviation("a.case[*", NO_REASON, "the.rule")]),
        (SERVICES, [KnownDeviation("block-*", NO_REASON, "the.rule")]),
        (NOTHING_IN_COMMON, [KnownDeviation(None, NO_REASON, "the.rule")]),
        (KEPT_AWAY, [KnownDeviation("a.*", NO_REASON, "the.rule")]),
        (KEPT_FAR_AWAY, [KnownDeviation(None, NO_REASON, "the.rule")]),
        (
            TWO_CAUSES,
            [
                KnownDeviation("a.case[*", NO_REASON, "the.rule"),
                KnownDeviation(None, NO_REASON, "other.rule"),
            ],
        ),
        (TWO_KINDS, [KnownDeviation(None, NO_REASON, "the.rule")]),
        (
            TWO_DEVICES,
            [
                KnownDeviation("a.case", NO_REASON, "the.rule"),
                KnownDeviation("a.case", NO_REASON, "other.rule"),
            ],
        ),
    ],
)
def test_an_entry_for_each_cause(found: list[CaseResult], drafted: list[KnownDeviation]) -> None:
    assert draft(found, strict=False) == drafted


def test_a_cause_that_other_cases_have_stepped_round() -> None:
    other = result("b.other", Verdict.PASS, cause="")
    other.met = [Cause("the.rule", "no answer")]
    assert draft([result("a.case"), other], strict=False) == [
        KnownDeviation(None, NO_REASON, "the.rule")
    ]


def test_what_is_known_is_kept_as_it_is() -> None:
    known = [
        KnownDeviation("excused", "ticket 7", "the.rule"),
        KnownDeviation("a.*", "ticket 8", "the.rule"),
        KnownDeviation("a.*", "ticket 9", "other.rule"),
        KnownDeviation(None, "ticket 10", "beside.rule"),
    ]
    results = copies([result("excused"), *VARIATIONS, result("new")])
    for each in results:
        account(each, known, strict=False)
    drafted = draft(results, known, strict=False, beside=["beside.rule"])
    assert drafted == [known[0], known[1], known[3], KnownDeviation("new", NO_REASON, "the.rule")]


def test_a_case_with_another_cause_on_another_device() -> None:
    """A list holds a case once for each rule."""
    known = [KnownDeviation("a.case", "ticket 7", "the.rule")]
    results = [result("a.case"), result("a.case", cause="other.rule: abort")]
    for each in results:
        account(each, known, strict=False)
    other = KnownDeviation("a.case", NO_REASON, "other.rule")
    assert draft(results, known, strict=False) == [*known, other]


def test_what_was_not_judged_is_not_drafted() -> None:
    verdicts = set(Verdict) - {Verdict.FAIL, Verdict.NON_STRICT}
    assert draft([result(f"a.{each}", each) for each in sorted(verdicts)], strict=False) == []


def test_what_misses_a_should_counts_with_strict() -> None:
    soft = [result("soft", Verdict.NON_STRICT)]
    assert draft(soft, strict=False) == []
    assert draft(soft, strict=True) == [KnownDeviation("soft", NO_REASON, "the.rule")]


def test_a_test_of_the_users_own_is_listed_by_itself() -> None:
    own = [result("test_mine", cause=""), result("test_other", cause="")]
    assert draft(own, strict=False) == [
        KnownDeviation("test_mine", NO_REASON),
        KnownDeviation("test_other", NO_REASON),
    ]


@pytest.mark.parametrize(
    "found",
    [ONE, VARIATIONS, SERVICES, NOTHING_IN_COMMON, KEPT_AWAY, TWO_CAUSES, TWO_KINDS, TWO_DEVICES],
)
def test_a_draft_excuses_its_run(found: list[CaseResult]) -> None:
    again = copies(found)
    drafted = draft(again, strict=False)
    for each in again:
        account(each, drafted, strict=False)
    assert not [each for each in again if each.verdict is Verdict.FAIL]
    assert stale_entries(drafted, again) == []
