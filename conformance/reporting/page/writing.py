"""Writes report.html: one file without anything beside it."""

from pathlib import Path

from conformance.reporting.page.content import MARKS, PageContent
from conformance.reporting.page.observed import observed
from conformance.reporting.page.templates import template
from conformance.reporting.recorded import RecordedRun

PAGE = "report.html"


def write_page(folder: Path, run: RecordedRun) -> Path:
    """Write the page of a run into its report folder; raises OSError."""
    seen = observed(folder, run)
    content = PageContent(folder, run, seen.traffic, seen.profile)
    path = folder / PAGE
    path.write_text(template("report").render(page=content, marks=MARKS), encoding="utf-8")
    return path
