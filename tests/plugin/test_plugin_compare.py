"""`conformance compare` on two runs: the reference server, and one with a defect."""

from pathlib import Path

import pytest
from plugin_runs import reports, self_test

from conformance.__main__ import main
from conformance.commands.status import DONE, NOT_ALLOWED

pytest_plugins = ["pytester"]

CHOSEN = ("--sdo-simulated", "-k", "abort")
CAUSE = "abort.not-answered: an answer"


def left_behind(pytester: pytest.Pytester, *arguments: str) -> Path:
    """Run some cases; return the report folder."""
    before = set(reports(pytester).glob("*"))
    self_test(pytester, *CHOSEN, *arguments)
    (folder,) = set(reports(pytester).glob("*")) - before
    return folder


def test_a_defect_comes_and_goes(
    pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    right = left_behind(pytester)
    wrong = left_behind(pytester, "--sdo-fault=every-abort-answered")
    capsys.readouterr()

    assert main(["compare", str(right), str(wrong)]) == NOT_ALLOWED
    lines = capsys.readouterr().out.splitlines()
    assert "  built-in server: none -> every-abort-answered" in lines
    new = lines[lines.index("new causes (1):") + 1]
    assert new.startswith(f"  {CAUSE} (")
    assert lines[-1].endswith(" cases broken; 1 new cause")

    assert main(["compare", str(wrong), str(right)]) == DONE
    lines = capsys.readouterr().out.splitlines()
    gone = lines[lines.index("causes that are gone (1):") + 1]
    assert gone == new
    assert lines[-1] == "nothing got worse"

    assert main(["compare", str(right), str(right)]) == DONE
    assert capsys.readouterr().out.splitlines()[2:] == ["nothing got worse"]
