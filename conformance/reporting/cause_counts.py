"""The causes of failures: each once, with the cases that fail for it or cannot be tested."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from conformance.reporting.summary import counted
from conformance.run.verdict import FAILED, CaseResult, Verdict


@dataclass(slots=True)
class CauseCount:
    """A cause of one device: the results that fail for it, and those that it prevents."""

    node_id: int
    cause: str
    failed: list[CaseResult] = field(default_factory=list)
    kept_away: list[CaseResult] = field(default_factory=list)


def counted_causes(results: Iterable[CaseResult], *, strict: bool) -> list[CauseCount]:
    """Return the causes of a run, most cases first; ``strict`` counts what misses a SHOULD."""
    failing = (*FAILED, *((Verdict.NON_STRICT,) if strict else ()))
    found: dict[tuple[int, str], CauseCount] = {}
    for result in results:
        if not result.cause:
            continue
        count = found.setdefault(
            (result.node_id, result.cause), CauseCount(result.node_id, result.cause)
        )
        if result.verdict in failing:
            count.failed.append(result)
        elif result.verdict is Verdict.NOT_TESTABLE:
            count.kept_away.append(result)
    causes = [count for count in found.values() if count.failed or count.kept_away]
    return sorted(causes, key=lambda count: len(count.failed) + len(count.kept_away), reverse=True)


def cause_lines(causes: Sequence[CauseCount], *, alone: bool) -> list[str]:
    """Return a line for each cause; it names the device unless that is ``alone`` in the run."""
    lines = []
    for count in causes:
        first = (count.failed or count.kept_away)[0]
        told = [f"{counted(len(count.failed))} failed"] if count.failed else []
        told += [f"{len(count.kept_away)} not testable"] if count.kept_away else []
        node = "" if alone else f"node {count.node_id}: "
        lines.append(f"{node}{count.cause} ({', '.join(told)}; first {first.case_id})")
    return lines
