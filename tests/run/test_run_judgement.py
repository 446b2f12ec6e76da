"""What was wrong where the true answer came behind what was taken for it."""

import pytest

from conformance.dialogue.shape_breaches import unasked
from conformance.run.judgement import Point, confirmed_and_refused, crossing
from conformance.run.leaving import Leaving
from conformance.run.verdict import Afterwards
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.describe import in_words
from conformance.sdo.frames import (
    Abort,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import (
    MULTIPLEXER,
    NOT_REFUSED,
    SPECIFIER,
    TOGGLE,
    UNSOLICITED,
    Level,
    Rule,
    Violation,
)
from conformance.sdo.rules.defects import REFUSED_LATE
from conformance.sdo.seen import Received

MUX, OTHER = Multiplexer(0x2010), Multiplexer(0x1018, 1)
READ = UploadInitiate(MUX)
VALUE = UploadInitiateResponse.with_data(MUX, b"\1\2\3\4")
ABORT = Abort(MUX, AbortCode.GENERAL_ERROR)
REFUSED = ServerAborted(ABORT)


# Crossing


def wrong(rule: Rule, actual: str = in_words(ABORT)) -> Violation:
    return Violation(rule, expected="another thing", actual=actual)


@pytest.mark.parametrize(
    "error", [REFUSED, *(wrong(rule) for rule in (SPECIFIER, NOT_REFUSED, MULTIPLEXER))], ids=str
)
def test_what_came_before_the_true_answer_came_unasked(error: Exception) -> None:
    crossed = crossing(error, [VALUE], READ)
    assert crossed is not None
    assert crossed.rule is UNSOLICITED
    assert crossed.expected == "nothing before the answer to: upload initiate 2010h:00"
    assert crossed.actual == in_words(ABORT)


@pytest.mark.parametrize(
    "error", [None, wrong(TOGGLE), wrong(UNSOLICITED), AssertionError("of the user's own")], ids=str
)
def test_what_cannot_be_the_answer_to_something_else_has_crossed_nothing(
    error: Exception | None,
) -> None:
    assert crossing(error, [VALUE], READ) is None


@pytest.mark.parametrize("stray", [ABORT, UploadInitiateResponse.with_data(OTHER, b"\1")])
def test_a_refusal_with_no_answer_behind_it_is_a_refusal(stray: Response) -> None:
    assert crossing(REFUSED, [stray, VALUE], READ) is None


# Points


OWN = Rule("a.case", "7.2.4", Level.MUST, "What the case is about.")


def test_a_case_is_about_its_rule_and_those_that_it_cites() -> None:
    point = Point(OWN, (TOGGLE, SPECIFIER))
    assert point.is_own(OWN)
    assert point.is_own(TOGGLE)
    assert point.is_own(SPECIFIER)
    assert not point.is_own(UNSOLICITED)


def test_causes_name_the_rule_as_the_registry_has_it() -> None:
    """Else the same defect had a cause with each of the cases about it."""
    assert Point(OWN, (TOGGLE, SPECIFIER)).registered(OWN) is TOGGLE
    assert Point(OWN, (TOGGLE,)).registered(SPECIFIER) is SPECIFIER
    assert Point(OWN).registered(OWN) is OWN


# A download that is confirmed and then refused

LAST = DownloadSegment.with_data(b"ABC", toggle=0, last=True)
CONFIRMED = Violation(TOGGLE, expected="an abort", actual=Received(DownloadSegmentResponse(0)))


def test_an_abort_behind_a_confirmation_is_a_cause_of_its_own() -> None:
    found = confirmed_and_refused(CONFIRMED, Leaving(Afterwards.IDLE, stray=[ABORT]), LAST)
    assert found is not None
    assert found.told_as == REFUSED_LATE


@pytest.mark.parametrize(
    ("error", "stray", "asked"),
    [
        (None, ABORT, LAST),
        (REFUSED, ABORT, LAST),
        (CONFIRMED, VALUE, LAST),
        (CONFIRMED, ABORT, DownloadSegment.with_data(b"ABC", toggle=0)),
        (CONFIRMED, ABORT, READ),
    ],
)
def test_what_is_no_abort_behind_a_confirmation(
    error: Exception | None, stray: Response, asked: Request
) -> None:
    assert confirmed_and_refused(error, Leaving(Afterwards.IDLE, stray=[stray]), asked) is None


def test_what_answers_the_abort_of_the_suite_is_none_behind_a_confirmation() -> None:
    answers = Leaving(Afterwards.IDLE, unasked(ABORT, aborted=True), [ABORT])
    assert confirmed_and_refused(CONFIRMED, answers, LAST) is None
