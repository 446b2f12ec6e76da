"""The bus without threads: what time it is on it, and when its frames arrive."""

import time

import can
import pytest

from conformance.bus.link import Link
from conformance.bus.messages import to_frame, to_message
from conformance.faults.catalogue import build_node
from conformance.faults.hosting import simulated_bus
from conformance.reference.simulated_bus import SimulatedBus, SimulatedClock
from conformance.sdo.can_frame import CanFrame

NODE_ID = 5
READ = to_message(CanFrame(0x605, bytes.fromhex("4000100000000000")))
HEARTBEAT = to_message(CanFrame(0x605, bytes.fromhex("2B171000E8030000")))
DELAY = 0.05


def booted(bus: SimulatedBus) -> SimulatedBus:
    boot_up = bus.recv(0)
    assert boot_up is not None
    assert boot_up.arbitration_id == 0x700 + NODE_ID
    return bus


def answered(message: can.Message | None) -> bool:
    return message is not None and message.arbitration_id == 0x580 + NODE_ID


def test_an_answer_is_there_at_once() -> None:
    bus = booted(simulated_bus([NODE_ID], None))
    bus.send(READ)
    assert answered(bus.recv(0))
    assert bus.recv(1000) is None, "which takes no time"


def test_time_passes_when_it_is_waited_for() -> None:
    bus = booted(simulated_bus([NODE_ID], None))
    bus.send(HEARTBEAT)
    assert answered(bus.recv(0))
    assert bus.recv(0.9) is None
    heartbeat = bus.recv(0.2)
    assert heartbeat is not None
    assert heartbeat.arbitration_id == 0x700 + NODE_ID


@pytest.mark.parametrize("patience", [0.0, DELAY / 2])
def test_an_answer_takes_its_time(patience: float) -> None:
    bus = booted(simulated_bus([NODE_ID], None, DELAY))
    begin = time.monotonic()
    bus.send(READ)
    assert bus.recv(patience) is None
    assert answered(bus.recv(10 * DELAY))
    assert time.monotonic() - begin >= DELAY - 0.001


def test_a_delay_on_a_simulated_clock_costs_nothing() -> None:
    clock = SimulatedClock()
    bus = booted(SimulatedBus([build_node(None, NODE_ID)], DELAY, clock))
    bus.send(READ)
    assert bus.recv(DELAY / 2) is None
    assert answered(bus.recv(DELAY))
    assert clock.now() == pytest.approx(DELAY)


def test_a_look_at_what_has_arrived_takes_no_time() -> None:
    clock = SimulatedClock()
    link = Link(SimulatedBus([build_node(None, NODE_ID)], DELAY, clock), "simulated")
    boot_up = link.receive(0)
    assert boot_up is not None
    link.send(to_frame(READ))
    assert link.receive(0) is None
    assert clock.now() == 0.0
    link.close()
