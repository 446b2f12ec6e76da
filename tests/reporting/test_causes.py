"""The causes at the end of a run: each with its cases, most cases first."""

from dataclasses import replace

from reporting_results import cause_of, result

from conformance.reporting.cause_counts import cause_lines, counted_causes
from conformance.run.trace import TraceLine
from conformance.run.verdict import Verdict

ECHO = "abort.not-answered: an answer"
TOGGLE = "upload-segment.toggle: t=…"
FILLER = "response.filler: other data"


def test_most_cases_first_and_each_says_where_it_was_met_first() -> None:
    results = [
        result(Verdict.FAIL, case_id="upload.toggle", cause=TOGGLE),
        result(Verdict.FAIL, case_id="abort.frame", cause=ECHO),
        result(Verdict.NOT_TESTABLE, case_id="abort.mid-transfer", cause=ECHO),
        result(Verdict.NOT_TESTABLE, case_id="abort.timed-out", cause=ECHO),
        result(Verdict.FAIL, case_id="abort.again", cause=ECHO),
        result(case_id="upload.device-type"),
    ]
    causes = counted_causes(results, strict=False)
    assert [str(count.cause) for count in causes] == [ECHO, TOGGLE]
    assert cause_lines(causes, alone=True) == [
        f"{ECHO} (2 cases failed, 2 not testable; first abort.frame)",
        f"{TOGGLE} (1 case failed; first upload.toggle)",
    ]


def test_a_bench_error_is_no_cause_and_neither_is_a_lack() -> None:
    lack = result(Verdict.NOT_TESTABLE, case_id="download.a", actual="needs a writable string")
    assert counted_causes([lack, result(), result(Verdict.INFO)], strict=False) == []


def test_a_cause_that_no_case_failed_for() -> None:
    """It was met outside the cases, or in those that are not in these results."""
    kept = [result(Verdict.NOT_TESTABLE, case_id=f"download.{name}", cause=ECHO) for name in "abc"]
    (line,) = cause_lines(counted_causes(kept, strict=False), alone=True)
    assert line == f"{ECHO} (3 not testable; first download.a)"


def test_what_misses_a_should_is_a_cause_with_strict_only() -> None:
    soft = [result(Verdict.NON_STRICT, case_id="upload.filler", cause=FILLER)]
    assert counted_causes(soft, strict=False) == []
    (line,) = cause_lines(counted_causes(soft, strict=True), alone=True)
    assert line == f"{FILLER} (1 case failed; first upload.filler)"


def test_each_of_many_devices_has_its_own() -> None:
    results = [
        result(Verdict.FAIL, case_id="abort.frame", cause=ECHO, node_id=node_id)
        for node_id in (5, 6, 6)
    ]
    assert cause_lines(counted_causes(results, strict=False), alone=False) == [
        f"node 6: {ECHO} (2 cases failed; first abort.frame)",
        f"node 5: {ECHO} (1 case failed; first abort.frame)",
    ]


def test_the_plainest_failure_shows_a_cause() -> None:
    """Not the first, which breaks another rule as well, or is not about this one."""
    rule = TOGGLE.partition(":")[0]
    other = result(Verdict.FAIL, case_id="a.b", cause=TOGGLE, broken_rule="response.filler")
    beside = result(Verdict.FAIL, case_id="c.d", cause=TOGGLE, broken_rule=rule)
    met = replace(beside, case_id="e.f", rules=[rule], met=list(filter(None, [cause_of(FILLER)])))
    long = replace(beside, case_id="g.h", rules=[rule], trace=[TraceLine("")] * 3)
    plain = replace(beside, case_id="i.j", rules=[rule], trace=[TraceLine("")] * 2)
    (count,) = counted_causes([other, beside, met, long, plain], strict=False)
    assert [case.case_id for case in count.cases] == ["i.j", "g.h", "e.f", "c.d", "a.b"]
