"""The observations of devices in the log of a run, if there is a log."""

from collections.abc import Container, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from conformance.reporting.bus_log import Place
from conformance.reporting.logged import frames_by_case
from conformance.reporting.page.profile import Choices, Chosen, sampled
from conformance.reporting.page.traffic import Traffic
from conformance.reporting.recorded import RecordedRun


@dataclass(frozen=True, slots=True)
class Observed:
    """The frames of the cases, and by node-ID lines of words on what the devices chose."""

    traffic: Traffic = field(default_factory=Traffic)
    profile: dict[int, Chosen] = field(default_factory=dict)


def observed(
    folder: Path,
    run: RecordedRun,
    *,
    in_words: Container[int] = (),
    beside: RecordedRun | None = None,
) -> Observed:
    """Read the log in a report folder; one that is not there has shown nothing. Raises OSError.

    The frames of cases with numbers ``in_words`` are put into words. Only cases that a run
    ``beside`` it has too count, where there is one: what other cases ask for, a device answers
    otherwise, and later.
    """
    places = run.places
    runs = [run] if beside is None else [run, beside]
    if beside is not None:
        shared = {result.case_id for result in beside.results}
        places = [
            place if result.case_id in shared else None
            for place, result in zip(run.places, run.results, strict=True)
        ]
    try:
        return _read(folder, run, places, in_words, sampled(*runs))
    except FileNotFoundError:
        return Observed()


def _read(
    folder: Path,
    run: RecordedRun,
    places: Sequence[Place | None],
    in_words: Container[int],
    judged: Container[str],
) -> Observed:
    """Read the frames of the cases with these places; those of ``judged`` cases show choices."""
    traffic, profile, channels = Traffic(), dict[int, Chosen](), run.channels
    node_ids = [result.node_id for result in run.results]
    for log in sorted({place.log for place in places if place is not None}):
        choices = Choices()
        traffic.commanding.clear()
        for number, lines in frames_by_case(folder, log, places, node_ids, channels):
            node_id = node_ids[number]
            traffic.take(number, node_id, channels[node_id], lines, in_words=number in in_words)
            if run.results[number].case_id in judged:
                choices.take(lines)
        for node_id, chosen in choices.profiles(node_ids).items():
            profile.setdefault(node_id, {}).update(chosen)
    return Observed(traffic, dict(sorted(profile.items())))
