"""Whole runs of the suite over real SocketCAN: it and the device are processes of their own."""

import re
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import pytest

from conformance.plugin.exit_code import ExitCode
from conformance.reference.built_in_device import REFERENCE_OBJECTS
from conformance.run.case_files import case_files
from conformance.sdo.objects import DataType

from .programs import (
    CHANNEL,
    FLEET,
    REFERENCE,
    Run,
    findings,
    named,
    serving,
    suite,
)

AT_ONCE = 2
OBJECTS = named(REFERENCE_OBJECTS)
# durand has no numbers of three bytes.
DURAND_OBJECTS = named(
    known for known in REFERENCE_OBJECTS if known.data_type is not DataType.UNSIGNED24
)
# Asking the kernel for a frame may be slow, so of what each bus shows alike, the virtual ones too,
# few cases are run: of frames all, of transfers a long one of each kind, and lost segments of a
# burst.
FILES = [
    str(path)
    for path in case_files()
    if re.fullmatch(
        r"test_((expedited|segmented|abort|frame|whole).*|block_(down|up)load)", path.stem
    )
]


def only(*stems: str, named: str = "") -> list[str]:
    """Return the files of some services, and the choice of cases by what is in their ids."""
    chosen = [file for file in FILES if any(stem in file for stem in stems)]
    return [*chosen, *(["-k", named] if named else [])]


FEW = only("test_", named="frame or run or missing or lost or 257 or 889")
# What foreign servers do in block transfers is seen on the virtual bus.
FOREIGN = only(
    "test_segmented_download", named="download-first or toggle or without or after or 60h or 257"
)


@dataclass(frozen=True, slots=True)
class Plan:
    """A run and its device; without a server no node has the node-ID."""

    node_id: int
    server: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    channel: str = CHANNEL

    def perform(self, folder: Path) -> Run:
        """Run the suite; the device's standard error is in ``folder``."""
        if not self.server:
            return self._run(folder)
        errors = folder / "errors"
        with serving(*self.server, errors=errors, node_id=self.node_id) as device:
            run = self._run(folder)
        assert device.returncode == 0, errors.read_text()
        return run

    def _run(self, folder: Path) -> Run:
        return suite(folder, *self.options, node_id=self.node_id, channel=self.channel)


# No two of the node-IDs differ in one bit only: cases on identifiers ask those neighbours.
PLANS = {
    "reference": Plan(3, REFERENCE, (*OBJECTS, *FEW)),
    "canopen": Plan(5, (str(FLEET / "canopen_server.py"),), (*OBJECTS, *FOREIGN)),
    "durand": Plan(6, (str(FLEET / "durand_server.py"),), (*DURAND_OBJECTS, *FOREIGN)),
    "faulty": Plan(
        9,
        (*REFERENCE, "--fault=upload-toggle-ignored+answers-extended"),
        (
            *OBJECTS,
            *only("test_segmented_upload", "test_frame_shape", named="toggle or extended"),
            "--strict",
        ),
    ),
    "silent": Plan(12, options=tuple(only("test_abort"))),
    "missing": Plan(15, options=tuple(only("test_abort")), channel="can9"),
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Future[Run]]]:
    """All runs, several at a time on the one bus: a run and its device take turns."""
    pool = ThreadPoolExecutor(AT_ONCE)
    yield {
        name: pool.submit(plan.perform, tmp_path_factory.mktemp(name))
        for name, plan in PLANS.items()
    }
    pool.shutdown(cancel_futures=True)


def test_the_reference_server_passes(runs: dict[str, Future[Run]]) -> None:
    run = runs["reference"].result()
    assert run.status == pytest.ExitCode.OK, run.output
    assert not run.failed()
    assert (run.folder / "errors").read_text() == ""


def test_the_log_has_the_frames_of_the_run(runs: dict[str, Future[Run]]) -> None:
    """Other runs are on the bus, but this one's requests and answers are all there."""
    log = runs["reference"].result().report("bus.log").read_text()
    assert all(f") {CHANNEL} " in line for line in log.splitlines())
    requests = re.findall(r" 603#\S* (.)$", log, re.MULTILINE)
    answers = re.findall(r" 583#\S* (.)$", log, re.MULTILINE)
    assert set(requests) == {"T"}
    assert set(answers) == {"R"}
    assert min(len(requests), len(answers)) > 500


FAILING = {
    "segmented-upload.toggle-first",
    "segmented-upload.toggle-repeated[segmented-upload-middle]",
    "segmented-upload.toggle-repeated[segmented-upload-last]",
    "frame.extended-ignored",
}


def test_a_faulty_server_fails(runs: dict[str, Future[Run]]) -> None:
    run = runs["faulty"].result()
    assert run.status == pytest.ExitCode.TESTS_FAILED, run.output
    assert set(run.failed()) == FAILING
    assert all(f"\n{case}: " in run.output for case in FAILING)


@pytest.mark.parametrize("server", ["canopen", "durand"])
def test_a_foreign_server_has_its_findings(runs: dict[str, Future[Run]], server: str) -> None:
    run = runs[server].result()
    assert run.status == pytest.ExitCode.TESTS_FAILED, run.output
    known = findings(server.upper())
    assert set(run.failed()) - set().union(*known) == set()
    in_the_run = [cases for cases in known if not cases.isdisjoint(run.cases())]
    assert [cases for cases in in_the_run if cases.isdisjoint(run.told())] == []
    assert len(in_the_run) > 1


def test_a_silent_node_is_not_waited_for_long(runs: dict[str, Future[Run]]) -> None:
    run = runs["silent"].result()
    assert run.status == ExitCode.SILENT_NODE, run.output
    assert "Node 12 does not answer." in run.output
    log = run.report("bus.log").read_text()
    sent = [float(time) for time in re.findall(r"\((\S+)\) vcan0 60C#\S+ T", log)]
    assert len(sent) == 5  # three reads, two of them behind an abort


def test_a_missing_interface_is_named(runs: dict[str, Future[Run]]) -> None:
    run = runs["missing"].result()
    assert run.status == ExitCode.BENCH_ERROR, run.output
    assert "socketcan can9 cannot be opened: [Errno 19] No such device." in run.output
    assert "'ip link show' lists those of SocketCAN" in run.output
    assert "socketcan.py" not in run.output
