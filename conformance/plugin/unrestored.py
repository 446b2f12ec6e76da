"""Values that a run changes and does not put back, and changed values of earlier runs."""

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
    """Writes the changes of this process into its journal; puts back those of earlier runs."""

    def __init__(self, options: Options, path: Path) -> None:
        """The journal is written at ``path``, when there is anything to write."""
        run = options.run
        self._path = path
        self._journal = Journal(path, run.bus, self_test=options.self_test)
        self._left = _left(options) if options.given[RESTORE] else []
        self._lines: list[str] = []
        self._pending: list[str] = []

    def remember(self, device: Device, ids: ChannelIds, record: dict[str, Any]) -> None:
        """Write a value that is about to be changed, or was put back."""
        about = LeftBehind(self._path, device.node_id, ids.in_digits, device.identity)
        self._journal.tell(about, record)

    def before(self, channel: Channel) -> None:
        """Put back the values of a node that earlier runs changed; raises BenchError."""
        for left in self._left:
            if left.node_id == channel.node_id:
                self._lines += put_back_left(channel, left)
                self._pending += [
                    f"the values of node {left.node_id} in {left.journal}"
                    for _ in range(not left.is_all_back)
                ]

    def close(self, findings: Findings) -> None:
        """List the values that were put back; an empty journal is deleted."""
        findings.restored += self._lines
        findings.unrestored += self._pending
        if trouble := self._journal.close():
            findings.bench_errors.append(NotWritten(trouble))


def _left(options: Options) -> list[LeftBehind]:
    return [] if options.self_test else list(left_behind(options.report_dir, options.node_ids))


def left_lines(options: Options) -> list[str]:
    """List the values that earlier runs have left changed on the devices of this run."""
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
