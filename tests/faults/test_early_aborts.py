"""A server may abort a running transfer at any time: now and then is right, each time is not."""

import pytest
from case_runs import run_cases

from conformance.run.verdict import Verdict

VARIANTS = (
    "seventh-transfer-aborted",
    "seventh-transfer-aborted-unasked",
    "seventh-transfer-aborted-in-blocks",
)
CASES = (
    "segmented-upload.size or block-upload.size or block-download.client-abort"
    " or block-download.restart or independence.interleaved"
)


@pytest.mark.parametrize("name", VARIANTS)
def test_abort_now_and_then_passes(name: str) -> None:
    run = run_cases(name, "-k", CASES)
    assert not run.failed(), run.output
    passed = sum(verdict in (Verdict.PASS, Verdict.INFO) for verdict in run.verdicts.values())
    assert passed > 0.95 * len(run.verdicts)


@pytest.mark.parametrize("name", VARIANTS)
def test_random_conversations_pass(name: str) -> None:
    run = run_cases(name, "-k", "random.block-transfers or random.sequences", "--sdo-examples=25")
    assert not run.failed(), run.output


def test_abort_each_time_fails() -> None:
    run = run_cases("aborts-inside-sub-block", "-k", "block-download.size")
    assert run.failed()
