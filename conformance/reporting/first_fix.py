"""Which cause to begin with, and why."""

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from conformance.logs.reading import RecordedLog
from conformance.logs.replay_plan import NotReplayed, read_plan
from conformance.reporting.cause_counts import CauseCount
from conformance.reporting.reproduction import LOG, reproductions
from conformance.reporting.summary import counted
from conformance.sdo.rules import RULES_BY_ID, Cause, cited


@dataclass(frozen=True, slots=True)
class FirstFix:
    """A cause, why to begin with it, the ``case_id`` that shows it, and the command that does.

    ``replay`` is empty where the frames are not known.
    """

    cause: Cause
    why: list[str]
    case_id: str
    replay: str


def first_fix(
    causes: Sequence[CauseCount], folder: Path, bus: Sequence[str] = (), *, within: bool = False
) -> FirstFix:
    """Return the cause with the most cases behind it on all devices; there has to be a cause.

    The other parameters are those of ``replay_command``.
    """
    behind: dict[Cause, list[CauseCount]] = {}
    for count in causes:
        behind.setdefault(count.cause, []).append(count)
    cause = max(behind, key=lambda each: sum(len(count.cases) for count in behind[each]))
    counts = behind[cause]
    first = counts[0]
    why = [_share(counts, sum(len(count.failed) for count in causes))]
    if len(counts) > 1:
        why.append(f"on {len(counts)} devices: nodes {_listed(count.node_id for count in counts)}")
    rule = RULES_BY_ID.get(cause.rule_id)
    if rule is not None:
        why.append(f"{rule.level}, {cited(rule.clause)}: {rule.sentence}")
    replay = replay_command(folder, causes.index(first) + 1, first, bus, within=within)
    return FirstFix(cause, why, first.cases[0].case_id, replay)


def _listed(numbers: Iterable[int]) -> str:
    return ", ".join(map(str, numbers))


def replay_command(
    folder: Path,
    number: int,
    count: CauseCount,
    bus: Sequence[str] = (),
    *,
    within: bool = False,
) -> str:
    """Return the command that sends again the frames of a cause; empty if there is no log to send.

    ``folder`` is that of the reports, ``number`` that of the cause in them, ``bus`` are the options
    that name the bus. The command is for who stands ``within`` the folder, or where the path of the
    folder begins.
    """
    logs = [path for path in reproductions(folder, number, count) if path.suffix == LOG]
    if not logs:
        return ""
    try:
        changes = read_plan(RecordedLog(str(logs[0])), None).changes
    except NotReplayed:
        return ""
    log = logs[0].relative_to(folder) if within else logs[0]
    return shlex.join(["conformance", "replay", str(log), *bus, *(["--writes"] if changes else [])])


def _share(counts: Sequence[CauseCount], failures: int) -> str:
    """Say how many of all ``failures`` a cause has, and what it hides."""
    failed = sum(len(count.failed) for count in counts)
    kept_away = sum(len(count.kept_away) for count in counts)
    share = f"all {failures}" if failed == failures else f"{failed} of {failures}"
    only = "the only failure" if failures == 1 else f"{share} failures"
    parts = [only] if failed else []
    parts += [f"{counted(kept_away)} cannot be tested before it is gone"] if kept_away else []
    return ", and ".join(parts)
