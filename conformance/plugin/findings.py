"""The findings of a process beside the results of its cases: for the user, and other processes."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from conformance.beginning.two_devices import either
from conformance.bus.errors import BenchError, FailedOnce, error_named
from conformance.device.change_journal import WRITTEN_UNREAD
from conformance.device.known_deviations import KnownDeviation
from conformance.run.session import DeviceSession
from conformance.run.verdict import CaseResult


def not_again(session: DeviceSession, lost: int) -> FailedOnce:
    """Describe cases that failed once and not again; the bus need not be the reason."""
    met, frames = len(session.doubts.met), session.doubts.frames
    return FailedOnce(
        f"Node {session.device.node_id} failed {met} times in {frames} frames, but not when the "
        f"case was repeated; the interface counted {lost or 'no'} lost frames. Either the bus "
        "loses, repeats or swaps frames (check the adapter, its driver and the load of this "
        "machine), or the device fails only sometimes: this run cannot decide which."
    )


@dataclass(slots=True)
class Findings:
    """Findings outside the cases, for the exit status and the summary.

    ``unjudged`` are late answers that no selected case has judged, ``beside`` other breaches
    outside the cases for which no case has failed, and ``broken_beside`` the rules of all of them,
    known or not. ``unrestored`` lists the values to write back by hand, ``restored`` the values of
    an earlier run that were written back. ``notes`` are remarks on the bench that fail nothing.
    ``out`` says why a device could not be tested any further, ``stopped`` which cases have stopped
    a device that was brought back; ``unreached`` are the cases behind the end of a run. ``partly``
    names known deviations for several cases of which some were not selected; ``wrong_use`` is a
    mistake in the options that shows only when cases are collected.
    """

    properties: dict[str, str] = field(default_factory=dict)
    bench_errors: list[BenchError] = field(default_factory=list)
    unjudged: list[str] = field(default_factory=list)
    beside: list[str] = field(default_factory=list)
    unrestored: list[str] = field(default_factory=list)
    restored: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    out: dict[int, str] = field(default_factory=dict)
    unreached: list[CaseResult] = field(default_factory=list)
    stopped: list[str] = field(default_factory=list)
    partly: list[str] = field(default_factory=list)
    broken_beside: list[str] = field(default_factory=list)
    wrong_use: str = ""

    def close(
        self,
        session: DeviceSession,
        *,
        judged: int,
        known: Sequence[KnownDeviation] = (),
        lost: int = 0,
    ) -> None:
        """Take the findings of a device's part of the run.

        A case has judged the first ``judged`` of its late answers. A breach is no finding if an
        entry without a case of the ``known`` deviations excuses its rule. ``lost`` frames are
        counted by the interface itself.
        """
        excused = {deviation.rule for deviation in known if deviation.case is None}
        self.unjudged += [
            f"{incident.case_id}: {incident.violation}"
            for incident in session.whole_run.late[judged:]
        ]
        self.notes += session.channel.strangers.lines()
        self.notes += session.doubts.lines()
        if len(session.doubts.met) > lost:
            self.bench_errors.append(not_again(session, lost))
        if session.device.learned.answers_twice:
            self.notes.append(either(session.device.node_id))
        aside = session.causes.aside()
        self.broken_beside += [cause.rule_id for cause, _ in aside]
        self.beside += [
            f"{standing.first_case}: {standing.violation}"
            for cause, standing in aside
            if cause.rule_id not in excused
        ]
        node = f"node {session.device.node_id}"
        self.unrestored += [
            f"write {value} to {mux} of {node}"
            for mux, value in session.restorer.unrestored.items()
        ]
        self.notes += [
            f"{mux} of {node} read otherwise behind the last case than before the run, though no "
            "case had left it so: another write has changed it, or the device itself"
            for mux in session.written_beside
        ]
        self.unrestored += [
            f"{mux} of {node} {WRITTEN_UNREAD}" for mux in sorted(session.device.contents.taken)
        ]

    def as_dict(self) -> dict[str, Any]:
        """Return plain values, which another process can take."""
        return {
            "properties": self.properties,
            "bench_errors": [(type(error).__name__, str(error)) for error in self.bench_errors],
            "unjudged": self.unjudged,
            "beside": self.beside,
            "unrestored": self.unrestored,
            "restored": self.restored,
            "notes": self.notes,
            "out": self.out,
            "unreached": [result.as_dict() for result in self.unreached],
            "stopped": self.stopped,
            "partly": self.partly,
            "broken_beside": self.broken_beside,
            "wrong_use": self.wrong_use,
        }

    def add(self, values: dict[str, Any]) -> None:
        """Take the findings of another process, from its ``as_dict``."""
        self.properties |= values["properties"]
        self.bench_errors += [error_named(kind, text) for kind, text in values["bench_errors"]]
        self.unjudged += values["unjudged"]
        self.beside += values["beside"]
        self.unrestored += values["unrestored"]
        self.restored += values["restored"]
        self.notes += values["notes"]
        self.out |= values["out"]
        self.unreached += map(CaseResult.from_dict, values["unreached"])
        self.stopped += values["stopped"]
        self.partly += values["partly"]
        self.broken_beside += values["broken_beside"]
        self.wrong_use = self.wrong_use or values["wrong_use"]
