"""A device that is started, or brought back, is awaited: its boot-up message or an answer."""

from pathlib import Path

import pytest
from support.run_bench import BASELINE, NODE_ID, Scripted, Workbench, undiscovered

from conformance.beginning.revival import Revival
from conformance.bus.errors import ProcessFailed
from conformance.device.process import DeviceProcess, ProcessSettings
from conformance.sdo.can_frame import CanFrame

BOOT_UP = CanFrame(0x700 + NODE_ID, b"\0")
SHORT = 0.3


def revival(
    bench: Workbench, folder: Path, recover: list[str] | None = None, attempts: int = 3
) -> Revival:
    chosen = ProcessSettings(start_limit=SHORT, recover=recover, attempts=attempts)
    return Revival(chosen, DeviceProcess(chosen, folder / "log"), bench.channel)


def test_an_answer_is_enough(tmp_path: Path) -> None:
    with undiscovered(Scripted(lambda data: [BASELINE]), timeout=0.05) as bench:
        revival(bench, tmp_path).start()
        assert bench.channel.receive(0) is None


def test_a_boot_up_message_is_enough(tmp_path: Path) -> None:
    node = Scripted(lambda data: [])
    with undiscovered(node, timeout=SHORT) as bench:
        bench.send_from_elsewhere(BOOT_UP)
        revival(bench, tmp_path).start()
    assert node.requests == [], "nothing had to be asked"


def test_the_boot_up_message_of_another_node_is_not(tmp_path: Path) -> None:
    with undiscovered(Scripted(lambda data: []), timeout=0.1) as bench:
        bench.send_from_elsewhere(CanFrame(0x700 + NODE_ID + 1, b"\0"))
        with pytest.raises(ProcessFailed, match=r"neither booted nor answered within 0\.3 s"):
            revival(bench, tmp_path).start()


def test_what_was_asked_before_it_booted_is_not_left_to_the_run(tmp_path: Path) -> None:
    node = Scripted(lambda data: [BOOT_UP, BASELINE])
    with undiscovered(node, timeout=0.1) as bench:
        revival(bench, tmp_path).start()
        assert bench.channel.receive(0) is None


def test_it_is_tried_so_many_times_whenever_it_is_lost(tmp_path: Path) -> None:
    tried = tmp_path / "tried"
    recover = ["sh", "-c", f"echo again >> {tried}"]
    with undiscovered(Scripted(lambda data: []), timeout=0.1) as bench:
        dead = revival(bench, tmp_path, attempts=2, recover=recover)
        for times in (2, 4):
            assert "neither booted nor answered" in dead.attempt()
            assert len(tried.read_text(encoding="utf-8").splitlines()) == times


def test_it_is_brought_back_as_often_as_it_is_lost(tmp_path: Path) -> None:
    with undiscovered(Scripted(lambda data: [BASELINE]), timeout=0.05) as bench:
        alive = revival(bench, tmp_path, attempts=1)
        assert [alive.attempt() for _ in range(5)] == [""] * 5
