"""Whether a case that failed is tried again, as a frame may have been lost, and what comes of it.

What stays of a try that does not count is its trace.
"""

from conformance.device.effort import TRIES_OF_CASE
from conformance.run.case_run import CaseRun
from conformance.run.frame_loss import Stumble
from conformance.run.trace import TraceLine
from conformance.run.verdict import BREACHES, CaseResult, Verdict
from conformance.sdo.rules import NO_REBOOT

EACH_ELSEWHERE = (
    f"the case failed in {TRIES_OF_CASE} tries, each time at another place, as if frames were "
    "lost: no verdict is possible"
)


def stumble(run: CaseRun) -> Stumble | None:
    """Say how a case has failed where a frame that was lost may be why; else None.

    A cause that is known already is no chance, no such frame stops or starts a device, and none
    changes the data of a transfer that was confirmed. What only the suite's tidying has met counts
    as well: the run would fail for it.
    """
    result, session = run.result, run.session
    if not session.channel.link.may_lose or session.lost or result.verdict is Verdict.BENCH_ERROR:
        return None
    before = run.causes_before
    new = {cause: each for cause, each in session.causes if cause not in before}
    if result.verdict in BREACHES:
        known = {cause for cause, each in before.items() if not each.aside}
        cause = None if result.cause in known else result.cause
    else:
        cause = next((cause for cause, each in new.items() if each.aside), None)
    if cause in new and new[cause].violation.is_certain:
        return None
    if cause is None or cause.rule_id == NO_REBOOT.id or not session.doubts.excuses(str(cause)):
        return None
    return Stumble(cause, run.own_frames)


def take_back(run: CaseRun) -> None:
    """Let a case not have failed: it is tried again."""
    run.session.causes.return_to(run.causes_before)


def doubt(run: CaseRun, failed: CaseResult, stumbled: Stumble) -> None:
    """Take that a case did not fail again as it had failed, or stumbled, before.

    Where it failed all the same, each time at another place, nothing can be said of it.
    """
    result, session = run.result, run.session
    session.doubts.add(result.case_id, str(stumbled.cause))
    if result.verdict in BREACHES:
        result.verdict, result.cause = Verdict.NOT_TESTABLE, None
        result.broken_rule = result.broken_sentence = ""
        last = f"expected {result.expected}; got {result.actual}"
        result.notes.append(f"bench: the last of {TRIES_OF_CASE} tries failed: {last}")
        result.expected, result.actual = "", EACH_ELSEWHERE
        return
    if failed.verdict in BREACHES:
        met = f"{failed.broken} expected {failed.expected}; got {failed.actual}"
    else:
        met = str(stumbled.cause)
    result.notes.append(f"bench: the case failed once, but not when it was repeated: {met}")
    if result.verdict is Verdict.PASS:
        result.verdict = Verdict.INFO
    again = session.trace(run.own_frames, run.sdo.record.channels, aside=False, decisive=False)
    result.trace = [
        TraceLine("the try that failed:"),
        *failed.trace,
        TraceLine("the try that counts:"),
        *again.lines,
    ]
    result.decisive = None if failed.decisive is None else failed.decisive + 1
