"""Keeps the record of a run: in results.jsonl as it goes, and in memory for the reports."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from conformance.reporting.bus_log import Place, merge_logs
from conformance.reporting.page.observed import Observed
from conformance.reporting.page.writing import seen_in
from conformance.reporting.recorded import RecordedRun
from conformance.reporting.report import write_reports
from conformance.reporting.results import ResultsFile, now
from conformance.run.verdict import CaseResult


class Recorder:
    """Takes results. Lines that cannot be written are kept, and ``trouble`` says so."""

    def __init__(
        self, folder: Path, about: Mapping[str, Any], results: list[CaseResult], *, page: bool
    ) -> None:
        """Begin the record of a run; ``results`` is where they are kept in memory.

        ``page``: report.html is written in the end, beside junit.xml.
        """
        self._page = page
        self.run = RecordedRun(dict(about), results=results)
        self._folder = folder
        with suppress(OSError):  # the file says why it cannot be written
            folder.mkdir(parents=True, exist_ok=True)
        self._file = ResultsFile(folder)
        self._file.run(about)
        self._seen: Observed | None = None

    def selected(self, cases: int) -> None:
        """Take how many cases were selected, here or by another worker."""
        self.run.selected += cases
        self._file.selected(cases)

    def device(self, about: Mapping[str, Any]) -> None:
        """Take the description of a discovered device."""
        self.run.devices.append(dict(about))
        self._file.device(about)

    def case(self, result: CaseResult, place: Place | None = None) -> None:
        """Take the result of a case and where its frames are."""
        self.run.results.append(result)
        self.run.places.append(place)
        self._file.case(result, place)

    def merge(self, logs: list[Path], whole: Path) -> None:
        """Merge the logs of the workers; raises OSError.

        The frames of the page are read before: in the merged log the lines of a case lie apart.
        """
        if self._page:
            with suppress(OSError):  # the page tries again
                self._seen = seen_in(self._folder, self.run)
        wanted: dict[str, list[int]] = {}
        for place in self.run.places:
            if place is not None and place.first <= place.last:
                wanted.setdefault(place.log, []).extend((place.first, place.last))
        found = merge_logs(logs, whole, wanted)
        merged = {log.name for log in logs}
        self.run.places = [
            _moved(place, whole.name, found) if place is not None and place.log in merged else place
            for place in self.run.places
        ]
        self._file.merged(self.run.places)

    @property
    def trouble(self) -> str:
        """The files that could not be written so far; empty if there are none."""
        return self._file.trouble

    def end(self, about: Mapping[str, Any]) -> list[str]:
        """End the record and write the reports; return a sentence for each file that failed."""
        self.run.end = {"at": now(), **about}
        self._file.end(self.run.end)
        troubles = self._write_again() if self._file.close() else []
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            write_reports(self._folder, self.run, page=self._page, seen=self._seen)
        except OSError as error:
            troubles.append(f"The report cannot be written: {error}.")
        return troubles

    def _write_again(self) -> list[str]:
        """Write the whole record once more: the folder may have gone away, and come back."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            return [f"The report folder cannot be created: {error}."]
        run, file = self.run, ResultsFile(self._folder)
        file.run(run.about)
        for device in run.devices:
            file.device(device)
        file.selected(run.selected)
        for result, place in zip(run.results, run.places, strict=True):
            file.case(result, place)
        file.end(run.end or {})
        trouble = file.close()
        return [trouble] if trouble else []


def _moved(place: Place, log: str, found: Mapping[tuple[str, int], int]) -> Place:
    """Return where frames are in a log that was merged of others."""
    first, last = found.get((place.log, place.first), 1), found.get((place.log, place.last), 0)
    return Place(log, first, last, place.left_out, last + 1 - first - place.lines)


def as_place(values: dict[str, Any] | None) -> Place | None:
    """Return the place that another process has handed over as plain values."""
    return None if values is None else Place(**values)


def as_values(place: Place) -> dict[str, Any]:
    """Return a place as plain values."""
    return place._asdict()
