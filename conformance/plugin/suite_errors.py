"""Errors of the suite's own program: they are reported as such, never as the device's."""

import traceback
from pathlib import Path

import pytest

from conformance.bus.errors import BenchError, CaseEnded, SuiteError
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.dialogue.pauses import NOT_JUDGED
from conformance.plugin.items import CaseFunction
from conformance.run.case_files import CASES
from conformance.run.case_run import CaseRun
from conformance.run.verdict import BREACHES, CaseResult, Verdict
from conformance.sdo.checks import ServerAborted
from conformance.sdo.rules import Violation

# The exceptions by which a case ends in good order.
OUTCOMES = (
    Violation,
    ServerAborted,
    NotTestable,
    Unimplemented,
    BenchError,
    pytest.skip.Exception,
    pytest.xfail.Exception,
)
_PACKAGE = Path(__file__).parents[1]


def is_own_case(item: pytest.Item) -> bool:
    """Say whether an item is a case of the suite, as opposed to one of the user's."""
    return isinstance(item, CaseFunction) and item.is_own


def conclude(item: pytest.Item, run: CaseRun, error: BaseException | None) -> CaseResult:
    """Conclude a case that ended with ``error``, if with any.

    Any exception of a user's test is its failure. Of a case of the suite, an exception beside its
    outcomes is an error of the suite, and so is any exception while a case is concluded.
    """
    if isinstance(error, pytest.fail.Exception) and is_own_case(item):
        error = run.bench_error = _ended(error)
    elif error is not None and is_own_case(item) and not isinstance(error, OUTCOMES):
        error = run.bench_error = suite_error(error)
    pauses, breach = run.sdo.wire.pauses, isinstance(error, Violation | ServerAborted)
    if breach and pauses.excuse:
        pauses.notes.append(f"bench: the case ended with: {error}")
        error, breach = pauses.not_judged(), False
    try:
        result = run.conclude(error)
    except pytest.fail.Exception as ended:
        return run.give_up(_ended(ended))
    except Exception as unforeseen:
        return run.give_up(suite_error(unforeseen))
    if not breach and result.verdict in BREACHES and pauses.excuse:
        _take_back(result)
    result.notes += pauses.notes
    return result


def _ended(error: BaseException) -> CaseEnded:
    """Describe an end that no case of the suite has by itself: a plugin has ended it."""
    return CaseEnded(
        f"Another plugin of pytest ended the case: {error} This says nothing of the device. A "
        "time-out for each test has to allow for all requests of a case and for a silence."
    )


def _take_back(result: CaseResult) -> None:
    """Take back a breach that was found when a case was over and the bench had not been running."""
    result.notes.append(
        f"bench: the case ended with: {result.broken} "
        f"expected {result.expected}; got {result.actual}"
    )
    result.verdict, result.actual = Verdict.NOT_TESTABLE, NOT_JUDGED
    result.broken_rule = result.broken_sentence = result.expected = ""
    result.cause = None


def suite_error(error: BaseException) -> SuiteError:
    """Describe an error of the suite by its kind and place; the same each time that it comes."""
    found = SuiteError(
        f"The suite itself has an error: {_in_words(error)}. This does not count against the "
        "device. Please report it, with the traceback of the case."
    )
    found.__cause__ = error
    return found


def comes_from_here(error: BaseException) -> bool:
    """Say whether the suite's own code had a part in an error."""
    files = (Path(frame.filename) for frame in traceback.extract_tb(error.__traceback__))
    return any(file.is_relative_to(_PACKAGE) or file.is_relative_to(CASES) for file in files)


def traceback_of(error: SuiteError) -> str:
    """Return the traceback of an error of the suite."""
    return "".join(traceback.format_exception(error.__cause__)).rstrip()


def _in_words(error: BaseException) -> str:
    words = f"{type(error).__name__}: {error}".rstrip(": ")
    frames = traceback.extract_tb(error.__traceback__)
    if not frames:
        return words
    last = frames[-1]
    return f"{words} ({Path(last.filename).name}, line {last.lineno}, in {last.name})"
