"""The reports that are made of a recorded run: at its end, and from its folder at any time."""

from functools import partial
from pathlib import Path

from conformance.reporting.junit.cases import write_junit
from conformance.reporting.junit.descriptions import suite_of_run
from conformance.reporting.junit.rules import write_causes
from conformance.reporting.page.observed import Observed
from conformance.reporting.page.writing import write_page
from conformance.reporting.recorded import RecordedRun
from conformance.reporting.reproduction import write_reproductions

JUNIT, CAUSES = "junit.xml", "causes.xml"


def write_reports(
    folder: Path, run: RecordedRun, *, page: bool = True, seen: Observed | None = None
) -> list[Path]:
    """Write junit.xml, causes.xml, what reproduces failures and, for people, report.html.

    ``seen`` is what was read of the logs for the page, if that was done. Returns what was written.
    Raises OSError.
    """
    paths = [folder / JUNIT, folder / CAUSES]
    described = run.about.get("eds") or {}
    found = described.get("findings", [])
    further = suite_of_run(Path(described["name"]).name, found) if found else []
    for path, write in (
        (paths[0], partial(write_junit, further=further)),
        (paths[1], partial(write_causes)),
    ):
        write(
            path,
            run.by_device,
            run.properties | ({"broken-off": run.broken_off} if run.broken_off else {}),
            timestamp=run.about["begun_utc"],
            strict=run.about["strict"],
            troubles=run.troubles,
        )
    reproductions = write_reproductions(folder, run)
    return [
        *paths,
        *([] if reproductions is None else [reproductions]),
        *([write_page(folder, run, seen)] if page else []),
    ]
