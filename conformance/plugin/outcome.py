"""From a case's result to pytest's outcome and properties."""

from typing import NoReturn

import pytest

from conformance.bus.errors import BenchError
from conformance.plugin.failure import CaseFailed
from conformance.run.evidence import trace_texts
from conformance.run.verdict import CaseResult, Verdict


def attach(item: pytest.Item, result: CaseResult) -> None:
    """Give the item the properties that ``--junitxml`` writes for it."""
    item.user_properties += [
        ("id", result.case_id),
        ("node-id", str(result.node_id)),
        ("clause", result.clause),
        ("level", result.level),
        ("rules", " ".join(result.rules)),
        ("verdict", result.verdict.value),
        ("requirement", result.requirement),
        ("expected", result.expected),
        ("actual", result.actual),
        *([("cause", str(result.cause))] if result.cause else []),
        ("afterwards", result.afterwards.value),
        ("latency-ms", f"{result.latency * 1000:.3f}"),
        *([("examples", result.progress)] if result.progress else []),
        *(("note", note) for note in result.notes),
        ("trace", "\n".join(trace_texts(result))),
    ]


def attach_not_run(item: pytest.Item, result: CaseResult) -> None:
    """Give an item that was left out the properties that ``--junitxml`` writes."""
    item.user_properties += [
        ("id", result.case_id),
        ("node-id", str(result.node_id)),
        ("verdict", result.verdict.value),
        ("actual", result.actual),
    ]


def end_with(result: CaseResult, error: BaseException | None, *, strict: bool) -> None:
    """Return for a case that passed; else raise the exception of its outcome.

    A test of the user's own that fails by itself keeps its exception.
    """
    match result.verdict:
        case Verdict.NOT_TESTABLE | Verdict.UNIMPLEMENTED:
            _skip(result)
        case Verdict.BENCH_ERROR:
            raise error if isinstance(error, BenchError) else BenchError(result.actual)
        case Verdict.KNOWN_DEVIATION:
            pytest.xfail(result.reason)
            raise CaseFailed(result) from error  # pytest's --runxfail
        case Verdict.STALE:
            raise CaseFailed(result)
        case Verdict.FAIL if error is not None and not result.broken_rule:
            raise error
        case Verdict.FAIL:
            raise CaseFailed(result) from error
        case Verdict.NON_STRICT if strict:
            raise CaseFailed(result) from error


def _skip(result: CaseResult) -> NoReturn:
    pytest.skip(f"{result.verdict.value}: {result.actual}")
