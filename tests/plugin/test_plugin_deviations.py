"""Known deviations in a run: excused as long as they are there, and not a moment longer."""

from pathlib import Path

import pytest
from plugin_runs import NO_HYPOTHESIS, parsed, self_test, the_report

from conformance.device.known_deviations import NO_REASON, KnownDeviation, read_deviations
from conformance.plugin.exit_code import ExitCode

pytest_plugins = ["pytester"]

WRONG = ("--sdo-fault=identity-count-wrong", "-k", "upload.identity")
LISTED = KnownDeviation("upload.identity", "ticket 1: the count is wrong before release 2")


def listing(pytester: pytest.Pytester, *deviations: KnownDeviation) -> str:
    """Write a list; return the option that names it."""
    lines = []
    for deviation in deviations:
        lines += ["[[deviations]]", f"reason = '{deviation.reason}'"]
        lines += [f"case = '{deviation.case}'"] if deviation.case else []
        lines += [f"rule = '{deviation.rule}'"] if deviation.rule else []
    (pytester.path / "known.toml").write_text("\n".join(lines), encoding="utf-8")
    return "--sdo-deviations=known.toml"


def skipped(report: Path) -> list[str]:
    """Return the messages of what was skipped."""
    return [element.attrib["message"] for element in parsed(report).iter("skipped")]


def test_what_is_listed_may_fail(pytester: pytest.Pytester) -> None:
    arguments = (*WRONG, listing(pytester, LISTED), "--junitxml=pytest.xml", "-rx")
    result = self_test(pytester, *arguments)
    assert result.ret == pytest.ExitCode.OK
    assert result.parseoutcomes()["xfailed"] == 1
    result.stdout.fnmatch_lines(
        [
            "1 known deviation",
            "known deviation: upload.identity: ticket 1: *",
            "XFAIL cases/*::upload.identity - ticket 1: *",
        ]
    )
    assert skipped(the_report(pytester) / "junit.xml") == [f"known deviation: {LISTED.reason}"]
    assert skipped(pytester.path / "pytest.xml") == [LISTED.reason]


def test_also_in_a_worker(pytester: pytest.Pytester) -> None:
    nodes = ("--node-id=5,9", "-n", "2", "-p", "no:cacheprovider", "--sdo-report-dir=left behind")
    options = ("--self-test", *WRONG, *nodes, listing(pytester, LISTED))
    result = pytester.runpytest_subprocess(*NO_HYPOTHESIS, *options)
    assert result.ret == pytest.ExitCode.OK
    assert result.parseoutcomes() == {"xfailed": 2}


def test_what_passes_must_not_be_listed(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "-k", "upload.identity", listing(pytester, LISTED))
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(
        ["upload.identity: STALE DEVIATION *", "*the case passes: delete its entry*"]
    )
    (failure,) = parsed(the_report(pytester) / "junit.xml").iter("failure")
    assert "delete its entry" in failure.attrib["message"]


def test_another_cause_is_not_excused(pytester: pytest.Pytester) -> None:
    other = KnownDeviation("upload.identity", "ticket 2", "response.frame")
    result = self_test(pytester, *WRONG, listing(pytester, other))
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*listed as a known deviation from response.frame (ticket 2)*"])


def test_a_bench_error_is_not_excused(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        test_mine="""
        from conformance.sdo.layout import Multiplexer

        def test_elsewhere(sdo):
            sdo.download(Multiplexer(0x2222), bytes(2))
        """
    )
    listed = listing(pytester, KnownDeviation("test_elsewhere", "ticket 3"))
    result = self_test(pytester, "test_mine.py", listed)
    assert result.ret == ExitCode.BENCH_ERROR
    result.assert_outcomes(errors=1)


def test_a_lost_device_is_not_excused(pytester: pytest.Pytester) -> None:
    case = "segmented-download.foreign[unknown-FFh]"
    halts = ("--sdo-fault=unknown-specifier-halts", "--sdo-response-timeout=0.1", "-k", case)
    result = self_test(pytester, *halts, listing(pytester, KnownDeviation(case, "ticket 4")))
    assert result.ret == ExitCode.DEVICE_LOST


@pytest.mark.parametrize("workers", [(), ("-n", "2")], ids=["one-process", "workers"])
def test_a_case_that_does_not_exist(pytester: pytest.Pytester, workers: tuple[str, ...]) -> None:
    listed = listing(pytester, KnownDeviation("upload.identiy", "ticket 5"))
    options = ("--self-test", "-p", "no:cacheprovider", "--sdo-report-dir=left behind", *workers)
    result = pytester.runpytest_subprocess(*NO_HYPOTHESIS, *options, listed, "-k", "abort.frame")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: *'upload.identiy'*Did you mean 'upload.identity'?*"])
    assert "passed" not in result.parseoutcomes()


@pytest.mark.parametrize(
    ("known", "said"),
    [
        (
            KnownDeviation("uplaod.identity*", "x"),
            "'uplaod.identity[*]'*Did you mean 'upload.identity'?",
        ),
        (
            KnownDeviation(None, "x", "upload.identiy"),
            "'upload.identiy'*Did you mean 'upload.identity'?",
        ),
    ],
    ids=["glob", "rule"],
)
def test_cases_or_a_rule_that_do_not_exist(
    pytester: pytest.Pytester, known: KnownDeviation, said: str
) -> None:
    result = self_test(pytester, listing(pytester, known), "-k", "abort.frame")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"ERROR: *{said}*"])


SEVERAL = [
    KnownDeviation("upload.iden*", "ticket 6"),
    KnownDeviation("upload.iden*", "ticket 6", "upload.identity"),
    KnownDeviation(None, "ticket 6", "upload.identity"),
]


@pytest.mark.parametrize("known", SEVERAL, ids=str)
def test_an_entry_for_several_cases(pytester: pytest.Pytester, known: KnownDeviation) -> None:
    """It excuses what it is about; what excuses nothing has to go."""
    result = self_test(pytester, *WRONG, listing(pytester, known))
    assert result.ret == pytest.ExitCode.OK
    assert result.parseoutcomes()["xfailed"] == 1
    result = self_test(pytester, "-k", "upload.identity", listing(pytester, known))
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines([f"stale deviation: {known} (ticket 6) excused no failure *"])


@pytest.mark.parametrize("known", SEVERAL, ids=str)
def test_an_entry_for_several_cases_that_were_not_selected(
    pytester: pytest.Pytester, known: KnownDeviation
) -> None:
    listed = listing(pytester, known)
    result = self_test(pytester, "-k", "abort.frame", listed)
    assert result.ret == pytest.ExitCode.OK
    result.stdout.no_fnmatch_line("stale deviation*")
    pytester.makepyfile(test_mine="def test_reads(sdo):\n    sdo.fence()")
    assert self_test(pytester, "test_mine.py", listed).ret == pytest.ExitCode.OK


def test_stale_in_workers(pytester: pytest.Pytester) -> None:
    nodes = ("--node-id=5,9", "-n", "2", "-p", "no:cacheprovider", "--sdo-report-dir=left behind")
    listed = listing(pytester, KnownDeviation("upload.ident*", "ticket 6"))
    for selection, ret in (("upload.identity", 1), ("abort.frame", 0)):
        options = ("--self-test", *nodes, listed, "-k", selection)
        assert pytester.runpytest_subprocess(*NO_HYPOTHESIS, *options).ret == ret


def test_a_cause_that_any_case_meets(pytester: pytest.Pytester) -> None:
    """One rule excuses it, in each selection, in the cases and beside them."""
    answers = ("--sdo-fault=every-abort-answered", "--sdo-simulated", "--sdo-response-timeout=0.1")
    known = KnownDeviation(None, "ticket 8", "abort.not-answered")
    for selection in ("upload.identity or upload.size", "abort.not-answered"):
        result = self_test(pytester, *answers, "-k", selection, listing(pytester, known))
        assert result.ret == pytest.ExitCode.OK, selection


def test_a_case_that_was_not_selected(pytester: pytest.Pytester) -> None:
    assert self_test(pytester, "-k", "abort.frame", listing(pytester, LISTED)).ret == 0


def test_a_list_that_cannot_be_read(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--sdo-deviations=none.toml")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: *none.toml: the file cannot be read*"])


def test_a_draft_from_a_run(pytester: pytest.Pytester) -> None:
    """It serves at once, and says that it is not done."""
    result = self_test(pytester, *WRONG, "--sdo-write-deviations=draft.toml")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    (drafted,) = read_deviations(pytester.path / "draft.toml")
    assert drafted == KnownDeviation("upload.identity", NO_REASON, "upload.identity")
    result = self_test(pytester, *WRONG, "--sdo-deviations=draft.toml")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(["known deviations without a reason: 1; *"])


def test_pytests_own_way_to_look_behind_it(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *WRONG, listing(pytester, LISTED), "--runxfail")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
