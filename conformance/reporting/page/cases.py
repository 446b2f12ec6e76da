"""The cases of a run on a page, and the causes of those that failed."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

from conformance.reporting.cause_counts import CauseCount
from conformance.reporting.page.diagram import Diagram, diagram
from conformance.run.verdict import CaseResult, Verdict
from conformance.sdo.rules import RULES_BY_ID, Rule

# What stands for a verdict where there is room for one character: not by colour alone.
MARKS = {
    Verdict.PASS: "✓",
    Verdict.NON_STRICT: "~",
    Verdict.INFO: "i",
    Verdict.UNIMPLEMENTED: "∅",
    Verdict.NOT_TESTABLE: "○",
    Verdict.FAIL: "✗",
    Verdict.KNOWN_DEVIATION: "k",
    Verdict.STALE: "s",
    Verdict.BENCH_ERROR: "b",
    Verdict.NOT_RUN: "·",
}


@dataclass(frozen=True)
class Case:
    """A case on the page: its place there, its result, its frames."""

    number: int
    result: CaseResult
    frames: str

    @cached_property
    def anchor(self) -> str:
        """Where the page shows it."""
        return f"c{self.number}"

    @property
    def mark(self) -> str:
        """The verdict as a character."""
        return MARKS[self.result.verdict]

    @property
    def kind(self) -> str:
        """The verdict as the name of a style."""
        return self.result.verdict.value.replace(" ", "-")

    @cached_property
    def link(self) -> str:
        """The links to it, as HTML: a page may have ten of these, of each of many cases."""
        return f'<a class="mark {self.kind}" href="#{self.anchor}">{self.mark}</a>'


def links(cases: Iterable[Case]) -> str:
    """Return the links to these cases, as HTML."""
    return "".join([case.link for case in cases])


@dataclass(frozen=True, slots=True)
class CauseShown:
    """A cause with its rule, the picture of its first failure, and the cases behind it.

    ``files`` lie beside the page and send the frames again; ``replay`` is the command that sends
    them from the folder of the run, empty where there is none.
    """

    count: CauseCount
    rule: Rule | None
    first: Case
    diagram: Diagram | None
    cases: list[Case]
    files: list[str]
    replay: str

    @property
    def kind(self) -> str:
        """The kind of answer."""
        return self.count.cause.words or self.first.result.actual

    @property
    def counts(self) -> str:
        """How many cases it has."""
        return self.count.told


def cause_shown(
    count: CauseCount, cases: list[Case], files: Sequence[str] = (), replay: str = ""
) -> CauseShown:
    """Return a cause with these cases, the first of which shows it, and files beside the page."""
    rule = RULES_BY_ID.get(count.cause.rule_id)
    drawn = diagram(cases[0].result.trace, cases[0].result.decisive)
    return CauseShown(count, rule, cases[0], drawn, cases, list(files), replay)
