"""The table of services at the end of a run."""

from collections import Counter

from reporting_results import result

from conformance.reporting.service_table import Row, service_rows
from conformance.run.verdict import Verdict

RESULTS = [
    result(service="abort"),
    result(service="nmt"),
    result(Verdict.NOT_TESTABLE, service="nmt"),
    result(Verdict.FAIL, service="matrix"),
    result(Verdict.FAIL, service="upload"),
    result(Verdict.FAIL, service="upload"),
    result(service="upload"),
]


def test_services_with_failures_come_first_and_the_others_share_a_row() -> None:
    assert service_rows(RESULTS, whole=False) == [
        Row("upload", Counter({Verdict.FAIL: 2, Verdict.PASS: 1})),
        Row("matrix", Counter({Verdict.FAIL: 1})),
        Row("2 others", Counter({Verdict.PASS: 2, Verdict.NOT_TESTABLE: 1})),
        Row("all", Counter({Verdict.FAIL: 3, Verdict.PASS: 3, Verdict.NOT_TESTABLE: 1})),
    ]


def test_the_whole_table() -> None:
    rows = service_rows(RESULTS, whole=True)
    assert [row.name for row in rows] == ["upload", "matrix", "abort", "nmt", "all"]


def test_a_single_other_has_its_name_and_a_single_service_no_sum() -> None:
    rows = service_rows(RESULTS[3:] + RESULTS[:1], whole=False)
    assert [row.name for row in rows] == ["upload", "matrix", "abort", "all"]
    assert [row.name for row in service_rows(RESULTS[:1], whole=False)] == ["abort"]
