"""The list of all cases on a page, as HTML.

It is put together here and not by a template: a page may have 60,000 cases, and a template takes
four times as long for each.
"""

from collections.abc import Iterable
from functools import lru_cache
from html import escape

from conformance.reporting.page.cases import Case
from conformance.run.evidence import trace_texts
from conformance.run.verdict import CaseResult
from conformance.sdo.printable_text import inert

# Requirements, levels, services and the like stand in many cases.
REPEATED = 4096


def case_list(cases: Iterable[Case], *, alone: bool) -> str:
    """Return the rows of the cases; ``alone`` says that the run had one device."""
    return "".join([_listed(case, alone=alone) for case in cases])


def _listed(case: Case, *, alone: bool) -> str:
    result = case.result
    verdict, level = _often(result.verdict.value), _often(result.level)
    state = f' data-state="{_often(result.state)}"' if result.state else ""
    node = "" if alone else f" (node {result.node_id})"
    about = f"{level}, {_often(result.clause)}; {verdict}; {result.duration * 1000:.1f} ms"
    notes = "".join([f'<p class="note">{_text(note)}</p>' for note in result.notes])
    frames = "\n".join(trace_texts(result)) or case.frames
    return (
        f'<details class="case" id="{case.anchor}" data-verdict="{verdict}" data-level="{level}"'
        f' data-service="{_often(result.service)}"{state}><summary>'
        f'<span class="mark {case.kind}" role="img" aria-label="{verdict}">{case.mark}</span>'
        f" {_text(result.case_id)}{node}</summary>\n"
        f"<p>{_often(result.requirement)} <small>{about}</small></p>\n"
        f"{_judgement(result)}{notes}{f'<pre>{_text(frames)}</pre>' if frames else ''}</details>\n"
    )


def _judgement(result: CaseResult) -> str:
    """Return the expected and the actual response of a case, unless its verdict says enough."""
    if not (result.expected or result.actual or result.cause):
        return ""
    said = {
        "cause": str(result.cause or ""),
        "expected": result.expected,
        "came": result.actual,
        "reason": result.reason,
        "afterwards": result.afterwards.value,
    }
    rows = [f"<dt>{name}</dt><dd>{_text(words)}</dd>" for name, words in said.items() if words]
    return f"<dl>{''.join(rows)}</dl>"


def _text(text: str) -> str:
    """Return text as HTML, inert with any text of a device."""
    return escape(inert(text, keep="\n"))


_often = lru_cache(REPEATED)(_text)
