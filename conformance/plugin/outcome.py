"""From a case's result to what pytest shows: an outcome, properties, and the evidence."""

from dataclasses import dataclass
from typing import NoReturn, Protocol

import pytest

from conformance.bus.errors import BenchError
from conformance.run.evidence import evidence_text
from conformance.run.verdict import CaseResult, Verdict


class CaseFailed(Exception):
    """A device broke a rule."""


class Terminal(Protocol):
    """What pytest hands a failure to print itself on."""

    def line(self, s: str = "", **markup: bool) -> None:
        """Print one line."""


class SummaryTerminal(Protocol):
    """The part of pytest's terminal reporter that the summary needs; old pytests export no type."""

    def ensure_newline(self) -> None:
        """Begin a new line, unless at the beginning of one."""

    def write(self, content: str, *, flush: bool = False, **markup: bool) -> None:
        """Print a part of a line."""

    def section(self, title: str, sep: str = "=", **markup: bool) -> None:
        """Print a heading."""

    def write_line(self, line: str, **markup: bool) -> None:
        """Print one line."""


@dataclass(frozen=True, slots=True)
class Crash:
    """The one line of a failure that summaries and JUnit files show."""

    message: str


class Evidence:
    """A failure as pytest prints it: the evidence instead of a traceback of the suite."""

    def __init__(self, result: CaseResult) -> None:
        """Take a result whose text is complete."""
        self._text = evidence_text(result)
        actual = result.actual.splitlines()[0] if result.actual else result.verdict.value
        expected = f"expected {result.expected}; got " if result.expected else ""
        self.reprcrash = Crash(expected + actual)

    def __str__(self) -> str:
        return self._text

    def toterminal(self, tw: Terminal) -> None:
        """Print the evidence."""
        for line in self._text.splitlines():
            tw.line(line)


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
        *([("cause", result.cause)] if result.cause else []),
        ("afterwards", result.afterwards.value),
        ("latency-ms", f"{result.latency * 1000:.3f}"),
        *([("examples", result.progress)] if result.progress else []),
        *(("note", note) for note in result.notes),
        ("trace", "\n".join(result.trace)),
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
    """Return for a case that passed; else raise what gives pytest the right outcome.

    A test of the user's own that fails by itself keeps its exception.
    """
    match result.verdict:
        case Verdict.NOT_TESTABLE | Verdict.UNIMPLEMENTED:
            _skip(result)
        case Verdict.BENCH_ERROR:
            raise error if isinstance(error, BenchError) else BenchError(result.actual)
        case Verdict.KNOWN_DEVIATION:
            pytest.xfail(result.reason)
            raise CaseFailed(result.case_id) from error  # pytest's --runxfail
        case Verdict.STALE:
            raise CaseFailed(result.case_id)
        case Verdict.FAIL if error is not None and not result.broken_rule:
            raise error
        case Verdict.FAIL:
            raise CaseFailed(result.case_id) from error
        case Verdict.NON_STRICT if strict:
            raise CaseFailed(result.case_id) from error


def _skip(result: CaseResult) -> NoReturn:
    pytest.skip(f"{result.verdict.value}: {result.actual}")
