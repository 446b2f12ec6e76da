"""Writes report.html: one file without anything beside it, inert whatever a device has sent."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from conformance.reporting.page.content import MARKS, PageContent
from conformance.reporting.page.diagram import LIFELINES, MIDDLE, WIDTH
from conformance.reporting.page.profile import profiles
from conformance.reporting.page.traffic import Traffic, read_traffic
from conformance.reporting.recorded import RecordedRun
from conformance.sdo.inert import inert

PAGE = "report.html"


def write_page(folder: Path, run: RecordedRun) -> Path:
    """Write the page of a run into its report folder; raises OSError."""
    channels = run.channels
    node_ids: Sequence[int] = [result.node_id for result in run.results]
    try:
        traffic = read_traffic(folder, run.places, node_ids, channels)
        profile = profiles(folder, run.places, node_ids)
    except FileNotFoundError:
        traffic, profile = Traffic(), {}
    path = folder / PAGE
    path.write_text(page_text(PageContent(run, traffic, profile)), encoding="utf-8")
    return path


def page_text(content: PageContent) -> str:
    """Return the page."""
    return _template().render(
        page=content, marks=MARKS, width=WIDTH, lifelines=LIFELINES, middle=MIDDLE
    )


@cache
def _template() -> Template:
    environment = Environment(
        loader=PackageLoader("conformance.reporting.page", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_shown,
    )
    return environment.get_template("report.html.jinja")


def _shown(value: object) -> object:
    """Write out what no reader would see, or what would turn the writing round."""
    return inert(value, keep="\n") if type(value) is str else value
