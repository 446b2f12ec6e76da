"""The templates of pages: each page is one file, inert whatever a device has sent."""

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from conformance.reporting.page.diagram import LIFELINES, MIDDLE, WIDTH
from conformance.reporting.recorded import TEXT_NAMES
from conformance.run.evidence import trace_texts
from conformance.sdo.printable_text import inert
from conformance.sdo.rules import cited


def template(name: str) -> Template:
    """Return the template with this name."""
    return _environment().get_template(f"{name}.html.jinja")


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("conformance.reporting.page", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_shown,
    )
    environment.globals |= {
        "width": WIDTH,
        "lifelines": LIFELINES,
        "middle": MIDDLE,
        "texts": TEXT_NAMES,
        "cited": cited,
        "trace_texts": trace_texts,
    }
    return environment


def _shown(value: object) -> object:
    """Write out what no reader would see, or what would turn the writing round."""
    return value if hasattr(value, "__html__") else inert(str(value), keep="\n")
