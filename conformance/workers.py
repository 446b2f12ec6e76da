"""Many devices at once: workers of pytest-xdist, each with devices of its own.

Devices are dealt out to the workers before anything is collected, and a worker collects the cases
of its devices alone: they stay in order, and sixteen devices cost a worker no more than one. In
the words of pytest-xdist that is ``--dist=each``. The controller talks to no device; it is handed
the results and the findings of the workers and writes the one report.
"""

from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import pytest

from conformance.bus.errors import WorkerLost
from conformance.bus.link import Captured, Direction
from conformance.findings import Findings

KEY = "conformance"


class Worker(Protocol):
    """What the controller knows of a worker (pytest-xdist's WorkerController)."""

    workerinput: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Share:
    """What a process has to do: which devices, and whether tests that need none as well."""

    node_ids: list[int]
    plain_tests: bool = True
    worker: str = ""
    report_dir: Path | None = None


def is_controller(config: pytest.Config) -> bool:
    """Say whether this process leaves the work to others."""
    return (
        config.getoption("dist", default="no") != "no"
        and bool(config.getoption("tx", default=None))
        and not config.option.collectonly
    )


def share_of(config: pytest.Config, node_ids: list[int]) -> Share:
    """Return what this process has to do."""
    handed = getattr(config, "workerinput", {}).get(KEY)
    if handed is None:
        return Share(node_ids)
    return Share(
        handed["node_ids"], handed["plain_tests"], handed["worker"], Path(handed["report_dir"])
    )


def belongs_here(captured: Captured, share: Share, neighbours: frozenset[int]) -> bool:
    """Say whether this process logs a frame, so that it stands once in the log of all.

    What concerns no device under test is logged by the first worker.
    """
    node_id = captured.frame.can_id & 0x7F
    if captured.direction is Direction.SENT or node_id in share.node_ids:
        return True
    return share.plain_tests and node_id not in neighbours


def hand_back(config: pytest.Config, findings: Findings) -> None:
    """Give the controller what this worker found."""
    config.workeroutput[KEY] = findings.as_dict()  # type: ignore[attr-defined]


class Controller:
    """The hooks of the process that leaves the work to others."""

    def __init__(
        self,
        config: pytest.Config,
        node_ids: list[int],
        report_dir: Path,
        findings: Findings,
    ) -> None:
        """Choose how the devices are dealt out; ``findings`` is where those of all workers go.

        ``finished`` names the workers that have ended.
        """
        self._node_ids = node_ids
        self._report_dir = report_dir
        self._findings = findings
        self._shares: list[list[int]] = []
        self._configured = False
        self._session: pytest.Session | None = None
        self._collected = 0
        self.finished: list[str] = []
        config.option.dist = "each"
        # What a device does after its worker was lost is not known: no other takes over.
        config.option.maxworkerrestart = "0"
        if config.getoption("numprocesses", default=None):
            # One device is left to one worker.
            config.option.tx = config.option.tx[: len(node_ids)]

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_setupnodes(self, specs: list[object]) -> None:
        """Deal out the devices."""
        self._shares = [self._node_ids[first :: len(specs)] for first in range(len(specs))]

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: Worker) -> None:
        """Tell a worker what it has to do."""
        given = node.workerinput
        given[KEY] = {
            "node_ids": self._shares.pop(0),
            "plain_tests": not self._configured,
            "worker": given["workerid"],
            "report_dir": str(self._report_dir),
        }
        self._configured = True

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, ids: list[str]) -> None:
        """Count the cases of all workers: pytest-xdist knows those of one."""
        self._collected += len(ids)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtestloop(self, session: pytest.Session) -> Generator[None, object, object]:
        """Let pytest know how many cases there were; none at all is no success."""
        self._session = session
        outcome = yield
        session.testscollected = self._collected
        if self._findings.wrong_use:
            raise pytest.UsageError(self._findings.wrong_use)
        return outcome

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logstart(self) -> None:
        """Let the progress be that of all workers."""
        if self._session is not None:
            self._session.testscollected = self._collected

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Worker, error: object | None) -> None:
        """Take what a worker found. One that ends without a word makes the run a failure."""
        worker = node.workerinput["workerid"]
        if worker in self.finished:
            return
        self.finished.append(worker)
        handed_back = getattr(node, "workeroutput", None) or {}
        if KEY in handed_back:
            self._findings.add(handed_back[KEY])
            return
        node_ids = ", ".join(map(str, node.workerinput[KEY]["node_ids"])) or "none"
        self._findings.bench_errors.append(
            WorkerLost(
                f"The process {worker} ended before its time ({error or 'no reason is known'}): "
                f"the nodes left to it were not tested to the end: {node_ids}. Read their values "
                "before you trust them; bus.log shows what was written last."
            )
        )
