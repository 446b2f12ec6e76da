"""Whole runs of the suite over real SocketCAN: it and the device are processes of their own."""

import re
from collections.abc import Iterator
from pathlib import Path

import can
import pytest

from conformance.device.objects import KnownObject
from conformance.faults.device import REFERENCE_OBJECTS
from conformance.running import ExitCode
from conformance.sdo.objects import DataType

from .programs import (
    CHANNEL,
    FLEET,
    LIMIT,
    REFERENCE,
    RESPONSE_TIMEOUT,
    SHORT_TRANSFERS,
    Served,
    findings,
    lines,
    named,
    serving,
    set_interface,
    start_suite,
    suite,
)

OBJECTS = named(REFERENCE_OBJECTS)


@pytest.fixture
def reference(tmp_path: Path) -> Iterator[Served]:
    """The reference server."""
    with serving(*REFERENCE, errors=tmp_path / "errors") as served:
        yield served


# Devices


def test_the_reference_server_passes(reference: Served, tmp_path: Path) -> None:
    run = suite(tmp_path / "reports", *OBJECTS)
    assert run.status == pytest.ExitCode.OK, run.output
    assert not run.failed()
    with can.CanutilsLogReader(run.report("bus.log")) as log:
        frames = list(log)
    assert {message.channel for message in frames} == {CHANNEL}
    sent = sum(not message.is_rx for message in frames)
    # Every request but an abort has one answer here, and there are more than a thousand.
    assert sent > len(frames) - sent > 1000
    reference.stop()
    assert (reference.process.returncode, reference.errors.read_text()) == (0, "")


@pytest.mark.parametrize(
    ("fault", "options", "failing"),
    [
        (
            "upload-toggle-ignored",
            ["-k", "segmented-upload and toggle"],
            [
                "segmented-upload.toggle-first",
                "segmented-upload.toggle-repeated[1]",
                "segmented-upload.toggle-repeated[2]",
            ],
        ),
        ("answers-extended", ["-k", "frame", "--strict"], ["frame.extended-ignored"]),
    ],
)
def test_a_faulty_server_fails(
    tmp_path: Path, fault: str, options: list[str], failing: list[str]
) -> None:
    with serving(*REFERENCE, f"--fault={fault}", errors=tmp_path / "errors"):
        run = suite(tmp_path / "reports", *OBJECTS, *options)
    assert run.status == pytest.ExitCode.TESTS_FAILED, run.output
    assert list(run.failed()) == failing
    assert all(f"::{case} FAILED" in run.output for case in failing)


@pytest.mark.parametrize(
    ("server", "objects"),
    [
        ("canopen", REFERENCE_OBJECTS),
        # durand has no numbers of three bytes.
        (
            "durand",
            [known for known in REFERENCE_OBJECTS if known.data_type is not DataType.UNSIGNED24],
        ),
    ],
)
def test_a_foreign_server_has_its_findings(
    tmp_path: Path, server: str, objects: list[KnownObject]
) -> None:
    with serving(str(FLEET / f"{server}_server.py"), errors=tmp_path / "errors"):
        run = suite(tmp_path / "reports", *named(objects), "-k", SHORT_TRANSFERS)
    assert run.status == pytest.ExitCode.TESTS_FAILED, run.output
    assert run.failed() == findings(server.upper())


# The bench


def test_a_silent_node_is_not_waited_for_long(tmp_path: Path) -> None:
    run = suite(tmp_path, node_id=6)
    assert run.status == ExitCode.SILENT_NODE, run.output
    assert "Node 6 does not answer." in run.output
    with can.CanutilsLogReader(run.report("bus.log")) as log:
        reads = [message.timestamp for message in log if message.data[0] == 0x40]
    assert len(reads) == 3
    assert reads[-1] - reads[0] < 3 * RESPONSE_TIMEOUT


def test_a_missing_interface_is_named(tmp_path: Path) -> None:
    run = suite(tmp_path, channel="can9")
    assert run.status == ExitCode.BENCH_ERROR, run.output
    assert "socketcan can9 cannot be opened: [Errno 19] No such device." in run.output
    assert "'ip link show' lists them" in run.output
    assert "Traceback" not in run.output


@pytest.fixture
def up_again() -> Iterator[None]:
    """Leave vcan0 as it was."""
    yield
    set_interface("up")


@pytest.mark.usefixtures("up_again")
def test_an_interface_that_goes_down_ends_the_run(reference: Served, tmp_path: Path) -> None:
    with start_suite(tmp_path / "reports", *OBJECTS) as process:
        begun = next(line for line in lines(process) if "PASSED" in line)
        set_interface("down")
        output, _ = process.communicate(timeout=LIMIT)
    assert process.returncode == ExitCode.BENCH_ERROR, begun + output
    assert "socketcan vcan0 failed in the middle of the run: " in output
    assert "Network is down" in output
    assert "Bring it up" in output
    assert "Traceback" not in output
    # The server is a program that users start, too.
    assert reference.process.wait(LIMIT) == 1
    assert re.fullmatch(r"conformance: .*Network is down.*\n", reference.errors.read_text())
