"""What counts as found, as reached and as lacking, and what differs from the expectation."""

from dataclasses import replace
from pathlib import Path

from fleet_results import Comparison, Outcome, Row, outcomes
from fleet_servers import ExpectedCause

JUNIT = """\
<testsuites><testsuite>
<testcase name="a"><properties><property name="id" value="upload.a"/>
<property name="verdict" value="pass"/></properties></testcase>
<testcase name="b"><properties><property name="verdict" value="fail"/></properties>
<failure message="expected this; got that">upload.b: FAIL
  broken rule: response.multiplexer: The abort repeats the multiplexer.
</failure></testcase>
<testcase name="c"><properties><property name="verdict" value="fail"/>
<property name="cause" value="frame.short: an answer"/></properties>
<failure message="expected none">broken rule: frame.short: Short.</failure></testcase>
<testcase name="d"><properties><property name="verdict" value="not testable"/></properties>
<skipped message="not testable: name a larger string"/></testcase>
<testcase name="e"><properties><property name="verdict" value="not testable"/>
<property name="cause" value="frame.short: an answer"/></properties>
<skipped message="not testable: frame.short prevents this case"/></testcase>
<testcase name="f"><properties><property name="verdict" value="not run"/></properties>
<skipped message="not run: lost"/></testcase>
<testcase name="g"><properties><property name="verdict" value="unimplemented"/></properties>
<skipped message="unimplemented: abort"/></testcase>
</testsuite></testsuites>
"""


def read(folder: Path) -> list[Outcome]:
    path = folder / "junit.xml"
    path.write_text(JUNIT)
    return list(outcomes(path))


def expected(cause: str) -> ExpectedCause:
    return ExpectedCause(cause, "why", ("> 40", "< 80"))


def test_a_failure_has_the_cause_that_the_run_tells_or_the_broken_rule(tmp_path: Path) -> None:
    causes = {each.case: each.cause for each in read(tmp_path) if each.failed}
    assert causes == {"b": "response.multiplexer", "c": "frame.short: an answer"}


def test_what_the_server_lacks_does_not_count(tmp_path: Path) -> None:
    results = read(tmp_path)
    assert [each.case for each in results if each.lacks] == ["d", "g"]
    assert [each.case for each in results if each.reached] == ["upload.a", "b", "c"]
    row = Row.of("server", results, 12.3)
    assert (row.cases, row.failed, row.causes, row.reached, row.reachable) == (7, 2, 2, 3, 5)
    assert str(row) == "server              7       2       2        3/5  60%     12 s"
    assert len(str(row)) == len(Row.HEADER)


def test_what_a_cause_says_is_lacking_does_not_count_either(tmp_path: Path) -> None:
    missing = ExpectedCause("frame.short: *", "why", (), lacking=True)
    row = Row.of("server", read(tmp_path), 12.3, [missing])
    assert (row.reached, row.reachable) == (3, 4)


def test_what_would_show_no_more_has_reached_its_point() -> None:
    told = "frame.short: an answer was reported before, see frame.short[1]"
    outcome = Outcome("a", "not testable", "frame.short: an answer", told)
    assert outcome.reached


def test_no_case_at_all_is_no_success() -> None:
    assert Row.of("server", [], 0).share == 0


def test_what_is_found_and_judged_is_right(tmp_path: Path) -> None:
    judged = (expected("response.multiplexer"), expected("frame.short: *"))
    comparison = Comparison.of(read(tmp_path), judged)
    assert comparison.right
    assert list(comparison.lines()) == ["  in the way of 1 cases: frame.short: an answer"]


def test_what_is_not_judged_yet_is_told_with_a_case(tmp_path: Path) -> None:
    comparison = Comparison.of(read(tmp_path), [expected("frame.*")])
    assert not comparison.right
    assert list(comparison.lines()) == [
        "  not expected: response.multiplexer (1 cases)",
        "    b: expected this; got that",
        "  in the way of 1 cases: frame.short: an answer",
    ]


def test_what_is_not_found_any_more_is_told(tmp_path: Path) -> None:
    judged = [expected("*"), expected("upload.size: *")]
    comparison = Comparison.of(read(tmp_path), judged)
    assert not comparison.right
    assert "  not found: upload.size: *" in list(comparison.lines())


def test_what_is_met_now_and_then_need_not_be(tmp_path: Path) -> None:
    judged = [expected("response.multiplexer"), expected("frame.short: *")]
    rare = replace(expected("a.rare"), now_and_then=True)
    assert Comparison.of(read(tmp_path), [*judged, rare]).right
    assert not Comparison.of(read(tmp_path), [*judged, expected("a.rare")]).right
