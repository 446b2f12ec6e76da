"""The choices of the devices of a run where CiA 301 leaves one, from its log."""

from collections.abc import Collection, Sequence

from conformance.logs.judging import LogJudge
from conformance.logs.reading import Seen
from conformance.reporting.logged import Logged
from conformance.reporting.recorded import RecordedRun
from conformance.sdo.can_frame import CanFrame

# To judge takes time; the choices show in the first frames of each kind of case.
MOST_FRAMES = 20_000
OF_A_CASE = 60
# The choices of a device, by their matters.
Chosen = dict[str, list[str]]


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
        frames = 0 if place is None else place.lines
        if frames > OF_A_CASE:
            long.add(result.case_id)
        elif frames > 1:
            found[result.case_id] = found.get(result.case_id, 0) + frames
    return {case_id: frames for case_id, frames in found.items() if case_id not in long}


class Choices:
    """Judges the frames of cases, to learn what each device chose."""

    def __init__(self) -> None:
        """Know nothing yet."""
        self._judge = LogJudge()

    def take(self, lines: Sequence[Logged]) -> None:
        """Take the frames of a case, behind those of the cases before on its channel."""
        for logged in lines:
            frame = CanFrame.parse(logged.frame)
            if frame.fd:
                continue
            for _ in self._judge.take(
                Seen(logged.number, logged.time, logged.bus, frame, logged.sent)
            ):
                pass

    def profiles(self, node_ids: Collection[int]) -> dict[int, Chosen]:
        """Return the choices of each of these nodes that was met, by their matters."""
        found: dict[int, Chosen] = {}
        for (_, node_id), channel in self._judge.channels.items():
            if node_id in node_ids:
                found.setdefault(node_id, {}).update(channel.oracle.profile.choices())
        return found
