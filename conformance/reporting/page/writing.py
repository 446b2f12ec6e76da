"""Writes report.html: one file without anything beside it."""

from collections.abc import Collection
from pathlib import Path

from conformance.reporting.page.case_list import case_list
from conformance.reporting.page.cases import MARKS, links
from conformance.reporting.page.content import PageContent
from conformance.reporting.page.observed import Observed, observed
from conformance.reporting.page.templates import template
from conformance.reporting.recorded import RecordedRun
from conformance.run.verdict import Verdict

PAGE = "report.html"
# Of this many cases a page has 15 MB, and a browser opens it within seconds.
MOST_WITH_FRAMES = 10_000


def with_frames(run: RecordedRun) -> Collection[int]:
    """Return the numbers of the cases whose frames the page shows: of many those that matter."""
    if len(run.results) <= MOST_WITH_FRAMES:
        return range(len(run.results))
    return {
        number for number, result in enumerate(run.results) if result.verdict is not Verdict.PASS
    }


def seen_in(folder: Path, run: RecordedRun) -> Observed:
    """Read of the logs of a run what its page shows; raises OSError."""
    return observed(folder, run, in_words=with_frames(run))


def write_page(folder: Path, run: RecordedRun, seen: Observed | None = None) -> Path:
    """Write the page of a run into its report folder; raises OSError.

    ``seen`` is what was read of its logs, if that was done.
    """
    seen = seen or seen_in(folder, run)
    content = PageContent(folder, run, seen.traffic, seen.profile)
    path = folder / PAGE
    text = template("report").render(page=content, marks=MARKS, links=links, case_list=case_list)
    path.write_text(text, encoding="utf-8")
    return path
