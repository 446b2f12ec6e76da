"""What the list of known deviations makes of results: excused, stale, or neither."""

from collections.abc import Iterable, Sequence

from conformance.device.known_deviations import NO_REASON, Deviation
from conformance.run.verdict import CaseResult, Verdict


def account(result: CaseResult, deviations: Sequence[Deviation], *, strict: bool) -> None:
    """Change the verdict of a case that is listed.

    One that fails for the stated cause is a known deviation; one that passes is stale. What fails
    for another cause, is skipped or is a bench error stays what it is. ``strict`` counts what
    misses a SHOULD as failed, as the run does.
    """
    deviation = next((known for known in deviations if known.case == result.case_id), None)
    if deviation is None:
        return
    match result.verdict:
        case Verdict.FAIL:
            _excuse(result, deviation)
        case Verdict.NON_STRICT if strict:
            _excuse(result, deviation)
        case Verdict.PASS | Verdict.INFO:
            result.verdict = Verdict.STALE
            result.expected = f"the known deviation: {deviation.reason}"
            result.actual = "the case passes: delete its entry from the known deviations"


def _excuse(result: CaseResult, deviation: Deviation) -> None:
    if deviation.rule is not None and deviation.rule != result.broken_rule_id:
        result.notes.append(
            f"listed as a known deviation from {deviation.rule} ({deviation.reason}), "
            f"which does not excuse {result.broken_rule_id or 'this'}"
        )
        return
    result.verdict, result.reason = Verdict.KNOWN_DEVIATION, deviation.reason


def draft(results: Iterable[CaseResult], *, strict: bool) -> list[Deviation]:
    """Return the list that would excuse each failure of a run, with the reasons known already.

    A case that broke different rules on different devices is listed without its rule.
    """
    failed = {Verdict.FAIL, Verdict.KNOWN_DEVIATION} | ({Verdict.NON_STRICT} if strict else set())
    found: dict[str, Deviation] = {}
    for result in results:
        if result.verdict not in failed:
            continue
        rule = result.broken_rule_id or None
        known = found.get(result.case_id)
        if known is not None and known.rule != rule:
            rule = None
        found[result.case_id] = Deviation(result.case_id, result.reason or NO_REASON, rule)
    return list(found.values())
