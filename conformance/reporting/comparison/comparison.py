"""All that has changed between two runs, and whether anything got worse."""

from functools import cached_property

from conformance.reporting.cause_counts import CauseCount
from conformance.reporting.comparison import differences
from conformance.reporting.comparison.cases import Section, sections
from conformance.reporting.comparison.sides import Side, pairs
from conformance.reporting.page.observed import observed
from conformance.reporting.summary import counted
from conformance.run.verdict import Verdict

# What shows that a cause is gone, where none of its cases meets it again.
TESTED = (Verdict.PASS, Verdict.INFO, Verdict.NON_STRICT, Verdict.STALE, Verdict.UNIMPLEMENTED)


class Comparison:
    """Two runs side by side. What is strict in the new one is so in both."""

    def __init__(self, old: Side, new: Side) -> None:
        """Compare the devices with the same node-ID, or the only one of each run.

        Raises OSError when a log cannot be read.
        """
        self.old = old
        self.new = new
        strict = bool(new.run.about["strict"])
        self.alone = len(old.node_ids) == len(new.node_ids) == 1
        self.sections: list[Section] = sections(old, new, strict=strict)
        self.devices = differences.devices(old, new)
        self.options = differences.options(old, new)
        self._pairs = pairs(old, new)
        before = observed(old.folder, old.run, beside=new.run)
        after = observed(new.folder, new.run, beside=old.run)
        self.profile = differences.profile(self._pairs, before.profile, after.profile)
        self.times = differences.times(before.traffic.times, after.traffic.times)
        self.old_causes = old.causes(strict=strict)
        self.causes = new.causes(strict=strict)

    @cached_property
    def new_causes(self) -> list[CauseCount]:
        """Return the causes that no case of the old run has met."""
        seen = {(self._pairs.get(node_id), cause) for node_id, cause in self.old.seen_causes()}
        compared = set(self._pairs.values())
        return [
            count
            for count in self.causes
            if count.node_id in compared and (count.node_id, count.cause) not in seen
        ]

    @cached_property
    def gone_causes(self) -> list[CauseCount]:
        """Return the causes that no case has met again, of those whose cases do not fail now."""
        return [count for count in self._not_met if self._is_tested(count)]

    @cached_property
    def untested_causes(self) -> list[CauseCount]:
        """Return the causes of which the new run says nothing: their cases were not tested."""
        return [count for count in self._not_met if not self._is_tested(count)]

    @cached_property
    def _not_met(self) -> list[CauseCount]:
        seen = self.new.seen_causes()
        return [
            count
            for count in self.old_causes
            if (self._pairs.get(count.node_id), count.cause) not in seen
        ]

    def _is_tested(self, count: CauseCount) -> bool:
        after = self.new.results()
        node_id = self._pairs.get(count.node_id, 0)
        now = (after.get((node_id, result.case_id)) for result in count.failed)
        return any(result is not None and result.verdict in TESTED for result in now)

    @property
    def worse(self) -> list[str]:
        """Say what got worse; nothing if nothing did."""
        told = [
            f"{counted(section.number)} {section.worse}"
            for section in self.sections
            if section.worse
        ]
        if self.new_causes:
            number = len(self.new_causes)
            told.append(f"{number} new {'cause' if number == 1 else 'causes'}")
        if self.new.broken_off:
            told.append(f"the new run is not whole: {self.new.broken_off}")
        return told

    @property
    def slower(self) -> list[differences.TimesOfKind]:
        """Return the kinds of requests that are answered clearly later than before."""
        return [each for each in self.times if each.slower]

    @property
    def sentence(self) -> str:
        """The result in one sentence."""
        return f"worse: {'; '.join(self.worse)}" if self.worse else "nothing got worse"
