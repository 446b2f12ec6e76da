"""Many devices at once: workers of pytest-xdist, each with devices of its own.

Devices are dealt out to the workers before anything is collected, and a worker collects the cases
of its devices alone: they stay in order, and sixteen devices cost a worker no more than one. In
the words of pytest-xdist that is ``--dist=each``. The controller talks to no device; it is handed
the results and the findings of the workers and writes the one report.

In a self-test each worker has a server and a bus of its own. So workers that outnumber the devices
share one: each tests its own server for a part of the cases.
"""

import os
import signal
from collections.abc import Generator
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol

import pytest

from conformance.bus.errors import WorkerLost
from conformance.bus.link import Captured, Direction
from conformance.bus.stop import Stop
from conformance.plugin.findings import Findings

KEY = "conformance"
# The signal that ends a worker in good order. Some systems lack it.
TELLS_WORKER: int | None = getattr(signal, "SIGUSR1", None)


class Worker(Protocol):
    """A worker, as the controller knows it (pytest-xdist's WorkerController)."""

    workerinput: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Share:
    """The work of a process: its devices, and ``plain_tests``, which need no device.

    Of the cases it is each ``parts``-th one, from ``part`` on, which counts from 0. The ``mailbox``
    is a folder in which a worker on the same machine leaves the number of its process.
    """

    node_ids: list[int]
    part: int = 0
    parts: int = 1
    plain_tests: bool = True
    worker: str = ""
    report_dir: Path | None = None
    mailbox: str = ""

    def has_case(self, position: int) -> bool:
        """Say whether it is its turn to run a case, by the position among those of its devices."""
        return position % self.parts == self.part


def shares_of(node_ids: list[int], workers: int, *, divisible: bool) -> list[Share]:
    """Deal out devices to the workers; where there are fewer devices, parts of their cases.

    Devices that are not ``divisible`` leave workers over instead.
    """
    if len(node_ids) >= workers or not divisible:
        return [Share(node_ids[first::workers]) for first in range(workers)]
    return [
        Share([node_id], part, parts)
        for first, node_id in enumerate(node_ids)
        for parts in [len(range(first, workers, len(node_ids)))]
        for part in range(parts)
    ]


def is_controller(config: pytest.Config) -> bool:
    """Say whether this process leaves the work to others."""
    return (
        config.getoption("dist", default="no") != "no"
        and bool(config.getoption("tx", default=None))
        and not config.option.collectonly
    )


def share_of(config: pytest.Config, node_ids: list[int]) -> Share:
    """Return the work of this process."""
    handed = getattr(config, "workerinput", {}).get(KEY)
    if handed is None:
        return Share(node_ids)
    return Share(**{**handed, "report_dir": Path(handed["report_dir"])})


def belongs_here(captured: Captured, share: Share, neighbours: frozenset[int]) -> bool:
    """Say whether this process logs a frame, so that it stands once in the log of all.

    The first worker logs the frames that concern no device under test.
    """
    node_id = captured.frame.can_id & 0x7F
    if captured.direction is Direction.SENT or node_id in share.node_ids:
        return True
    return share.plain_tests and node_id not in neighbours


def hand_back(config: pytest.Config, findings: Findings) -> None:
    """Give the controller the findings of this worker."""
    config.workeroutput[KEY] = findings.as_dict()  # type: ignore[attr-defined]


def leave_number(share: Share) -> None:
    """Tell the controller where a signal reaches this worker, if it is on the same machine."""
    with suppress(OSError):
        Path(share.mailbox, share.worker).write_text(str(os.getpid()), encoding="ascii")


def forward(process: int) -> None:
    """Tell a worker on this machine that it has to stop."""
    if TELLS_WORKER is not None:
        with suppress(ProcessLookupError):
            os.kill(process, TELLS_WORKER)


class Controller:
    """The hooks of the process that leaves the work to others."""

    def __init__(
        self,
        config: pytest.Config,
        node_ids: list[int],
        report_dir: Path,
        findings: Findings,
        stop: Stop,
        *,
        divisible: bool,
    ) -> None:
        """Choose how the devices are dealt out; ``findings`` takes those of all workers.

        A request to ``stop`` goes on to all workers, also if they are ready later.

        ``divisible`` says that several workers may test one device. ``finished`` names the workers
        that have ended.
        """
        self._node_ids = node_ids
        self._report_dir = report_dir
        self._findings = findings
        self._stop = stop
        stop.when_requested(self._tell_all)
        self._processes: dict[str, int] = {}
        self._mailbox = TemporaryDirectory(prefix="conformance-")
        self._shares: list[Share] = []
        self._divisible = divisible
        self._configured = False
        self._session: pytest.Session | None = None
        self._collected = 0
        self.finished: list[str] = []
        config.option.dist = "each"
        # Nobody knows the state of a device after its worker was lost: no other takes over.
        config.option.maxworkerrestart = "0"
        if config.getoption("numprocesses", default=None) and not divisible:
            config.option.tx = config.option.tx[: len(node_ids)]

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_setupnodes(self, specs: list[object]) -> None:
        """Deal out the devices."""
        self._shares = shares_of(self._node_ids, len(specs), divisible=self._divisible)

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: Worker) -> None:
        """Give a worker its work."""
        given = node.workerinput
        share = replace(
            self._shares.pop(0),
            plain_tests=not self._configured,
            worker=given["workerid"],
            mailbox=self._mailbox.name,
        )
        given[KEY] = {**asdict(share), "report_dir": str(self._report_dir)}
        self._configured = True

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodeready(self, node: Worker) -> None:
        """Take the process of a worker on this machine: a signal can reach it from now on."""
        worker = node.workerinput["workerid"]
        try:
            process = int(Path(self._mailbox.name, worker).read_text(encoding="ascii"))
        except (OSError, ValueError):
            return
        self._processes[worker] = process
        if self._stop.requests:
            forward(process)

    def pytest_unconfigure(self) -> None:
        """Take the mailbox away."""
        self._mailbox.cleanup()

    def _tell_all(self) -> None:
        for process in self._processes.values():
            forward(process)

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, ids: list[str]) -> None:
        """Count the cases of all workers: pytest-xdist counts those of a single one."""
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
        """Take the findings of a worker. A worker that ends without any makes the run a failure."""
        worker = node.workerinput["workerid"]
        if worker in self.finished:
            return
        self.finished.append(worker)
        told = self._processes.pop(worker, None) is not None
        handed_back = getattr(node, "workeroutput", None) or {}
        if KEY in handed_back:
            self._findings.add(handed_back[KEY])
            return
        if self._stop.requests and not told:
            return  # it ended before it could have begun
        node_ids = ", ".join(map(str, node.workerinput[KEY]["node_ids"])) or "none"
        self._findings.bench_errors.append(
            WorkerLost(
                f"The process {worker} ended early ({error or 'for an unknown reason'}): it did "
                f"not finish the tests of these nodes: {node_ids}. Check their values, which may "
                "have changed; bus.log shows what was written last."
            )
        )
