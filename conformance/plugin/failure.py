"""A failure as pytest and its plugins take it: an AssertionError, with the evidence as its text."""

import traceback
from pathlib import Path
from typing import Any

import pytest

from conformance.run.evidence import evidence_text
from conformance.run.verdict import CaseResult


class CaseFailed(AssertionError):
    """A device broke a rule; the text is the evidence."""

    def __init__(self, result: CaseResult) -> None:
        """Take a result that is complete."""
        super().__init__(evidence_text(result))
        self.result = result


def as_pytest_shows(
    item: pytest.Item, excinfo: pytest.ExceptionInfo[BaseException], result: CaseResult
) -> Any:
    """Return the failure for pytest: the evidence instead of a traceback of the suite.

    It is of pytest's own classes, as plugins and other processes expect them, and says at which
    line of the test the device has failed.
    """
    shown = excinfo.getrepr(style="value", chain=False)
    last = shown.reprtraceback.reprentries[-1]
    last.lines = evidence_text(result).splitlines()
    if shown.reprcrash is not None:
        shown.reprcrash.path = str(item.path)
        shown.reprcrash.lineno = _line(item, excinfo.value)
        shown.reprcrash.message = _in_a_line(result)
    return shown


def lines_shown(report: pytest.TestReport, result: CaseResult) -> list[str] | None:
    """Return the lines of a report that are the evidence; None if it shows something else.

    They may be changed.
    """
    shown: Any = report.longrepr
    traceback_shown = getattr(shown, "reprtraceback", None)
    if traceback_shown is None:
        return None
    lines: list[str] = traceback_shown.reprentries[-1].lines
    return lines if lines == evidence_text(result).splitlines() else None


def _in_a_line(result: CaseResult) -> str:
    """Return the message of summaries and JUnit files."""
    actual = result.actual.splitlines()[0] if result.actual else result.verdict.value
    return f"expected {result.expected}; got {actual}" if result.expected else actual


def _line(item: pytest.Item, error: BaseException) -> int:
    """Return the line of the test that met an error; if none did, its first."""
    met = error.__cause__ or error
    lines = [
        line
        for frame, line in traceback.walk_tb(met.__traceback__)
        if Path(frame.f_code.co_filename) == item.path
    ]
    return lines[-1] if lines else (item.location[1] or 0) + 1
