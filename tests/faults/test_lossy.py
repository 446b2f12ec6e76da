"""An adapter that loses, repeats or swaps frames fails no device, and no run is green by it."""

import pytest
from lossy import run_lossy

from conformance.plugin.exit_code import ExitCode
from conformance.run.verdict import Verdict

SOME = ("-k", "segmented_upload and size and not foreign")


def test_what_does_not_fail_again_is_told_and_fails_no_device() -> None:
    told = []
    for seed in (1, 3, 4):
        run, mishaps = run_lossy(300, seed, *SOME)
        assert mishaps
        assert run.failed(strict=True) == []
        assert Verdict.PASS in run.verdicts.values()
        told.append((run.exit_code, run.output))
    # Some mishaps spoil nothing, and some come before the first case.
    assert any(
        status == ExitCode.BENCH_ERROR
        and "the case failed once, but not when it was repeated" in output
        and "the interface counted no lost frames" in output
        for status, output in told
    )


def test_nothing_is_said_where_nothing_was_lost() -> None:
    run, mishaps = run_lossy(10**9, 1, *SOME)
    assert (mishaps, run.exit_code, run.failed(strict=True)) == (0, 0, [])
    assert "bench:" not in run.output


@pytest.mark.parametrize(
    ("fault", "caught_by"),
    [
        ("identity-count-wrong", "upload.identity"),
        ("upload-offset-8-bit", "segmented-upload.size[257]"),
    ],
)
def test_a_fault_is_found_all_the_same(fault: str, caught_by: str) -> None:
    run, _ = run_lossy(1000, 1, "-k", caught_by.partition("[")[0], fault=fault)
    assert any(case.startswith(caught_by) for case in run.failed())
