"""Whether a case that failed is tried again, as a frame may have been lost, and what comes of it.

What stays of a try that does not count is its trace.
"""

from conformance.run.doubts import MOST_TRIES, Stumble
from conformance.run.session import CaseRun
from conformance.run.verdict import BREACHES, CaseResult, Verdict
from conformance.sdo.rules import NO_REBOOT

EACH_ELSEWHERE = (
    f"it failed in {MOST_TRIES} tries, each time at another place, as where frames are lost: "
    "nothing can be said of it"
)


def stumble(run: CaseRun) -> Stumble | None:
    """Say how a case has failed where a frame that was lost may be why; else None.

    A cause that is known already is no chance, and no such frame stops or starts a device.
    """
    result, session = run.result, run.session
    known = {str(cause) for cause in run.causes_before}
    lossy = session.channel.link.may_lose and run.bench_error is None
    if not lossy or result.verdict not in BREACHES or result.cause in known:
        return None
    lost = session.lost or result.broken_rule_id == NO_REBOOT.id
    if lost or not session.doubts.excuses(result.cause):
        return None
    return Stumble(result.cause, run.own_frames)


def take_back(run: CaseRun) -> None:
    """Let a case not have failed: it is tried again."""
    run.session.causes.return_to(run.causes_before)


def doubt(run: CaseRun, failed: CaseResult) -> None:
    """Take that a case did not fail again as it had failed before.

    Where it failed all the same, each time at another place, nothing can be said of it.
    """
    result, session = run.result, run.session
    session.doubts.add(result.case_id, failed.cause)
    if result.verdict in BREACHES:
        take_back(run)
        result.verdict, result.broken_rule, result.cause = Verdict.NOT_TESTABLE, "", ""
        last = f"expected {result.expected}; got {result.actual}"
        result.notes.append(f"bench: the last of {MOST_TRIES} tries failed so: {last}")
        result.expected, result.actual = "", EACH_ELSEWHERE
        return
    result.notes.append(
        f"bench: it failed once and not when it was tried again: {failed.broken_rule} "
        f"expected {failed.expected}; got {failed.actual}"
    )
    if result.verdict is Verdict.PASS:
        result.verdict = Verdict.INFO
    again = session.trace(run.own_frames, run.sdo.channels, aside=False, decisive=False)
    result.trace = ["the try that failed:", *failed.trace, "the one that counts:", *again]
