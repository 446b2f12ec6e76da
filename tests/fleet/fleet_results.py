"""What a run against a foreign server has found, and whether that is what was judged right."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from fleet_servers import ExpectedCause

NOT_RUN = "not run"
LACKING = ("unimplemented", "not testable")
# What a case says that has met the cause which others have shown, at its own point: the frame that
# it is about was sent, and its answer was wrong as theirs were. What a case meets on its way there
# "prevents this case", and does not count.
SHOWN = "was reported before"


@dataclass(frozen=True, slots=True)
class Outcome:
    """One case of a run: its verdict, and the sentence that tells.

    ``cause`` is what is wrong with the device where the case failed, or was kept from its point.
    """

    case: str
    verdict: str
    cause: str
    message: str

    @property
    def failed(self) -> bool:
        """Return whether the device failed."""
        return self.verdict == "fail"

    @property
    def lacks(self) -> bool:
        """Return whether the case needs what the server does not have or the list does not name."""
        return self.verdict in LACKING and not self.cause

    @property
    def reached(self) -> bool:
        """Return whether the case came to what it is about."""
        if self.cause and SHOWN in self.message:
            return True
        return self.verdict not in (*LACKING, NOT_RUN, "bench error")


def outcomes(junit: Path) -> Iterator[Outcome]:
    """Read the results that pytest has left."""
    # The file is our own.
    for case in ElementTree.parse(junit).getroot().iter("testcase"):  # noqa: S314
        values = {each.get("name"): each.get("value") or "" for each in case.iter("property")}
        told = next((each for each in case if each.tag in ("failure", "error", "skipped")), None)
        text = "" if told is None else f"{told.get('message') or ''}\n{told.text or ''}"
        yield Outcome(
            case=values.get("id") or case.get("name") or "",
            verdict=values.get("verdict") or ("error" if told is not None else "pass"),
            cause=values.get("cause") or _broken_rule(text),
            message=text.partition("\n")[0],
        )


def _broken_rule(text: str) -> str:
    """Return the id of the rule that a failure names; the cause, where none is told."""
    _, _, rest = text.partition("broken rule: ")
    return rest.partition("\n")[0].partition(":")[0]


@dataclass(slots=True)
class Comparison:
    """The causes of a run beside those that were judged right."""

    unexpected: dict[str, list[Outcome]] = field(default_factory=dict)
    missing: list[ExpectedCause] = field(default_factory=list)
    found: dict[str, list[Outcome]] = field(default_factory=dict)
    in_the_way: dict[str, list[Outcome]] = field(default_factory=dict)

    @classmethod
    def of(cls, results: Sequence[Outcome], expected: Sequence[ExpectedCause]) -> Self:
        """Compare what a run has found with what is expected."""
        comparison = cls()
        for outcome in results:
            if outcome.failed:
                comparison.found.setdefault(outcome.cause, []).append(outcome)
            elif outcome.cause and not outcome.reached:
                comparison.in_the_way.setdefault(outcome.cause, []).append(outcome)
        for cause, behind in comparison.found.items():
            if not any(each.covers(cause) for each in expected):
                comparison.unexpected[cause] = behind
        for each in expected:
            met = any(each.covers(cause) for cause in comparison.found)
            if not met and not each.now_and_then:
                comparison.missing.append(each)
        return comparison

    @property
    def right(self) -> bool:
        """Return whether all that was found is expected, and the other way round."""
        return not self.unexpected and not self.missing

    def lines(self) -> Iterator[str]:
        """Tell what differs, with a case for each cause that is not judged yet, and what hides."""
        for cause, behind in self.unexpected.items():
            yield f"  not expected: {cause} ({len(behind)} cases)"
            yield f"    {behind[0].case}: {behind[0].message}"
        for each in self.missing:
            yield f"  not found: {each.cause}"
        for cause, behind in self.in_the_way.items():
            yield f"  in the way of {len(behind)} cases: {cause}"


@dataclass(frozen=True, slots=True)
class Row:
    """A line of the table: what a run against a server came to."""

    name: str
    cases: int
    failed: int
    causes: int
    reached: int
    reachable: int
    seconds: float

    HEADER = f"{'server':<14}{'cases':>7}{'failed':>8}{'causes':>8}{'reached':>16}{'time':>9}"

    @classmethod
    def of(
        cls,
        name: str,
        results: Sequence[Outcome],
        seconds: float,
        expected: Sequence[ExpectedCause] = (),
    ) -> Self:
        """Count the results of a run."""
        lacking = [each for each in expected if each.lacking]
        reachable = [
            each
            for each in results
            if not each.lacks
            and (each.reached or not any(cause.covers(each.cause) for cause in lacking))
        ]
        failed = [each for each in results if each.failed]
        return cls(
            name=name,
            cases=len(results),
            failed=len(failed),
            causes=len({each.cause for each in failed}),
            reached=sum(each.reached for each in reachable),
            reachable=len(reachable),
            seconds=seconds,
        )

    @property
    def share(self) -> float:
        """Return which part of the cases that the server has what for reached their point."""
        return self.reached / self.reachable if self.reachable else 0.0

    def __str__(self) -> str:
        reached = f"{self.reached}/{self.reachable} {self.share:4.0%}"
        return (
            f"{self.name:<14}{self.cases:>7}{self.failed:>8}{self.causes:>8}"
            f"{reached:>16}{self.seconds:>7.0f} s"
        )
