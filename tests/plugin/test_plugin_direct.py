"""Cases that run without what pytest does around a test: everybody is told as of any other."""

from collections import Counter
from typing import Any

import pytest
from plugin_runs import case_ids, parsed, printed, self_test, the_report

pytest_plugins = ["pytester"]

FAULT = "--sdo-fault=upload-toggle-ignored"
CHOSEN = ("-k", "segmented-upload or server-timeout or test_whole_run")


class Told:
    """What a plugin hears of a run."""

    def __init__(self) -> None:
        self.heard: Counter[str] = Counter()
        self.reports: list[tuple[str, str, str]] = []

    def pytest_runtest_logstart(self) -> None:
        self.heard["start"] += 1

    def pytest_runtest_logfinish(self) -> None:
        self.heard["finish"] += 1

    def pytest_exception_interact(self) -> None:
        self.heard["exception"] += 1

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.reports.append((report.nodeid, report.when or "", report.outcome))


class TakesPart(Told):
    """Looks at each phase, so that pytest runs them."""

    def pytest_runtest_setup(self) -> None:
        self.heard["setup"] += 1

    def pytest_runtest_call(self) -> None:
        self.heard["call"] += 1

    def pytest_runtest_teardown(self) -> None:
        self.heard["teardown"] += 1


def described(pytester: pytest.Pytester) -> list[Any]:
    """Return what the report says of each case, but for times."""
    cases = parsed(the_report(pytester) / "junit.xml").iter("testcase")
    return [
        [
            (child.tag, child.attrib.get("message"))
            for child in case
            if child.tag in ("failure", "skipped", "error")
        ]
        for case in cases
    ]


def test_what_is_told_is_what_pytest_tells(pytester: pytest.Pytester) -> None:
    alone, beside = Told(), TakesPart()
    direct = self_test(pytester, FAULT, *CHOSEN, plugins=[alone])
    names, evidence = case_ids(the_report(pytester) / "junit.xml"), described(pytester)
    the_report(pytester).rename(pytester.path / "direct")
    as_ever = self_test(pytester, FAULT, *CHOSEN, plugins=[beside])
    assert beside.heard["setup"] == beside.heard["start"] > beside.heard["call"]
    assert alone.reports == beside.reports
    assert alone.heard == Counter(
        {each: beside.heard[each] for each in ("start", "finish", "exception")}
    )
    assert alone.heard["exception"], "one has failed"
    assert {outcome for *_, outcome in alone.reports} == {"passed", "failed", "skipped"}
    assert (names, evidence) == (
        case_ids(the_report(pytester) / "junit.xml"),
        described(pytester),
    )
    assert printed(direct) == printed(as_ever)


def test_what_is_logged_is_captured_where_that_is_wanted(pytester: pytest.Pytester) -> None:
    chosen = (FAULT, "-k", "segmented-upload.toggle-first")
    result = self_test(pytester, *chosen, "--log-level=DEBUG")
    result.stdout.fnmatch_lines(["*Captured log call*", "DEBUG*conformance.frames*> 605#*"])
    assert "Captured log" not in self_test(pytester, *chosen).stdout.str()


def test_the_phases_are_shown_where_that_is_wanted(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        plugin="""
        import pytest

        @pytest.fixture(autouse=True)
        def bench_light():
            yield
        """
    )
    pytester.syspathinsert()
    shown = self_test(pytester, "-p", "plugin", "-k", "upload.identity", "--setup-show")
    shown.stdout.fnmatch_lines(["*SETUP    F bench_light*", "*TEARDOWN F bench_light*"])


def test_the_first_failure_may_end_the_run(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, FAULT, *CHOSEN, "-x")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert result.parseoutcomes()["failed"] == 1
