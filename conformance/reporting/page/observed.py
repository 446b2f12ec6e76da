"""What the log of a run shows of its devices, where there is one."""

from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path

from conformance.reporting.page.profile import profiles
from conformance.reporting.page.traffic import Traffic, read_traffic
from conformance.reporting.recorded import RecordedRun


@dataclass(frozen=True, slots=True)
class Observed:
    """The frames of the cases, and by node-ID lines of words on what the devices chose."""

    traffic: Traffic = field(default_factory=Traffic)
    profile: dict[int, list[str]] = field(default_factory=dict)


def observed(folder: Path, run: RecordedRun, only: Collection[str] | None = None) -> Observed:
    """Read the log in a report folder; one that is not there has shown nothing. Raises OSError.

    ``only`` are the ids of the cases that count; None for all.
    """
    places = [
        place if only is None or result.case_id in only else None
        for place, result in zip(run.places, run.results, strict=True)
    ]
    node_ids = [result.node_id for result in run.results]
    try:
        return Observed(
            read_traffic(folder, places, node_ids, run.channels),
            profiles(folder, places, node_ids),
        )
    except FileNotFoundError:
        return Observed()
