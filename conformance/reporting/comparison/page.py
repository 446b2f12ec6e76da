"""A comparison as a page, in the style of the report of a run."""

from collections.abc import Sequence
from pathlib import Path

from conformance.reporting.cause_counts import CauseCount
from conformance.reporting.comparison.comparison import Comparison
from conformance.reporting.page.cases import MARKS, Case, CauseShown, cause_shown
from conformance.reporting.page.templates import template


def write_comparison(path: Path, comparison: Comparison) -> None:
    """Write the page; raises OSError."""
    causes = {
        "New causes": _shown(comparison.new_causes),
        "Causes that are gone": _shown(comparison.gone_causes),
        "Causes whose cases were not tested again": _shown(comparison.untested_causes),
    }
    text = template("comparison").render(page=comparison, causes=causes, marks=MARKS)
    path.write_text(text, encoding="utf-8")


def _shown(causes: Sequence[CauseCount]) -> list[CauseShown]:
    return [
        cause_shown(count, [Case(number, result, "") for number, result in enumerate(count.failed)])
        for count in causes
    ]
