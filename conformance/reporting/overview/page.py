"""An overview as a page: devices and dates, each run with a link to its report."""

import os
from collections.abc import Callable
from pathlib import Path
from urllib.parse import quote

from conformance.reporting.overview.runs import Outcome, Overview, TestedOnce
from conformance.reporting.page.templates import template

# What stands for an outcome, with the name of its style: not by colour alone.
MARKS = {
    Outcome.PASSED: ("✓", "pass"),
    Outcome.FAILED: ("✗", "fail"),
    Outcome.UNFINISHED: ("†", "not-run"),
    Outcome.NOT_TESTED: ("○", "not-testable"),
    Outcome.OTHER: ("b", "bench-error"),
}


def write_overview(path: Path, overview: Overview) -> None:
    """Write the page; raises OSError."""
    text = template("overview").render(page=overview, marks=MARKS, link=_links_from(path.parent))
    path.write_text(text, encoding="utf-8")


def _links_from(folder: Path) -> Callable[[TestedOnce], str]:
    """Return what leads from a page in this folder to the report of a run; empty for none."""

    def link(once: TestedOnce) -> str:
        if once.page is None:
            return ""
        return quote(Path(os.path.relpath(once.page, folder)).as_posix())

    return link
