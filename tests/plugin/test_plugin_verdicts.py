"""From a verdict to what pytest says: passed, failed, skipped, and what stands beside it."""

import pytest
from plugin_runs import self_test

pytest_plugins = ["pytester"]

SOFT = ("--sdo-fault=answers-extended", "-k", "frame.extended-ignored")


def counts(result: pytest.RunResult) -> dict[str, int]:
    """Return the outcomes of a run without those that were not selected."""
    outcomes = result.parseoutcomes()
    outcomes.pop("deselected", None)
    return outcomes


def test_what_should_be_and_is_not_passes_and_is_shown(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *SOFT, "-v")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(
        [
            "*extended-ignored NON-STRICT *",
            "1 non-strict",
            "non-strict: frame.extended-ignored: upload initiate response 1018h:01, *",
            "=* deselected, 1 non-strict in *=",
        ]
    )


def test_strict_fails_what_should_be_and_is_not(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *SOFT, "--strict")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert counts(result) == {"failed": 1}
    result.stdout.fnmatch_lines(
        ["frame.extended-ignored: NON-STRICT (SHOULD, *", "  expected: no answer"]
    )


def test_strict_leaves_a_device_that_is_right_alone(pytester: pytest.Pytester) -> None:
    """It is pytest's own option, which is strict about other things as well."""
    result = self_test(pytester, "--strict", "-k", "abort.frame or specifier.block-upload")
    assert result.ret == pytest.ExitCode.OK
    assert counts(result) == {"passed": 6}


def test_a_fault_that_breaks_a_must_fails_without_strict(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--sdo-fault=answers-remote", "-k", "frame.remote")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert "failed" in counts(result)


def test_what_is_not_implemented_is_skipped_with_the_refusal(pytester: pytest.Pytester) -> None:
    without = "--sdo-fault=no-block-transfer"
    result = self_test(pytester, without, "-k", "specifier.block-upload", "-rs")
    assert result.ret == pytest.ExitCode.OK
    assert counts(result) == {"skipped": 5}
    result.stdout.fnmatch_lines(
        [
            "5 unimplemented",
            "SKIPPED [[]2[]] *test_specifiers.py:*: unimplemented: abort 1000h:00, 05040001h *",
        ]
    )


def test_what_cannot_be_tested_is_skipped_and_says_what_to_add(pytester: pytest.Pytester) -> None:
    lacking = "test_expedited_download and (stored or download.text or write-only)"
    result = self_test(pytester, "--sdo-object=2001=unsigned8", "-k", lacking, "-rs")
    assert result.ret == pytest.ExitCode.OK
    assert counts(result)["skipped"] == 8
    result.stdout.fnmatch_lines_random(
        [
            "1 pass, 8 not testable",
            "not testable (4 cases): needs a writable string or domain: *=visible_string (*",
            "not testable (1 case): needs a writable number of 2 bytes: *=2001=unsigned16 (*",
            "not testable (1 case): needs a write-only object: *object=2020=unsigned32,wo (*",
            "SKIPPED [[]1[]] *: not testable: needs a writable number of 2 bytes: *",
        ]
    )


def test_what_is_only_recorded_passes_and_is_shown(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        test_mine="""
        def test_mine(sdo):
            sdo.info("answers in segments")
        """
    )
    result = self_test(pytester, "test_mine.py", "-v")
    assert result.ret == pytest.ExitCode.OK
    assert counts(result) == {"info": 1}
    result.stdout.fnmatch_lines(["*test_mine INFO *", "info: test_mine: answers in segments"])


@pytest.mark.parametrize(
    ("fault", "case", "afterwards"),
    [
        ("unknown-specifier-ignored", "specifier.unknown[E0h]", "idle"),
        ("download-empty-hangs", "segmented-download.empty", "idle"),
        ("unknown-specifier-halts", "specifier.unknown[FFh]", "lost"),
    ],
)
def test_how_the_device_was_left_is_said(
    pytester: pytest.Pytester, fault: str, case: str, afterwards: str
) -> None:
    name, _, label = case.rstrip("]").partition("[")
    chosen = f"{name} and {label} and not over" if label else f"{name} and not last"
    server = (f"--sdo-fault={fault}", "--sdo-response-timeout=0.1")
    result = self_test(pytester, *server, "-k", chosen)
    result.stdout.fnmatch_lines([f"  afterwards: {afterwards}"])


# What came too late, or beside the point of every case, is judged at the end of the run

LATE = "late response after abort.not-answered[[]timed-out]: *585#8018100100000008*"


@pytest.mark.parametrize(
    "chosen",
    [
        "abort",
        "abort.not-answered",
        "timed-out",
        "timed-out or run.reserved",
        "timed-out or run.filler",
    ],
)
def test_a_late_answer_fails_a_run_whose_cases_passed(
    pytester: pytest.Pytester, chosen: str
) -> None:
    """Also when the case that judges it is not selected, and when no case follows."""
    result = self_test(pytester, "--sdo-fault=answers-late", "-k", chosen)
    assert "failed" not in result.parseoutcomes()
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines([LATE])


def test_a_late_answer_fails_the_case_about_it(pytester: pytest.Pytester) -> None:
    chosen = "timed-out or run.no-late-response or abort.frame"
    result = self_test(pytester, "--sdo-fault=answers-late", "-k", chosen)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert counts(result) == {"failed": 1, "passed": 2}
    result.stdout.fnmatch_lines(["*the first (abort.not-answered[[]timed-out]):*"])
    result.stdout.no_fnmatch_line("late response after*")


def test_what_was_met_before_the_cases_fails_the_case_about_it(pytester: pytest.Pytester) -> None:
    server = ("--sdo-fault=every-abort-answered", "--sdo-simulated")
    result = self_test(pytester, *server, "-k", "abort.frame or run.outside-the-cases")
    assert counts(result) == {"failed": 1, "passed": 1}
    result.stdout.fnmatch_lines(["  cause: abort.not-answered: *"])
    result.stdout.no_fnmatch_line("outside the cases, at *")


def test_what_was_met_before_the_cases_fails_a_run_without_that_case(
    pytester: pytest.Pytester,
) -> None:
    server = ("--sdo-fault=every-abort-answered", "--sdo-simulated")
    result = self_test(pytester, *server, "-k", "abort.frame")
    assert counts(result) == {"passed": 1}
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(
        ["outside the cases, at the beginning of the run: abort.not-answered*"]
    )


def test_reserved_bytes_fail_one_case_at_the_end(pytester: pytest.Pytester) -> None:
    """And none of those in which they were seen."""
    fault = "--sdo-fault=download-confirmation-echoes-data"
    result = self_test(pytester, fault, "-k", "download.text or download.stored or run.")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert counts(result)["failed"] == 1
    result.stdout.fnmatch_lines(["FAILED cases/test_whole_run.py::run.reserved *"])
