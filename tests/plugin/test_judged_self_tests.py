"""What a run has nothing against, the judge of its log has nothing against either."""

import pytest
from plugin_runs import NODE_ID, self_test, the_report

from conformance.logs.findings import Finding
from conformance.logs.judging import LogJudge
from conformance.logs.reading import RecordedLog

pytest_plugins = ["pytester"]


def _failures(pytester: pytest.Pytester) -> list[str]:
    """Return what was not allowed in the log of the only run so far."""
    judge = LogJudge()
    log = RecordedLog(str(the_report(pytester) / "bus.log"))
    found = [*(each for seen in log for each in judge.take(seen)), *judge.end()]
    assert next(channel for (_, node), channel in judge.channels.items() if node == NODE_ID)
    return [
        f"line {each.seen.number}: {each.violation}"
        for each in found
        if isinstance(each, Finding) and each.is_failure
    ]


@pytest.mark.parametrize(
    ("name", "cases"),
    [
        ("answers-after-900-ms", "abort.frame or download.same-value"),
        ("writes-of-some-objects-take-300-ms", "download.same-value"),
        ("each-segment-of-a-burst-takes-10-ms", "block-download.whole-sub-block"),
        ("stopped-with-an-abort", "nmt.stopped"),
        ("block-upload-early-acknowledgement-starts-over", "block-upload.early"),
        ("seventh-transfer-aborted-unasked", "segmented-upload.toggle"),
        ("emergencies-within-transfers", "abort.own"),
    ],
)
def test_a_right_server_is_right_in_the_log_too(
    pytester: pytest.Pytester, name: str, cases: str
) -> None:
    result = self_test(pytester, "--sdo-simulated", f"--sdo-fault={name}", "-k", cases)
    outcomes = result.parseoutcomes()
    assert outcomes.get("passed", 0) > 0
    assert "failed" not in outcomes
    assert _failures(pytester) == []


@pytest.mark.parametrize("name", ["seventh-transfer-aborted", "seventh-transfer-aborted-crosswise"])
def test_an_abort_for_the_state_of_a_device_may_meet_a_wrong_request(
    pytester: pytest.Pytester, name: str
) -> None:
    assert self_test(pytester, "--sdo-simulated", "--sdo-quick", f"--sdo-fault={name}").ret == 0
    assert _failures(pytester) == []


def test_a_server_that_is_one_request_behind_is_named_alike(pytester: pytest.Pytester) -> None:
    self_test(pytester, "--sdo-simulated", "--sdo-fault=one-request-behind", "-k", "abort.frame")
    (failure,) = _failures(pytester)
    assert "response.answered" in failure
    assert "answers are one request behind" in failure
