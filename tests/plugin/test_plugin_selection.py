"""Which cases a command line runs: all of them from any folder, or what it names."""

from itertools import chain
from pathlib import Path

import pytest
from plugin_runs import case_ids, reference, reports, run, self_test, the_report

from conformance.plugin.selection import read_arguments
from conformance.run.case_files import CASES

pytest_plugins = ["pytester"]

OWN_TEST = """
    def test_mine(sdo):
        sdo.upload(__import__("conformance").device.device.VENDOR_ID)
"""


# Of the matrix one state.
# That all others run and are green shows in the full runs of the installed wheel.
UNREPEATED = "(not test_matrix or matrix.idle) and not test_random and not beyond"


def test_the_self_test_runs_all_cases_and_is_green(pytester: pytest.Pytester) -> None:
    listed = self_test(pytester, "--collect-only", "-q", "-k", UNREPEATED).outlines
    ids = [line.partition("::")[2] for line in listed if line.startswith("cases/")]
    assert len(ids) > 400
    assert len(set(ids)) == len(ids), "an id is a name for one case"
    result = self_test(pytester, "--sdo-simulated", "-k", UNREPEATED)
    assert result.ret == pytest.ExitCode.OK
    outcomes = result.parseoutcomes()
    del outcomes["deselected"]
    assert set(outcomes) == {"passed", "info", "skipped"}
    assert sum(outcomes.values()) == len(ids)
    assert set(case_ids(the_report(pytester) / "junit.xml")) == set(ids)
    result.stdout.fnmatch_lines(
        ["*= conformance =*", "* pass, * info, 14 unimplemented, 23 not testable"]
    )
    lacking = "\n".join(line for line in result.outlines if line.startswith("not testable ("))
    for reason in (
        "declare it with --sdo-server-timeout",
        "1005h:00 is not in use",
        "no emergency of the device was heard",
    ):
        assert lacking.count(reason) == 1


@pytest.mark.parametrize(
    ("argument", "said"),
    [
        ("abort.onw-multiplexer", "'abort.onw-multiplexer'. Did you mean 'abort.own-multiplexer'?"),
        ("upload.identiy[1]", "'upload.identiy[1]'. Did you mean 'upload.identity'?"),
        ("qqqq.wwww", "file or directory not found: qqqq.wwww"),
        ("test_abort.py", "file or directory not found: test_abort.py"),
    ],
)
def test_a_mistyped_case(pytester: pytest.Pytester, argument: str, said: str) -> None:
    result = self_test(pytester, "--sdo-simulated", argument)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert said in result.stdout.str() + result.stderr.str()


@pytest.mark.parametrize(
    "case_id", ["matrix.idle[40h]", "matrix.block-upload-end[dlc-0]", "random.sequences"]
)
def test_a_generated_case_is_named_by_its_id(pytester: pytest.Pytester, case_id: str) -> None:
    result = self_test(pytester, "--sdo-simulated", case_id)
    assert result.ret == pytest.ExitCode.OK
    assert case_ids(the_report(pytester) / "junit.xml") == [case_id]


def test_a_device_is_tested_from_any_folder(pytester: pytest.Pytester) -> None:
    with reference() as options:
        result = run(pytester, *options, "--sdo-allow=read-only-probes", "-k", "abort.own")
    assert result.ret == pytest.ExitCode.OK
    result.assert_outcomes(passed=2, deselected=result.parseoutcomes()["deselected"])
    result.stdout.fnmatch_lines(["..*100%]"])


def test_a_path_runs_only_what_it_names(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=OWN_TEST, test_other="def test_other(): assert False")
    result = self_test(pytester, "test_mine.py")
    result.assert_outcomes(passed=1)
    assert case_ids(the_report(pytester) / "junit.xml") == ["test_mine"]


def test_a_folder_is_a_path_too(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=OWN_TEST)
    result = self_test(pytester, ".")
    result.assert_outcomes(passed=1)
    # A user who names a folder need not know that the suite's cases are not in it.
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    result.stdout.fnmatch_lines(["none of the suite's cases was run: to run them with *'cases'*"])


def test_own_tests_and_cases_run_together(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=OWN_TEST)
    result = self_test(pytester, ".", "abort.own")
    assert result.ret == pytest.ExitCode.OK
    ids = case_ids(the_report(pytester) / "junit.xml")
    assert ids[0] == "test_mine"
    assert len(ids) > 1
    assert all(case.startswith("abort.own") for case in ids[1:])


def test_a_run_that_asks_no_device_anything_is_not_green(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("def test_plain(): pass")
    result = self_test(pytester, "test_a_run_that_asks_no_device_anything_is_not_green.py")
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    assert "none of the suite's cases was run" in result.stdout.str()


PRINTED = "cases/test_abort.py::abort.own"
FILE = str(CASES / "test_abort.py")


@pytest.mark.parametrize(
    ("arguments", "paths", "named"),
    [
        ([PRINTED], [FILE], ["abort.own"]),
        ([f"{PRINTED}[1]", "abort.own@6[2]"], [FILE], ["abort.own[1]", "abort.own@6[2]"]),
        (["abort.own[a::b/c]"], [FILE], ["abort.own[a::b/c]"]),
        (["abort"], [FILE], ["abort"]),
        (["cases/test_abort.py", "abort.own"], [FILE], []),
        (["abort.own", "cases"], [FILE, str(CASES)], []),
        (["test_mine.py::test_abort", "."], ["test_mine.py::test_abort", "."], []),
        ([f"{FILE}::abort.own"], [f"{FILE}::abort.own"], []),
        (["qqqq.ow"], ["qqqq.ow"], []),
        (["cases/test_none.py"], ["cases/test_none.py"], []),
    ],
)
def test_whatever_is_printed_of_a_case_can_be_an_argument(
    arguments: list[str], paths: list[str], named: list[str], tmp_path: Path
) -> None:
    (tmp_path / "test_mine.py").touch()
    found, cases = read_arguments(arguments, tmp_path)
    assert found == paths
    assert list(chain.from_iterable(cases.values())) == named


def test_a_folder_of_the_users_own_is_his(tmp_path: Path) -> None:
    (tmp_path / "cases").mkdir()
    (tmp_path / "cases" / "test_abort.py").touch()
    assert read_arguments([PRINTED], tmp_path) == ([PRINTED], {})


def test_ids_as_they_are_printed_run_these_cases_and_no_other(pytester: pytest.Pytester) -> None:
    def listed(*arguments: str) -> list[str]:
        lines = self_test(pytester, "--collect-only", "-q", *arguments).outlines
        return [line for line in lines if "::" in line]

    printed = listed("segmented-upload.toggle")
    assert len(printed) > 2
    assert listed(*printed[:2]) == printed[:2]
    assert listed(*[line.partition("::")[2] for line in printed[-2:]]) == printed[-2:]
    # What is an id by itself is not taken for the beginning of another.
    (alone,) = listed("abort.own-multiplexer")
    assert alone.endswith("::abort.own-multiplexer")


def test_a_file_of_cases_may_be_named(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, str(CASES / "test_whole_run.py"))
    result.assert_outcomes(passed=5)


def test_cases_and_own_tests_together(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=OWN_TEST)
    result = self_test(pytester, "test_mine.py", str(CASES / "test_whole_run.py"))
    result.assert_outcomes(passed=6)


def test_a_case_may_be_named_by_the_id_that_is_shown(pytester: pytest.Pytester) -> None:
    """What -q and the summary print can be pasted behind the file, here in the checkout."""
    result = self_test(pytester, f"{CASES / 'test_abort.py'}::abort.not-answered[code-0]")
    result.assert_outcomes(passed=1)


def test_without_a_device_pytest_is_as_ever(pytester: pytest.Pytester) -> None:
    result = run(pytester)
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    result.stdout.fnmatch_lines(["conformance: no device is named: add --node-id=5 *--self-test"])
    pytester.makepyfile(test_other="def test_other(tmp_path): pass")
    result = run(pytester, "--strict-markers")
    result.assert_outcomes(passed=1)
    result.stdout.no_fnmatch_line("*conformance:*")
    result.stdout.no_fnmatch_line("*= conformance =*")
    assert not reports(pytester).exists()


def test_a_test_that_needs_a_device_says_which_option_names_one(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=OWN_TEST)
    result = run(pytester)
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*name it with --node-id=N, or use --self-test*"])
    result.stdout.no_fnmatch_line("*KeyError*")


def test_k_takes_case_ids(pytester: pytest.Pytester) -> None:
    wanted = "segmented-upload.toggle-first or upload.device-type"
    self_test(pytester, "-k", wanted)
    assert set(case_ids(the_report(pytester) / "junit.xml")) == {
        "upload.device-type",
        "segmented-upload.toggle-first",
    }


def test_nothing_selected(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "-k", "no_such_case")
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    assert not reports(pytester).exists()


def test_x_stops_at_the_first_failure(pytester: pytest.Pytester) -> None:
    arguments = ("--sdo-fault=every-abort-answered", "-v", "-k", "abort.not-answered")
    assert self_test(pytester, *arguments).parseoutcomes()["failed"] > 1
    result = self_test(pytester, *arguments, "-x")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert result.parseoutcomes()["failed"] == 1
    result.stdout.fnmatch_lines(["*stopping after 1 failures*"])
    result.stdout.fnmatch_lines(["not run: * cases of node 5: stopping after 1 failures"])


def test_what_x_left_is_in_the_report(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--sdo-fault=abort-big-endian", "-k", "abort.", "-x")
    outcomes = result.parseoutcomes()
    ids = case_ids(the_report(pytester) / "junit.xml")
    assert len(ids) == len(set(ids)) == 18
    report = (the_report(pytester) / "junit.xml").read_text(encoding="utf-8")
    run = outcomes["failed"] + outcomes.get("passed", 0)
    assert report.count("not run: stopping after 1 failures") == 18 - run > 0


def test_several_devices_are_tested_one_after_another(pytester: pytest.Pytester) -> None:
    """Each to its end: what judges a whole run judges that of one device."""
    result = self_test(pytester, "--node-id=9,5-6", "-k", "abort.frame or run.filler", "-rA")
    passed = [line.partition("::")[2] for line in result.outlines if line.startswith("PASSED ")]
    assert passed == [
        f"{case}@{node}" for node in (5, 6, 9) for case in ("abort.frame", "run.filler")
    ]


def test_v_shows_the_ids_that_k_takes(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "-v", "-k", "abort.frame or abort.not-answered")
    result.stdout.fnmatch_lines(
        [
            "cases/test_abort.py::abort.not-answered[[]general-error] PASSED *",
            "cases/test_abort.py::abort.frame PASSED *",
        ]
    )
