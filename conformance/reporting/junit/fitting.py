"""What fits into a JUnit file: no more cases, and no more bytes, than those who read it take.

A large EDS has more cases than that, and so have many devices. Then cases that did not fail are
told together, first those of one name, then those of one service; failures only if they do not
fit either.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

from conformance.reporting.text import xml_text
from conformance.run.verdict import CaseResult, Verdict

# Buildkite takes 5,000 results of a file, GitLab 30 MB.
MOST_CASES = 5_000
MOST_BYTES = 24_000_000
ALL_SERVICES = "all services"
LEFT_OUT = "… the rest is left out; results.jsonl has it"
# What quoting makes of the worst character, in bytes: ``&quot;``.
WORST = 6


@dataclass(frozen=True, slots=True)
class Row:
    """A test case of the file: a result, or several with one outcome, put together.

    ``service`` is that of the suite in which it stands.
    """

    service: str
    name: str
    results: Sequence[CaseResult]

    @property
    def first(self) -> CaseResult:
        """The result that stands for all."""
        return self.results[0]


def is_failure(result: CaseResult, *, strict: bool) -> bool:
    """Say whether a case counts as failed; ``strict`` counts what misses a SHOULD."""
    failing = (Verdict.FAIL, Verdict.STALE, Verdict.BENCH_ERROR)
    return result.verdict in failing or (strict and result.verdict is Verdict.NON_STRICT)


# The suite and the name under which a result is told.
Place = tuple[str, str]


def rows_that_fit(results: Sequence[CaseResult], most: int, *, strict: bool) -> list[Row]:
    """Return a row for each result, or as many as fit that tell of several results."""

    def each(result: CaseResult) -> Place:
        return result.service, result.case_id

    def passes_by_name(result: CaseResult) -> Place:
        if is_failure(result, strict=strict):
            return each(result)
        return result.service, f"{_test(result)}: {result.verdict.value}"

    def passes_by_service(result: CaseResult) -> Place:
        if is_failure(result, strict=strict):
            return each(result)
        return result.service, result.verdict.value

    def failures_by_cause(result: CaseResult) -> Place:
        if is_failure(result, strict=strict):
            return result.service, f"{result.cause or _test(result)}: {result.verdict.value}"
        return passes_by_service(result)

    def by_verdict(result: CaseResult) -> Place:
        return ALL_SERVICES, result.verdict.value

    if len(results) <= most:
        return [Row(*each(result), [result]) for result in results]
    rows: list[Row] = []
    for place in (passes_by_name, passes_by_service, failures_by_cause, by_verdict):
        rows = _rows(results, place)
        if len(rows) <= most:
            break
    return rows


def _rows(results: Sequence[CaseResult], place: Callable[[CaseResult], Place]) -> list[Row]:
    """Put together the results of each device with the same place."""
    found: dict[tuple[int, Place], list[CaseResult]] = {}
    for result in results:
        found.setdefault((result.node_id, place(result)), []).append(result)
    return [
        Row(service, name if len(alike) > 1 else alike[0].case_id, alike)
        for (_, (service, name)), alike in found.items()
    ]


def _test(result: CaseResult) -> str:
    """Return the id of a case without what it varies in."""
    return result.name if result.name == result.case_id else f"{result.name}[…]"


def shortened(text: str, most: int) -> str:
    """Return a text as XML can hold it, without its end if it takes more than ``most`` bytes."""
    text = xml_text(text)
    if _bytes(text) <= most:
        return text
    kept: list[str] = []
    room = most - _bytes(LEFT_OUT) - 1
    for line in text.split("\n"):
        room -= _bytes(line) + 1
        if room < 0:
            break
        kept.append(line)
    return "\n".join([*kept, LEFT_OUT] if kept else [text[: most // WORST], LEFT_OUT])


def _bytes(text: str) -> int:
    """Return the bytes of a text in an attribute, which takes more of them than an element."""
    return len(quoteattr(text).encode("utf-8"))
