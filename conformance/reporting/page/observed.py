"""What the log of a run shows of its devices, where there is one."""

from dataclasses import dataclass, field
from pathlib import Path

from conformance.reporting.page.profile import profiles, sampled
from conformance.reporting.page.traffic import Traffic, read_traffic
from conformance.reporting.recorded import RecordedRun


@dataclass(frozen=True, slots=True)
class Observed:
    """The frames of the cases, and by node-ID lines of words on what the devices chose."""

    traffic: Traffic = field(default_factory=Traffic)
    profile: dict[int, list[str]] = field(default_factory=dict)


def observed(folder: Path, run: RecordedRun, beside: RecordedRun | None = None) -> Observed:
    """Read the log in a report folder; one that is not there has shown nothing. Raises OSError.

    Only cases that a run ``beside`` it has too count, where there is one: what other cases ask for,
    a device answers otherwise, and later.
    """
    places = run.places
    runs = [run] if beside is None else [run, beside]
    if beside is not None:
        shared = {result.case_id for result in beside.results}
        places = [
            place if result.case_id in shared else None
            for place, result in zip(run.places, run.results, strict=True)
        ]
    node_ids = [result.node_id for result in run.results]
    try:
        return Observed(
            read_traffic(folder, places, node_ids, run.channels),
            profiles(folder, run, sampled(*runs)),
        )
    except FileNotFoundError:
        return Observed()
