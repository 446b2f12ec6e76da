"""The reports that are made of a recorded run: at its end, and from its folder at any time."""

from pathlib import Path

from conformance.reporting.junit import write_junit
from conformance.reporting.page.writing import write_page
from conformance.reporting.recorded import RecordedRun

JUNIT = "junit.xml"


def write_reports(folder: Path, run: RecordedRun, *, page: bool = True) -> list[Path]:
    """Write junit.xml and, for people, report.html; return what was written. Raises OSError."""
    path = folder / JUNIT
    write_junit(
        path,
        run.by_device,
        run.properties | ({"broken-off": run.broken_off} if run.broken_off else {}),
        timestamp=run.about["begun_utc"],
        strict=run.about["strict"],
        troubles=run.troubles,
    )
    return [path, *([write_page(folder, run)] if page else [])]
