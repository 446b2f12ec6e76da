"""The causes of failures: each once, with the cases that fail for it or cannot be tested."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from conformance.reporting.recorded import RecordedRun
from conformance.reporting.summary import counted
from conformance.run.verdict import FAILED, CaseResult, Verdict
from conformance.sdo.rules import Cause


@dataclass(slots=True)
class CauseCount:
    """A cause of one device: the results that fail for it, and those that it prevents."""

    node_id: int
    cause: Cause
    failed: list[CaseResult] = field(default_factory=list)
    kept_away: list[CaseResult] = field(default_factory=list)

    @property
    def cases(self) -> list[CaseResult]:
        """All of them; the first one shows the cause: the plainest that failed."""
        return [*sorted(self.failed, key=self._irregularity), *self.kept_away]

    def _irregularity(self, result: CaseResult) -> tuple[bool, bool, int, int]:
        """Return a key by which the plainest failure comes first.

        It breaks the rule of the cause and no other, and tests that rule; the case has met no other
        cause, and has few frames.
        """
        rule = self.cause.rule_id
        return (
            result.broken_rules != {rule},
            rule not in result.tested_rules,
            len(result.met),
            len(result.trace),
        )

    @property
    def told(self) -> str:
        """How many cases it has, in words."""
        told = [f"{counted(len(self.failed))} failed"] if self.failed else []
        told += [f"{len(self.kept_away)} not testable"] if self.kept_away else []
        return ", ".join(told)


def causes_of(run: RecordedRun) -> list[CauseCount]:
    """Return the causes of a recorded run in the order in which all reports number them."""
    return counted_causes(run.by_device, strict=run.about["strict"])


def counted_causes(results: Iterable[CaseResult], *, strict: bool) -> list[CauseCount]:
    """Return the causes of a run, most cases first; ``strict`` counts what misses a SHOULD."""
    failing = (*FAILED, *((Verdict.NON_STRICT,) if strict else ()))
    found: dict[tuple[int, Cause], CauseCount] = {}
    for result in results:
        if result.cause is None:
            continue
        count = found.setdefault(
            (result.node_id, result.cause), CauseCount(result.node_id, result.cause)
        )
        if result.verdict in failing:
            count.failed.append(result)
        elif result.verdict is Verdict.NOT_TESTABLE:
            count.kept_away.append(result)
    causes = [count for count in found.values() if count.cases]
    return sorted(causes, key=lambda count: len(count.cases), reverse=True)


def cause_lines(causes: Sequence[CauseCount], *, alone: bool) -> list[str]:
    """Return a line for each cause; it names the device unless that is ``alone`` in the run."""
    lines = []
    for count in causes:
        node = "" if alone else f"node {count.node_id}: "
        lines.append(f"{node}{count.cause} ({count.told}; first {count.cases[0].case_id})")
    return lines
