"""What became of each case between two runs, in sections, each by cause or reason."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from enum import Enum, auto
from functools import partial

from conformance.reporting.comparison.sides import Side, pairs
from conformance.run.verdict import CaseResult, Verdict


class Fate(Enum):
    """What a verdict says of the device."""

    WORKS = auto()
    FAILS = auto()
    REFUSED = auto()
    UNKNOWN = auto()


def _fate(result: CaseResult, *, strict: bool) -> Fate:
    match result.verdict:
        # A stale deviation has passed, although it is listed.
        case Verdict.PASS | Verdict.INFO | Verdict.STALE:
            return Fate.WORKS
        case Verdict.NON_STRICT:
            return Fate.FAILS if strict else Fate.WORKS
        case Verdict.FAIL | Verdict.KNOWN_DEVIATION:
            return Fate.FAILS
        case Verdict.UNIMPLEMENTED:
            return Fate.REFUSED
    return Fate.UNKNOWN


@dataclass(frozen=True, slots=True)
class CaseChange:
    """A case in both runs, or in one of them."""

    old: CaseResult | None
    new: CaseResult | None

    @property
    def latest(self) -> CaseResult:
        """The newest result that there is."""
        result = self.new or self.old
        assert result is not None  # noqa: S101 - one of the runs has it
        return result


@dataclass(frozen=True, slots=True)
class Group:
    """Cases that have changed for the same reason."""

    reason: str
    cases: list[CaseChange]


@dataclass(frozen=True, slots=True)
class Section:
    """A kind of change, and the cases that have changed so.

    ``worse`` is the name of a kind that a gate refuses, empty for any other.
    """

    title: str
    groups: list[Group]
    worse: str

    @property
    def number(self) -> int:
        """The number of cases."""
        return sum(len(group.cases) for group in self.groups)


class Change(Enum):
    """A kind of change: its title, and how a change for the worse is called."""

    BROKEN = "broken: passed before, fail now", "broken"
    REFUSED = "no longer served: passed before, refused now as unimplemented", "no longer served"
    FOUND = "fail now, were not tested before", ""
    WEAKER = "miss a SHOULD now", ""
    FIXED = "fixed: failed before, do not fail now", ""
    UNTESTED = "tested before, not tested now", ""
    ADDED = "only in the new run", ""
    GONE = "only in the old run", ""


def _change(old: CaseResult, new: CaseResult, *, strict: bool) -> Change | None:
    """Say what became of a case; None for nothing that anybody has to know."""
    before, after = (_fate(result, strict=strict) for result in (old, new))
    if before is after is Fate.WORKS:
        soft = (old.verdict, new.verdict)
        return Change.WEAKER if soft[1] is Verdict.NON_STRICT is not soft[0] else None
    if before is after:
        return None
    match after:
        case Fate.FAILS:
            # A cause fails the first case that meets it; in another run that may be another case.
            known = new.cause and new.cause in old.met
            if new.verdict is Verdict.KNOWN_DEVIATION or known:
                return None
            return Change.FOUND if before is Fate.UNKNOWN else Change.BROKEN
        case Fate.UNKNOWN:
            return Change.UNTESTED
        case Fate.REFUSED if before is Fate.WORKS:
            return Change.REFUSED
    return Change.FIXED if before is Fate.FAILS else None


def _reason(change: Change, case: CaseChange) -> str:
    """Return what the cases of a group have in common."""
    latest = case.latest
    match change:
        case Change.FIXED if case.old is not None:
            return str(case.old.cause or case.old.actual)
        case Change.ADDED | Change.GONE:
            return f"{latest.service}: {latest.verdict.value}"
        case Change.UNTESTED:
            return f"{latest.verdict.value}: {latest.cause or latest.actual}"
    return str(latest.cause or latest.actual)


def sections(old: Side, new: Side, *, strict: bool) -> list[Section]:
    """Return the changes that there are, what got worse first."""
    found: dict[Change, list[CaseChange]] = {}
    for change, case in _changes(old, new, strict=strict):
        found.setdefault(change, []).append(case)
    told = []
    for change in Change:
        if change in found:
            title, worse = change.value
            groups = _grouped(found[change], partial(_reason, change))
            told.append(Section(title, groups, worse))
    return told


def _changes(old: Side, new: Side, *, strict: bool) -> Iterator[tuple[Change, CaseChange]]:
    pair = pairs(old, new)
    before, after = old.results(), new.results()
    for (node_id, case_id), result in before.items():
        now = after.pop((pair.get(node_id, 0), case_id), None)
        if now is None:
            yield Change.GONE, CaseChange(result, None)
        elif change := _change(result, now, strict=strict):
            yield change, CaseChange(result, now)
    for result in after.values():
        yield Change.ADDED, CaseChange(None, result)


def _grouped(cases: Iterable[CaseChange], reason: Callable[[CaseChange], str]) -> list[Group]:
    """Return the groups, most cases first."""
    found: dict[str, list[CaseChange]] = {}
    for case in cases:
        found.setdefault(reason(case), []).append(case)
    groups = [Group(reason, own) for reason, own in found.items()]
    return sorted(groups, key=lambda group: len(group.cases), reverse=True)
