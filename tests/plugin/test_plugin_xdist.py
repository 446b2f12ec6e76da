"""Workers of pytest-xdist would talk to one device all at once: they are refused in a sentence."""

import pytest
from plugin_runs import run, the_report

pytest_plugins = ["pytester"]


def test_workers_are_refused(pytester: pytest.Pytester) -> None:
    result = run(pytester, "--self-test", "-n", "2")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: *leave out -n (pytest-xdist)*"])


def test_several_devices_in_turn(pytester: pytest.Pytester) -> None:
    result = run(pytester, "--self-test", "--node-id=5,9", "-v", "-k", "upload.identity")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(["*::upload.identity@5 PASSED*", "*::upload.identity@9 PASSED*"])
    assert (the_report(pytester) / "junit.xml").is_file()
