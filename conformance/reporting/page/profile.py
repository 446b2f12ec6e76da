"""What the devices of a run chose where the specification leaves a choice, as its log shows."""

from collections.abc import Collection
from pathlib import Path

from conformance.logs.judging import LogJudge
from conformance.logs.reading import RecordedLog
from conformance.reporting.logged import log_in
from conformance.reporting.recorded import RecordedRun

# To judge takes time; the choices show in the first frames of each kind of case.
MOST_FRAMES = 20_000
OF_A_CASE = 60


def sampled(*runs: RecordedRun) -> set[str]:
    """Return the ids of the cases that are judged: short in each of the runs, spread over them."""
    frames = [_frames_of_short_cases(run) for run in runs]
    shared = sorted(set.intersection(*(set(each) for each in frames)))
    most = max(sum(each[case_id] for case_id in shared) for each in frames)
    return set(shared[:: max(1, -(-most // MOST_FRAMES))])


def _frames_of_short_cases(run: RecordedRun) -> dict[str, int]:
    """Return the number of frames of each case that is short on every device."""
    found: dict[str, int] = {}
    long: set[str] = set()
    for result, place in zip(run.results, run.places, strict=True):
        frames = 0 if place is None else place.last - place.first
        if frames >= OF_A_CASE:
            long.add(result.case_id)
        elif frames > 0:
            found[result.case_id] = found.get(result.case_id, 0) + frames + 1
    return {case_id: frames for case_id, frames in found.items() if case_id not in long}


def profiles(folder: Path, run: RecordedRun, cases: Collection[str]) -> dict[int, list[str]]:
    """Return lines of words for each node-ID, as some cases have shown it; raises OSError."""
    places = [
        place
        for result, place in zip(run.results, run.places, strict=True)
        if place is not None and result.case_id in cases
    ]
    node_ids = {result.node_id for result in run.results}
    found: dict[int, list[str]] = {}
    for name in sorted({place.log for place in places}):
        own = (place for place in places if place.log == name)
        chosen = {line for place in own for line in range(place.first, place.last + 1)}
        judge = LogJudge()
        for seen in RecordedLog(str(log_in(folder, name)), chosen):
            for _ in judge.take(seen):
                pass
        for (_, node_id), channel in judge.channels.items():
            if node_id in node_ids:
                found.setdefault(node_id, []).extend(channel.oracle.profile.lines())
    return found
