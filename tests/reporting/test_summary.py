"""What a run says at its end."""

from reporting_results import result

from conformance.reporting.summary import summary_lines
from conformance.run.verdict import Verdict


def test_verdicts_are_counted_and_remarks_told() -> None:
    lack = "needs a writable string or domain: name one"
    results = [
        result(),
        result(),
        result(Verdict.FAIL, case_id="upload.toggle", actual="t=1"),
        result(Verdict.NON_STRICT, case_id="upload.filler", actual="FF in bytes without data"),
        result(Verdict.INFO, case_id="upload.order", notes=["first this", "then that"]),
        result(Verdict.NOT_TESTABLE, case_id="download.a", actual=lack),
        result(Verdict.NOT_TESTABLE, case_id="download.b", actual=lack),
        result(waited=0.5),
        result(waited=0.75),
    ]
    assert summary_lines(results) == [
        "4 pass, 1 non-strict, 1 info, 2 not testable, 1 fail",
        "non-strict: upload.filler: FF in bytes without data",
        "info: upload.order: first this; then that",
        f"not testable (2 cases): {lack}",
        "waited 1.2 s in all for answers that did not come",
    ]


def test_nothing_is_said_of_what_did_not_happen() -> None:
    assert summary_lines([result()]) == ["1 pass"]
