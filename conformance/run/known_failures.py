"""Results by the list of known deviations: excused, stale, or neither."""

from collections.abc import Collection, Iterable, Sequence

from conformance.device.known_deviations import KnownDeviation
from conformance.dialogue.cause_of import GENERAL
from conformance.run.verdict import CaseResult, Verdict

# The verdicts of a case that was tried.
JUDGED = (
    Verdict.PASS,
    Verdict.NON_STRICT,
    Verdict.INFO,
    Verdict.FAIL,
    Verdict.KNOWN_DEVIATION,
    Verdict.STALE,
)
CUT_SHORT = (Verdict.NOT_RUN, Verdict.BENCH_ERROR)
# The verdicts of a failure; with one of these an entry is still needed.
MEETING = (Verdict.KNOWN_DEVIATION, Verdict.NON_STRICT, Verdict.NOT_TESTABLE)


def account(result: CaseResult, deviations: Sequence[KnownDeviation], *, strict: bool) -> None:
    """Change the verdict of a case that is listed.

    One that fails for the stated cause is a known deviation; one that is listed by its id and
    passes is stale. What fails for another cause, is skipped or is a bench error stays what it is.
    ``strict`` counts what misses a SHOULD as failed, as the run does.
    """
    listed = sorted(
        (known for known in deviations if known.names(result.case_id)),
        key=lambda known: known.breadth,
    )
    match result.verdict:
        case Verdict.FAIL:
            _excuse(result, listed)
        case Verdict.NON_STRICT if strict:
            _excuse(result, listed)
        case Verdict.PASS | Verdict.INFO:
            exact = next((known for known in listed if known.is_exact), None)
            if exact is not None:
                result.verdict = Verdict.STALE
                result.expected = f"the known deviation: {exact.reason}"
                result.actual = "the case passes: delete its entry from the known deviations"


def _excuse(result: CaseResult, listed: Sequence[KnownDeviation]) -> None:
    for known in listed:
        if known.excuses(result.case_id, result.broken_rules, result.tested_rules):
            result.verdict, result.reason = Verdict.KNOWN_DEVIATION, known.reason
            return
    broken = result.broken_rule or "this"
    result.notes += [
        f"listed as a known deviation from {known.rule or 'the rules that the case tests'} "
        f"({known.reason}), which does not excuse {broken}: if that is known as well, list it with "
        f'rule = "{broken}"'
        for known in listed
        if known.is_exact
    ]


# Entries for several cases


class Scope:
    """Which cases the entries for several of them are about.

    One with a glob is about those that it names. A rule alone is about the cases that test it; one
    that any case may break, or that no case tests, is about all of them.
    """

    def __init__(
        self, deviations: Iterable[KnownDeviation], tested: Iterable[Collection[str]]
    ) -> None:
        """``tested`` has the rules that each case of the run tests."""
        self.shared = [known for known in deviations if not known.is_exact]
        self._tested = {rule for rules in tested for rule in rules} - set(GENERAL)

    def is_about(self, known: KnownDeviation, case_id: str, tested: Collection[str]) -> bool:
        """Say whether an entry is about a case, which tests these rules."""
        if known.case is None and known.rule in self._tested:
            return known.rule in tested
        return known.names(case_id)


def stale_entries(
    deviations: Iterable[KnownDeviation],
    results: Sequence[CaseResult],
    *,
    partly: Collection[str] = (),
    beside: Collection[str] = (),
) -> list[KnownDeviation]:
    """Return the entries for several cases that excused nothing though all of them were run.

    ``partly`` names entries of which the run has left cases out, ``beside`` the rules that the
    device broke outside of all cases.
    """
    scope = Scope(deviations, [result.tested_rules for result in results])
    stale = []
    for known in scope.shared:
        about = [
            result
            for result in results
            if scope.is_about(known, result.case_id, result.tested_rules)
        ]
        if (
            str(known) not in partly
            and not (known.case is None and known.rule in beside)
            and any(result.verdict in JUDGED for result in about)
            and not any(result.verdict in CUT_SHORT for result in about)
            and not any(_meets(result, known) for result in results)
        ):
            stale.append(known)
    return stale


def _meets(result: CaseResult, known: KnownDeviation) -> bool:
    """Say whether a case has met the defect of an entry for certain."""
    if result.verdict not in MEETING:
        return False
    return bool(result.broken_rules) and known.excuses(
        result.case_id, result.broken_rules, result.tested_rules
    )
