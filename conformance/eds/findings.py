"""Findings about a description: the rule, the place, and how the reader goes on."""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import TypedDict

# A file of one mistake in each line says no more by its 200th.
MOST_OF_A_RULE = 200


class Severity(StrEnum):
    """How bad a finding is: an error contradicts a specification, a remark is no mistake."""

    ERROR = "error"
    WARNING = "warning"
    REMARK = "remark"


@dataclass(frozen=True, slots=True)
class EdsRule:
    """One requirement for a description: a stable id, its clause, and one sentence."""

    id: str
    clause: str
    severity: Severity
    sentence: str


@dataclass(frozen=True, slots=True)
class Place:
    """Where a finding is: a line, counted from 1 (None: the file as a whole), and a section."""

    line: int | None = None
    section: str = ""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong in a file.

    ``made`` says how the file is read all the same; empty where the thing has no effect.
    """

    rule: EdsRule
    path: Path
    place: Place
    sentence: str
    made: str = ""

    @property
    def severity(self) -> Severity:
        """The severity of the rule."""
        return self.rule.severity

    @property
    def where(self) -> str:
        """File and line, as terminals and editors make a link of."""
        return f"{self.path}:{self.place.line}" if self.place.line else str(self.path)

    @property
    def text(self) -> str:
        """The sentence, and how the file is read."""
        return f"{self.sentence}. {self.made}." if self.made else f"{self.sentence}."

    @property
    def record(self) -> "FindingRecord":
        """The finding as it stands in a record."""
        return FindingRecord(
            file=str(self.path),
            line=self.place.line,
            section=self.place.section,
            rule=self.rule.id,
            clause=self.rule.clause,
            severity=self.severity.value,
            sentence=self.sentence,
            made=self.made,
            text=str(self),
        )

    def __str__(self) -> str:
        named = f"[{self.place.section}]"
        where = f"{named} " if self.place.section and named not in self.sentence else ""
        told = f"{where}{self.text} [{self.rule.id}, {self.rule.clause}]"
        return f"{self.where}: {self.severity}: {told}"


class FindingRecord(TypedDict):
    """A finding in JSON; ``text`` is all of it in a line."""

    file: str
    line: int | None
    section: str
    rule: str
    clause: str
    severity: str
    sentence: str
    made: str
    text: str


@dataclass(slots=True)
class Findings:
    """The findings about one file, as far as its check has come."""

    path: Path
    found: list[Finding] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)

    def add(self, rule: EdsRule, place: Place, sentence: str, made: str = "") -> None:
        """Add a finding; of one rule at most the first 200 are kept."""
        self.counts[rule.id] += 1
        if self.counts[rule.id] <= MOST_OF_A_RULE:
            self.found.append(Finding(rule, self.path, place, sentence, made))

    def count(self, rules: Iterable[EdsRule]) -> int:
        """Return how many findings there are by these rules."""
        return sum(self.counts[rule.id] for rule in rules)

    def sorted(self) -> tuple[Finding, ...]:
        """Return the findings in the order of their lines."""
        return tuple(sorted(self.found, key=lambda one: one.place.line or 0))

    def left_out(self) -> Iterator[tuple[str, int]]:
        """Yield each rule of which more was found than is kept, and how much more."""
        for rule_id, count in self.counts.items():
            if count > MOST_OF_A_RULE:
                yield rule_id, count - MOST_OF_A_RULE
