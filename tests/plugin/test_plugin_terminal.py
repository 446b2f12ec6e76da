"""What the terminal of a run looks like: colours, widths, and how much it says."""

import re

import pytest
from plugin_runs import between, printed, self_test

pytest_plugins = ["pytester"]

RED, GREEN, BOLD = "\x1b[31m", "\x1b[32m", "\x1b[1m"
BAD = ("--sdo-simulated", "--sdo-fault=upload-toggle-ignored", "-k", "segmented-upload.toggle-")
GOOD = ("--sdo-simulated", "-k", "block-download.empty or server-timeout or random.interrupted")


@pytest.fixture(autouse=True)
def no_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the tests run on."""
    for name in ("CI", "NO_COLOR", "FORCE_COLOR", "PY_COLORS"):
        monkeypatch.delenv(name, raising=False)


def line_with(text: str, words: str) -> str:
    """Return the first line that contains these words."""
    return next(line for line in text.splitlines() if words in line)


def test_colours_show_what_was_expected_what_came_and_where(pytester: pytest.Pytester) -> None:
    text = self_test(pytester, "--color=yes", *BAD).stdout.str()
    assert line_with(text, "  expected: ").startswith(GREEN)
    assert line_with(text, "  actual: ").startswith(RED)
    decisive = line_with(text, "  * ")
    assert decisive.startswith(RED + BOLD)
    assert " < " in decisive
    assert line_with(text, "  requirement: ").startswith(" ")
    assert line_with(text, "fix this first: ").startswith(BOLD)


@pytest.mark.parametrize("how", ["no terminal", "NO_COLOR", "--color=no"])
def test_no_colour_where_none_is_wanted(
    how: str, pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    if how == "NO_COLOR":
        monkeypatch.setenv("FORCE_COLOR", "1")
        monkeypatch.setenv("NO_COLOR", "1")
    options = ["--color=no"] if how.startswith("--") else []
    assert "\x1b" not in self_test(pytester, *options, *BAD).stdout.str()


@pytest.mark.parametrize("width", [40, 60, 80, 132])
def test_lines_fit_the_terminal(
    width: int, pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    text = printed(self_test(pytester, *BAD))
    lines = [*text.split("collected")[0].splitlines(), *failures(text)]
    too_long = {line.split()[0] for line in lines if len(line) > width}
    # What is copied stands in one line; the others are pytest's own.
    assert too_long <= {"conformance", "reports:", "platform", "rootdir:", "plugins:"}


def failures(text: str) -> list[str]:
    """Return the lines from the failures to what pytest says at the end."""
    lines = text.splitlines()
    begin = next(number for number, line in enumerate(lines) if " FAILURES " in line)
    end = next(number for number, line in enumerate(lines) if " short test summary " in line)
    return lines[begin:end]


def test_services_are_a_table_where_it_fits(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    several = (*BAD[:-1], "segmented-upload.toggle- or independence or server-timeout")
    monkeypatch.setenv("COLUMNS", "80")
    title = "---------------------------------- by service"
    table = between(self_test(pytester, *several).stdout.str(), title, "====")
    _, head, *rows = table.splitlines()
    assert head.split() == ["pass", "not", "testable", "fail"]
    assert [row.split()[0] for row in rows] == ["segmented", "channel", "server", "all"]
    assert {len(row) for row in rows[:2]} == {len(head)}
    monkeypatch.setenv("COLUMNS", "43")  # as wide as it is with a space between columns
    narrow = self_test(pytester, *several).stdout.str()
    assert re.search("^channel independence  307 {17}2$", narrow, re.MULTILINE)
    monkeypatch.setenv("COLUMNS", "42")
    lines = self_test(pytester, *several).stdout.str()
    assert re.search("^channel independence: 307 pass, 2 fail$", lines, re.MULTILINE)


def test_lines_stay_whole_where_there_is_no_terminal(pytester: pytest.Pytester) -> None:
    text = self_test(pytester, *BAD).stdout.str()
    assert re.search(r"^ 1\. segmented-upload\.toggle: .*; first .*\)$", text, re.MULTILINE)
    assert len(line_with(text, "  actual: ")) > 80


def test_a_run_without_failures_says_little(pytester: pytest.Pytester) -> None:
    text = printed(self_test(pytester, *GOOD))
    head = "================================= conformance"
    _, counts, share, remark, lacks, reports = between(text, head, "====").splitlines()
    assert counts == "1 pass, 1 info, 21 not testable"
    assert share == "2 of 23 cases tested (8 %)"
    assert remark.startswith("info: block-download.empty: ")
    assert lacks.startswith("not testable (")
    assert reports == "reports: FOLDER"
