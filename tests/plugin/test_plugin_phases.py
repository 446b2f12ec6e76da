"""Cases are tests like any other to pytest: logs, fixtures of a project, the first failure."""

import pytest
from plugin_runs import self_test

pytest_plugins = ["pytester"]

FAULT = "--sdo-fault=upload-toggle-ignored"
CHOSEN = ("-k", "segmented-upload or server-timeout or test_whole_run")


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
