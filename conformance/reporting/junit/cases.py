"""junit.xml: one suite per service of the protocol, with all cases of a run."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from junit_xml import TestCase

from conformance.reporting.junit.fitting import (
    MOST_BYTES,
    MOST_CASES,
    Row,
    is_failure,
    rows_that_fit,
    shortened,
)
from conformance.reporting.junit.tree import Suite, write_suites
from conformance.reporting.summary import counted
from conformance.run.evidence import evidence_text
from conformance.run.verdict import CaseResult, Verdict

# The parts of what a case may take that go to its evidence, and to its message; the rest is for
# names and tags.
EVIDENCE, MESSAGE = 0.7, 0.2
MOST_REASONS = 10


def write_junit(
    path: Path,
    results: Sequence[CaseResult],
    properties: Mapping[str, str],
    *,
    timestamp: str,
    strict: bool = False,
    troubles: Sequence[str] = (),
    further: Sequence[Suite] = (),
) -> None:
    """Write the results; ``properties`` describe device and run and stand in every suite.

    ``strict`` counts what is not strictly conformant as failed, as the run did. ``troubles`` are
    those of the run that no result shows. ``further`` are suites that are about no case.
    """
    rows = rows_that_fit(
        results,
        MOST_CASES - len(troubles) - sum(len(suite.cases) for suite in further),
        strict=strict,
    )
    most = MOST_BYTES // max(1, len(rows))
    if len(rows) < len(results):
        told = f"{counted(len(results))}, told in {len(rows)}; results.jsonl has each"
        properties = {**properties, "told-together": told}
    by_service: dict[str, list[Row]] = {}
    for row in rows:
        by_service.setdefault(row.service, []).append(row)
    suites = [
        Suite(
            service,
            [case_element(row, most, strict=strict) for row in own],
            _broken_rules((result for row in own for result in row.results), strict=strict),
        )
        for service, own in by_service.items()
    ]
    write_suites(path, [*suites, *further], properties, timestamp=timestamp, troubles=troubles)


def _broken_rules(results: Iterable[CaseResult], *, strict: bool) -> list[str]:
    broken = (result.broken_rules for result in results if is_failure(result, strict=strict))
    return sorted(set().union(*broken))


def case_element(row: Row, most: int, *, strict: bool) -> TestCase:
    """Return a row as an element that takes about ``most`` bytes at the utmost.

    The evidence of a failure is its text, that of any other case its output.
    """
    result = row.first
    evidence = shortened(_evidence(row), int(most * EVIDENCE))
    message = shortened(_message(row), int(most * MESSAGE))
    failed = is_failure(result, strict=strict)
    case = TestCase(
        row.name,
        classname=f"node-{result.node_id}.{row.service}",
        elapsed_sec=max(sum(each.duration for each in row.results), 1e-6),
        stdout=None if failed else evidence or None,
    )
    match result.verdict:
        case Verdict.BENCH_ERROR:
            case.add_error_info(message, evidence, result.verdict.value)
        case _ if failed:
            kind = result.verdict.value if result.verdict is Verdict.STALE else _kind(result)
            case.add_failure_info(message, evidence, kind)
        case Verdict.KNOWN_DEVIATION:
            case.add_skipped_info(f"{result.verdict.value}: {result.reason}")
        case Verdict.UNIMPLEMENTED | Verdict.NOT_TESTABLE | Verdict.NOT_RUN:
            case.add_skipped_info(f"{result.verdict.value}: {message}")
    return case


def _kind(result: CaseResult) -> str:
    """Return what stands as the type of a failure: the rule that was broken, where one is told."""
    return result.rule_of_cause or result.broken_rule or result.verdict.value


def _message(row: Row) -> str:
    message = row.first.actual or row.first.verdict.value
    return message if len(row.results) == 1 else f"{counted(len(row.results))}; {message}"


def _evidence(row: Row) -> str:
    """Return what is shown of a row: of several results how many, why, and the first of them."""
    first, last = row.first, row.results[-1]
    own = "" if first.verdict is Verdict.NOT_RUN else evidence_text(first)
    if len(row.results) == 1:
        return own
    reasons = Counter(result.reason or result.actual for result in row.results)
    lines = [f"{counted(len(row.results))}, from {first.case_id} to {last.case_id}"]
    lines += [
        f"{cases} of them: {reason}"
        for reason, cases in reasons.most_common(MOST_REASONS)
        if reason
    ]
    return "\n".join([*lines, "the first of them:", own])
