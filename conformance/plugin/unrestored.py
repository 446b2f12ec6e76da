"""The values that a run changes: what it does not put back, and what earlier runs have left."""

from pathlib import Path
from typing import Any

from conformance.bus.channel import Channel
from conformance.bus.errors import NotWritten
from conformance.device.change_journal import LeftBehind
from conformance.device.device import Device
from conformance.device.options import RESTORE
from conformance.plugin.findings import Findings
from conformance.plugin.options import Options
from conformance.reporting.journal import Journal, left_behind, put_back_left
from conformance.sdo.cob_id import ChannelIds


class Values:
    """Remembers in the journal of this process what it changes; puts back what others have left."""

    def __init__(self, options: Options, path: Path) -> None:
        """The journal is written at ``path``, when there is anything to write."""
        run = options.run
        self._path = path
        self._journal = Journal(path, run.bus, self_test=options.self_test)
        self._left = _left(options) if options.given[RESTORE] else []
        self._lines: list[str] = []
        self._pending: list[str] = []

    def remember(self, device: Device, ids: ChannelIds, record: dict[str, Any]) -> None:
        """Write what is about to be changed, or is back."""
        about = LeftBehind(self._path, device.node_id, ids.in_digits, device.identity)
        self._journal.tell(about, record)

    def before(self, channel: Channel) -> None:
        """Put back what earlier runs have left on a node; raises BenchError."""
        for left in self._left:
            if left.node_id == channel.node_id:
                self._lines += put_back_left(channel, left)
                self._pending += [
                    f"the values of node {left.node_id} in {left.journal}"
                    for _ in range(not left.is_all_back)
                ]

    def close(self, findings: Findings) -> None:
        """Tell what was put back; the journal goes where nothing is left in it."""
        findings.restored += self._lines
        findings.unrestored += self._pending
        if trouble := self._journal.close():
            findings.bench_errors.append(NotWritten(trouble))


def _left(options: Options) -> list[LeftBehind]:
    return [] if options.self_test else list(left_behind(options.report_dir, options.node_ids))


def left_lines(options: Options) -> list[str]:
    """Say what earlier runs have left changed on the devices of this one."""
    offer = (
        "the values are restored first"
        if options.given[RESTORE]
        else "--sdo-restore restores the values first; without it this run takes the changed "
        "values for those of the device"
    )
    return [
        f"an earlier run left changed values on node {left.node_id} "
        f"({', '.join(map(str, left.objects))}; {left.journal}): {offer}"
        for left in _left(options)
    ]
