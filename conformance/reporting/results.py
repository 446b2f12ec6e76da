"""results.jsonl: what a run finds, line by line, each as soon as it is known.

The first line is about the run, then comes one for each device before its first case, one for each
case as it ends, and a last one that says how the run has ended. A run that was killed lacks that.
Behind several workers there is one more, which says where the frames of each case are now.
Each line is an object; ``record`` says which kind.
"""

import json
import time
from collections.abc import Mapping, Sequence
from datetime import datetime, tzinfo
from functools import lru_cache
from pathlib import Path
from typing import Any

from conformance.reporting.appending import GrowingFile
from conformance.reporting.bus_log import Place
from conformance.run.verdict import CaseResult

RESULTS = "results.jsonl"
FORMAT = 3
# Clocks are put forward and back at the end of such a time, if at all.
ZONE_SECONDS = 900
RUN, SELECTED, DEVICE, CASE, MERGED, END = "run", "selected", "device", "case", "merged", "end"


def now() -> str:
    """Return the time of day with its zone."""
    seconds = time.time()
    zone = _zone(int(seconds // ZONE_SECONDS))
    return datetime.fromtimestamp(seconds, zone).isoformat(timespec="milliseconds")


@lru_cache(1)
def _zone(part: int) -> tzinfo | None:
    """Return the zone of this machine: to find it takes longer than all else about a line."""
    return datetime.fromtimestamp(part * ZONE_SECONDS).astimezone().tzinfo


class ResultsFile:
    """Writes results.jsonl; ``trouble`` says why a part of it could not be written."""

    def __init__(self, folder: Path) -> None:
        """Begin the file, in a folder that there is."""
        self._file = GrowingFile(folder / RESULTS)

    @property
    def trouble(self) -> str:
        """What could not be written so far, and why; empty when all is there."""
        return self._file.trouble

    def run(self, about: Mapping[str, Any]) -> None:
        """Write the first line."""
        self._write(RUN, {"format": FORMAT, **about})

    def selected(self, cases: int) -> None:
        """Write how many cases have been selected, by this process or another worker."""
        self._write(SELECTED, {"cases": cases})

    def device(self, about: Mapping[str, Any]) -> None:
        """Write what is known of a device before its first case."""
        self._write(DEVICE, about)

    def case(self, result: CaseResult, place: Place | None = None) -> None:
        """Write the result of a case, and where its frames are."""
        frames = {} if place is None else {"frames": place._asdict()}
        self._write(CASE, {"at": now(), **frames, "result": result.as_dict()})

    def merged(self, places: Sequence[Place | None]) -> None:
        """Write where the frames of each case, in their order, are in the log of all workers."""
        frames = [None if place is None else place._asdict() for place in places]
        self._write(MERGED, {"frames": frames})

    def end(self, about: Mapping[str, Any]) -> None:
        """Write the last line."""
        self._write(END, {"at": now(), **about})

    def close(self) -> str:
        """Finish the file; return its ``trouble``."""
        return self._file.close()

    def _write(self, record: str, values: Mapping[str, Any]) -> None:
        line = json.dumps({"record": record, **values}, ensure_ascii=True)
        self._file.append(line.encode("ascii") + b"\n")
