"""One defect of a device is told once: what a case that meets a known cause says of it."""

from collections.abc import Iterator

import pytest
from support.run_bench import (
    RULE,
    TEXT,
    Recording,
    Workbench,
    begin,
    discovered,
    recording,
    violation,
)

from conformance.run.case_run import begin_case
from conformance.run.verdict import Verdict
from conformance.sdo.rules import Level, Rule

OTHER = Rule("another.rule", "7.2.4", Level.MUST, "Another sentence.")


@pytest.fixture
def bench() -> Iterator[Workbench]:
    with discovered(recording()) as opened:
        yield opened


def test_a_cause_outside_the_point_of_cases_fails_the_first_of_them(bench: Workbench) -> None:
    """From then on it is known, and in the way."""
    session = bench.session()
    first = begin(session, "first").conclude(violation(OTHER))
    second = begin(session, "second").conclude(violation(OTHER))
    assert (first.verdict, str(first.cause)) == (Verdict.FAIL, "another.rule: something")
    assert (second.verdict, second.cause) == (Verdict.NOT_TESTABLE, first.cause)
    assert second.actual == (
        "another.rule: something prevents this case, see first: "
        "expected another thing; got something"
    )
    third = begin(session, "third").conclude(violation(OTHER, "quite different"))
    assert third.verdict is Verdict.FAIL


def test_a_case_fails_for_what_it_is_about_however_well_it_is_known(bench: Workbench) -> None:
    session = bench.session()
    for case_id in ("first", "second"):
        assert begin(session, case_id).conclude(violation()).verdict is Verdict.FAIL


def test_what_a_case_cites_is_what_it_is_about(bench: Workbench) -> None:
    session = bench.session()
    for case_id in ("first", "second"):
        run = begin_case(session, case_id, "a service", RULE, (OTHER,))
        result = run.conclude(violation(actual="something"))
        assert (result.verdict, str(result.cause)) == (Verdict.FAIL, "another.rule: something")
        again = begin_case(session, case_id, "a service", RULE, (OTHER,))
        assert again.conclude(violation(OTHER)).verdict is Verdict.FAIL


def test_what_is_generated_need_not_show_the_same_again(bench: Workbench) -> None:
    session = bench.session()
    verdicts = [
        begin_case(session, f"a.case[{number}]", "matrix", RULE, generated=True)
        .conclude(violation())
        .verdict
        for number in range(2)
    ]
    assert verdicts == [Verdict.FAIL, Verdict.NOT_TESTABLE]


def test_a_known_cause_that_stops_nothing_is_told_once(bench: Workbench) -> None:
    session = bench.session()
    verdicts = []
    for case_id in ("first", "second"):
        run = begin(session, case_id)
        run.sdo.note(violation(OTHER))
        verdicts.append(run.conclude(None).verdict)
    assert verdicts == [Verdict.FAIL, Verdict.PASS]


def test_what_passes_needs_no_evidence(bench: Workbench) -> None:
    result = begin(bench.session()).conclude(None)
    assert (result.verdict, result.trace, result.reproduce) == (Verdict.PASS, [], [])


def test_what_the_bench_may_have_caused_does_not_stand(bench: Workbench) -> None:
    """Else it would be in the way of the next case, and nothing would ever fail for it."""
    session = bench.session()
    run = begin(session, "first")
    run.sdo.wire.pauses.missed(2.0)
    run.conclude(violation(OTHER))
    assert begin(session, "second").conclude(violation(OTHER)).verdict is Verdict.FAIL


class _Echoing(Recording):
    """Sends the abort of a transfer back."""

    def receive(self, frame: bytes) -> list[bytes]:
        running = self.transfer is not None
        answers = super().receive(frame)
        return [frame] if running and frame[0] == 0x80 else answers


def test_what_tidying_meets_fails_no_case() -> None:
    """It is a finding of its own, told once."""
    with discovered(recording(_Echoing)) as bench:
        session = bench.session()
        assert session.causes.aside() == []
        run = begin(session)
        run.sdo.initiate_download(TEXT, 14)
        assert run.conclude(None).verdict is Verdict.PASS
        ((cause, standing),) = session.causes.aside()
    assert str(cause) == "abort.not-answered: an answer"
    assert standing.first_case == "a.case"
