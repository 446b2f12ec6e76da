"""A device that boots or dies before the first case: told as that, with the frames."""

from pathlib import Path

import pytest
from support.run_bench import NODE_ID

from conformance.bus.errors import DeviceLost
from conformance.bus.opening import BusSettings
from conformance.faults.catalogue import build_node
from conformance.reference.built_in_device import reference_entries
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.reference.simulated_bus import SimulatedBus
from conformance.run.bench import Bench, RunSettings
from conformance.run.case_run import begin_case
from conformance.run.verdict import Verdict
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.objects import ObjectDictionary
from conformance.sdo.rules import ANSWERED

BOOT_UP = CanFrame(0x700 + NODE_ID, b"\0")


class Boots(Node):
    """Starts again behind one read of a name."""

    booted = False

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        answers = super().receive(frame)
        if frame.data[1:3] == b"\x09\x10" and not self.booted:
            self.booted = True
            return [BOOT_UP, *answers]
        return answers


class Dies(Node):
    """Answers nothing any more behind that."""

    dead = False

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        self.dead |= frame.data[1:3] == b"\x09\x10"
        return [] if self.dead else super().receive(frame)


def bench_with(kind: type[Node], folder: Path) -> Bench:
    node = kind(NODE_ID, Server(ObjectDictionary(reference_entries(NODE_ID))))
    settings = RunSettings([NODE_ID], BusSettings("virtual", "none"), response_timeout=0.01)
    return Bench(settings, [], lambda captured: None, folder, opener=lambda _: SimulatedBus([node]))


def test_a_device_that_boots_while_it_is_read(tmp_path: Path) -> None:
    bench = bench_with(Boots, tmp_path)
    bench.open()
    session = bench.sessions[NODE_ID]
    ((cause, standing),) = session.causes.aside()
    assert str(cause) == "server.no-reboot: the device booted behind upload initiate"
    assert standing.violation.actual.startswith(
        "the device booted; behind upload initiate 1009h:00; the last frames: "
    )
    assert standing.violation.actual.endswith("605#4009100000000000, 705#00")
    # The first case is not charged with it.
    assert begin_case(session, "first", "test", ANSWERED).conclude(None).verdict is Verdict.PASS
    bench.close()


def test_a_device_that_dies_while_it_is_read(tmp_path: Path) -> None:
    bench = bench_with(Dies, tmp_path)
    bench.open()
    assert bench.sessions == {}
    error = bench.silent[NODE_ID]
    assert isinstance(error, DeviceLost)
    assert "was lost before the first case" in str(error)
    assert "> 605#4009100000000000 upload initiate 1009h:00" in str(error)
    bench.close()


@pytest.mark.parametrize("name", [None, "answers-twice"])
def test_a_device_that_does_neither(tmp_path: Path, name: str | None) -> None:
    node = build_node(name, NODE_ID)
    settings = RunSettings([NODE_ID], BusSettings("virtual", "none"), response_timeout=0.01)
    bench = Bench(
        settings, [], lambda captured: None, tmp_path, opener=lambda _: SimulatedBus([node])
    )
    bench.open()
    causes = bench.sessions[NODE_ID].causes.aside()
    assert [cause for cause, _ in causes if cause.rule_id == "server.no-reboot"] == []
    bench.close()


class BootsAgainAndAgain(Node):
    """Sends more boot-up messages than are shown, behind one read of a name."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        answers = super().receive(frame)
        return [*[BOOT_UP] * 20, *answers] if frame.data[1:3] == b"\x09\x10" else answers


def test_a_device_that_boots_again_and_again_before_the_first_case(tmp_path: Path) -> None:
    bench = bench_with(BootsAgainAndAgain, tmp_path)
    bench.open()
    ((cause, _),) = bench.sessions[NODE_ID].causes.aside()
    assert str(cause) == "server.no-reboot: the device booted behind upload initiate"
    bench.close()
