"""not-restored.jsonl: what a run has changed and not put back, with the values of before, whole.

Each change is written before it is made. A run that was killed leaves the file; one that has put
everything back removes it. While the run lives it holds a lock on the file.
"""

import json
import sys
from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

from conformance.bus.channel import Channel
from conformance.bus.opening import BusSettings
from conformance.device.change_journal import LeftBehind
from conformance.reporting.appending import GrowingFile
from conformance.run.restore_command import put_back

if sys.platform == "win32":  # its locks would keep others from reading the file

    def _hold(file: BinaryIO) -> None:
        del file

    def _is_held(path: Path) -> bool:
        del path
        return False

else:
    import fcntl

    def _hold(file: BinaryIO) -> None:
        fcntl.flock(file, fcntl.LOCK_EX)  # those who look let go of it at once

    def _is_held(path: Path) -> bool:
        try:
            with path.open("rb") as file:
                # Several may look at the same time.
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except OSError:
            return True
        return False


NAME = "not-restored"
RUN, DEVICE = "run", "device"
Values = dict[str, Any]
_OF_A_RUN = frozenset(("interface", "channel", "bitrate", "options", "self_test"))


class Journal:
    """Takes the changes of all devices of a process. The file is made with the first of them."""

    def __init__(self, path: Path, bus: BusSettings, *, self_test: bool) -> None:
        """``bus`` is where the devices are."""
        self._path = path
        self._about = {
            "record": RUN,
            "interface": bus.interface,
            "channel": bus.channel,
            "bitrate": bus.bitrate,
            "options": dict(bus.options),
            "self_test": self_test,
        }
        self._file: GrowingFile | None = None
        self._lock: BinaryIO | None = None
        self._left: dict[int, LeftBehind] = {}

    def tell(self, about: LeftBehind, record: Values) -> None:
        """Write a line on a device; it is in the hands of the operating system then."""
        if self._file is None:
            self._file = GrowingFile(self._path)
            self._write(self._about)
            with suppress(OSError):
                self._lock = self._path.open("rb")
                _hold(self._lock)
        if about.node_id not in self._left:
            self._left[about.node_id] = about
            self._write(
                {
                    "record": DEVICE,
                    "node_id": about.node_id,
                    "sdo_channel": about.channel,
                    "identity": about.identity,
                }
            )
        self._left[about.node_id].take(record)
        self._write({**record, "node_id": about.node_id})

    def close(self) -> str:
        """Remove the file if all is back; return what could not be written, empty for nothing."""
        if self._lock is not None:
            self._lock.close()
        if self._file is None:
            return ""
        trouble = self._file.close()
        if all(left.is_all_back for left in self._left.values()):
            self._path.unlink(missing_ok=True)
            return ""
        return trouble

    def _write(self, record: Values) -> None:
        if self._file is not None:
            self._file.append(json.dumps(record).encode("ascii") + b"\n")


def read_journal(path: Path) -> tuple[Values, list[LeftBehind]]:
    """Return what a journal says of its bus, and what it has left; raises OSError or ValueError.

    A last line that was not written to its end is none: its change was not made.
    """
    about: Values = {}
    left: dict[int, LeftBehind] = {}
    for number, line in enumerate(path.read_bytes().split(b"\n")[:-1], start=1):
        try:
            record = json.loads(line)
            if record["record"] == RUN:
                about = record
            elif record["record"] == DEVICE:
                node_id = record["node_id"]
                left[node_id] = LeftBehind(path, node_id, record["sdo_channel"], record["identity"])
            else:
                left[record["node_id"]].take(record)
        except (AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
            why = f"{path}, line {number} cannot be read: {error!r}."
            raise ValueError(why) from error
    if not about.keys() >= _OF_A_RUN:
        raise ValueError(f"{path} does not say on which bus the run was.")
    return about, [each for each in left.values() if not each.is_all_back]


def journals(folder: Path) -> list[Path]:
    """Return the journals of a report folder."""
    return sorted(folder.glob(f"{NAME}*.jsonl"))


def bus_of(about: Values) -> BusSettings:
    """Return the bus that a journal names."""
    options = tuple(about["options"].items())
    return BusSettings(about["interface"], about["channel"], about["bitrate"], options)


def left_behind(folder: Path, node_ids: Collection[int]) -> Iterator[LeftBehind]:
    """Yield what earlier runs have left on some nodes; ``folder`` has their report folders.

    Not what a run that is going on has still to put back, and nothing of a self-test: its server
    is gone.
    """
    for path in sorted(folder.glob(f"*/{NAME}*.jsonl")):
        if _is_held(path):
            continue
        try:
            about, left = read_journal(path)
        except (OSError, ValueError):
            continue  # what is no journal has nothing to tell
        if not about.get("self_test", True):
            yield from (each for each in left if each.node_id in node_ids)


def put_back_left(channel: Channel, left: LeftBehind) -> list[str]:
    """Put back what was left on a node and take it out of the journal; say what was done.

    Raises BenchError or OSError.
    """
    back, pending = put_back(channel, left)
    take_back(left, back)
    node = f"of node {left.node_id}, left changed by {left.journal.parent.name}"
    done = [record.get("object", "stored parameters") for record in back]
    lines = [f"put back: {', '.join(done)} {node}"] if done else []
    return lines + [f"not put back: {mux} {node}: {why}" for mux, why in pending.items()]


def take_back(left: LeftBehind, records: Iterable[Values]) -> None:
    """Note in a journal what is back; it is removed when nothing else is in it."""
    with left.journal.open("ab") as file:
        for record in records:
            left.take(record)
            file.write(json.dumps({**record, "node_id": left.node_id}).encode("ascii") + b"\n")
    # Others may put back what the same journal has of other nodes, and be the last to do so.
    with suppress(FileNotFoundError):
        if not read_journal(left.journal)[1]:
            left.journal.unlink()
