"""A run as results.jsonl tells of it; that of a run that was killed ends anywhere."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from conformance.device.files import shown
from conformance.reporting.bus_log import Place
from conformance.reporting.record_shape import (
    WrongShape,
    check_about,
    check_device,
    check_end,
    check_selected,
    place_of,
    places_of,
    result_of,
)
from conformance.reporting.results import CASE, DEVICE, END, FORMAT, MERGED, RESULTS, RUN, SELECTED
from conformance.run.verdict import CaseResult, Verdict
from conformance.sdo.cob_id import ChannelIds

Values = dict[str, Any]
# What the texts of a device are, by their objects.
TEXT_NAMES = {
    "1008h:00": "device name (1008h)",
    "1009h:00": "hardware version (1009h)",
    "100Ah:00": "software version (100Ah)",
}
# A case has some kB, one of a long conversation a MB.
LONGEST_LINE = 64 * 2**20


class NotRecorded(ValueError):
    """There is no record of a run, or one that this version cannot read; says which and why."""


@dataclass(slots=True)
class RecordedRun:
    """What is known of a run: itself, its devices, its results, and how it has ended.

    ``places`` say for each result where its frames are, if that is known. ``end`` is None for a run
    that has none. ``selected`` is the number of cases, 0 where it is not known.
    """

    about: Values
    devices: list[Values] = field(default_factory=list)
    results: list[CaseResult] = field(default_factory=list)
    places: list[Place | None] = field(default_factory=list)
    selected: int = 0
    end: Values | None = None

    @property
    def properties(self) -> dict[str, str]:
        """What describes the run and its devices in every report."""
        parts = [self.about, *self.devices, *([] if self.end is None else [self.end])]
        return {name: text for part in parts for name, text in part["properties"].items()}

    @property
    def channels(self) -> dict[int, ChannelIds]:
        """The SDO channel of each device; of one that was never met the default one."""
        channels = {node_id: ChannelIds.default(node_id) for node_id in self.about["node_ids"]}
        named = {device["node_id"]: device["sdo_channel"] for device in self.devices}
        return channels | {node_id: ChannelIds.parse(text) for node_id, text in named.items()}

    @property
    def by_device(self) -> list[CaseResult]:
        """The results, device by device."""
        node_ids = self.about["node_ids"]
        return sorted(self.results, key=lambda result: node_ids.index(result.node_id))

    @property
    def broken_off(self) -> str:
        """How a run broke off that has no end; empty for one that has."""
        if self.end is not None:
            return ""
        of_all = f" of {self.selected}" if self.selected else ""
        cases = len(self.results)
        return (
            f"the run was killed: its record has no end. {cases}{of_all} "
            f"{'case was' if cases == 1 and not of_all else 'cases were'} finished"
        )

    @property
    def troubles(self) -> list[str]:
        """Why the results are not all that was asked for, as far as none of them says so."""
        if self.end is None:
            return [self.broken_off]
        if any(result.verdict is Verdict.BENCH_ERROR for result in self.results):
            return []
        return list(dict.fromkeys(self.end["bench_errors"]))


def read_run(folder: Path) -> RecordedRun:
    """Read the record in a report folder; raises NotRecorded.

    A last line that was not written to its end is none.
    """
    path = folder / RESULTS
    lines = _lines(path)
    about = next(lines, None)
    if about is None or about.get("record") != RUN:
        raise NotRecorded(f"{path} does not begin with a line about the run.")
    if about.get("format") != FORMAT:
        found = shown(about.get("format")).strip("'")
        raise NotRecorded(f"{path} has format {found}; this version reads {FORMAT}.")
    try:
        check_about(about)
    except WrongShape as error:
        raise NotRecorded(f"{path}, line 1 does not say what was tested: {error}.") from error
    run = RecordedRun(about)
    for number, values in enumerate(lines, start=2):
        try:
            _take(run, values)
        except ValueError as error:
            raise NotRecorded(f"{path}, line {number} cannot be read: {error}.") from error
    if len(run.places) != len(run.results):
        raise NotRecorded(f"{path} names frames of {len(run.places)} cases and has another number.")
    return run


def _take(run: RecordedRun, values: Values) -> None:
    record, node_ids = values.get("record"), run.about["node_ids"]
    if record == DEVICE:
        check_device(values, node_ids)
        run.devices.append(values)
    elif record == SELECTED:
        check_selected(values)
        run.selected += values["cases"]
    elif record == CASE:
        run.results.append(result_of(values, node_ids))
        run.places.append(place_of(values.get("frames")))
    elif record == MERGED:
        run.places = places_of(values)
    elif record == END:
        check_end(values)
        run.end = values


def _lines(path: Path) -> Iterator[Values]:
    try:
        with path.open("rb") as file:
            number = 0
            # What stands behind the last end of a line was not written to its end.
            while (line := file.readline(LONGEST_LINE)).endswith(b"\n"):
                number += 1
                yield _values(path, number, line)
            if len(line) >= LONGEST_LINE:
                raise NotRecorded(f"{path}, line {number + 1} has more than {LONGEST_LINE} bytes.")
    except OSError as error:
        raise NotRecorded(f"There is no record of a run: {error}.") from error


def _values(path: Path, number: int, line: bytes) -> Values:
    try:
        values = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise NotRecorded(f"{path}, line {number} is no line of a record: {error}.") from error
    if not isinstance(values, dict):
        raise NotRecorded(f"{path}, line {number} is no line of a record.")
    return values
