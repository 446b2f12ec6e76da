"""What the devices of a run chose where the specification leaves a choice, as its log shows."""

from collections.abc import Sequence
from pathlib import Path

from conformance.logs.judging import LogJudge
from conformance.logs.reading import RecordedLog
from conformance.reporting.bus_log import Place

# To judge takes time; the choices show in the first frames of each kind of case.
MOST_FRAMES = 20_000
OF_A_CASE = 60


def profiles(
    folder: Path, places: Sequence[Place | None], node_ids: Sequence[int]
) -> dict[int, list[str]]:
    """Return lines of words for each node-ID, from the beginnings of cases; raises OSError."""
    chosen = _chosen(places)
    logs = {place.log for place in places if place is not None}
    found: dict[int, list[str]] = {}
    for name in sorted(logs):
        judge = LogJudge()
        for seen in RecordedLog(str(folder / name)):
            if seen.number in chosen:
                for _ in judge.take(seen):
                    pass
        for (_, node_id), channel in judge.channels.items():
            if node_id in node_ids:
                found.setdefault(node_id, []).extend(channel.oracle.profile.lines())
    return found


def _chosen(places: Sequence[Place | None]) -> set[int]:
    """Return the lines that are judged: whole short cases, spread over the run."""
    short = [
        place for place in places if place is not None and 0 < place.last - place.first < OF_A_CASE
    ]
    frames = sum(place.last - place.first + 1 for place in short)
    share = max(1, -(-frames // MOST_FRAMES))
    return {line for place in short[::share] for line in range(place.first, place.last + 1)}
