"""The two runs that are compared: each with its record, and their devices in pairs."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from conformance.reporting.cause_counts import CauseCount, counted_causes
from conformance.reporting.recorded import RecordedRun, read_run
from conformance.reporting.summary import verdict_counts
from conformance.run.verdict import CaseResult
from conformance.sdo.rules import Cause

# Of a run in which every case was tested: it passed, or a case failed.
WHOLE = (0, 1)


@dataclass(frozen=True, slots=True)
class Side:
    """One of two runs: where it was read, and its record."""

    folder: Path
    run: RecordedRun

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Read a report folder; raises NotRecorded."""
        return cls(folder, read_run(folder))

    @property
    def node_ids(self) -> list[int]:
        """The node-IDs that were tested."""
        return list(self.run.about["node_ids"])

    @property
    def broken_off(self) -> str:
        """Why the run says less than it was to say; empty for one that was whole."""
        end = self.run.end
        if end is None:
            return self.run.broken_off
        if end["exit_status"] in WHOLE:
            return ""
        return "; ".join((f"it ended with exit status {end['exit_status']}", *self.run.troubles))

    @property
    def counts(self) -> str:
        """The number of each verdict."""
        return ", ".join(verdict_counts(self.run.results)) or "no case was run"

    def device(self, node_id: int) -> dict[str, Any]:
        """Return what the record says of a device; nothing of one that was never met."""
        found = (each for each in self.run.devices if each["node_id"] == node_id)
        return next(found, {"identity": {}, "texts": {}})

    def results(self) -> dict[tuple[int, str], CaseResult]:
        """Return the results by node-ID and case."""
        return {(result.node_id, result.case_id): result for result in self.run.results}

    def causes(self, *, strict: bool) -> list[CauseCount]:
        """Return the causes for which cases have failed."""
        return [count for count in counted_causes(self.run.results, strict=strict) if count.failed]

    def seen_causes(self) -> set[tuple[int, Cause]]:
        """Return every cause that a case has met, also on its way to another point."""
        return {
            (result.node_id, cause)
            for result in self.run.results
            for cause in (result.cause, *result.met)
            if cause is not None
        }


def pairs(old: Side, new: Side) -> dict[int, int]:
    """Return the new node-ID for each old one: a single device may have changed its own."""
    if len(old.node_ids) == len(new.node_ids) == 1:
        return dict(zip(old.node_ids, new.node_ids, strict=True))
    return {node_id: node_id for node_id in old.node_ids if node_id in new.node_ids}
