"""Each choice that a server may make passes where it shows: what unusual servers do, by cases."""

import pytest
from case_runs import run_cases
from detection import SERVER_TIMEOUT

from conformance.run.verdict import Verdict

LOST = ("-k", "block-download.lost or block-download.old-numbers or random.block")
RESTARTS = ("-k", "new-initiate or restart or random or matrix.segmented-upload-first")
ENDS = ("-k", "crc or unused or acknowledges or block-size or random.any-frames")
CHOICES = {
    "last-block-size-ignored": ENDS,
    "block-frames-called-not-valid": ENDS,
    "superseded-transfer-aborted": RESTARTS,
    "late-segment-taken": LOST,
    "late-segment-aborts": LOST,
    "gap-acknowledged-at-once-then-waits": LOST,
    "lost-first-segment-never-acknowledged": LOST,
    "gap-acknowledged-by-time-out": LOST,
}


@pytest.mark.parametrize("name", CHOICES)
def test_choice_passes(name: str) -> None:
    run = run_cases(name, *CHOICES[name])
    assert run.verdicts
    assert not run.failed(), run.output


# They refuse what begins in the middle of another transfer, end that aloud, keep a part of what was
# aborted, or have room for none of the states of uploads.
PASSED_THROUGH = (
    "superseded-transfer-aborted",
    "new-initiate-in-block-refused",
    "string-keeps-part-of-aborted-write",
    "strings-of-4-bytes",
)


@pytest.mark.parametrize("name", PASSED_THROUGH)
def test_choice_passes_through_pairs_of_states(name: str) -> None:
    run = run_cases(name, "pairs", "-k", "then-block-upload-initiated or then-idle")
    assert len(run.verdicts) == 2 * (15 + 11)
    assert not run.failed(strict=True), run.output
    assert Verdict.PASS in run.verdicts.values()


def test_gap_is_waited_for_as_long_as_is_declared() -> None:
    chosen = ("-k", "block-download.lost and not twice and not later", SERVER_TIMEOUT)
    run = run_cases("gap-acknowledged-by-time-out", *chosen, simulated=False)
    assert list(run.verdicts.values()) == [Verdict.PASS] * 3, run.output
