"""The node's sense of time: heartbeats, and clients that fell silent. No clock runs here."""

import pytest
from sdo_server_bench import objects

from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.objects import ObjectDictionary

UPLOAD = CanFrame(0x605, bytes.fromhex("4008100000000000"))
TIMED_OUT = CanFrame(0x585, bytes.fromhex("8008100000000405"))
HEARTBEAT = CanFrame(0x705, b"\x7f")


def started(server_timeout: float | None = None) -> Node:
    node = Node(5, Server(ObjectDictionary(objects())), server_timeout=server_timeout)
    node.advance(100.0)
    node.start()
    return node


def heartbeat_time(milliseconds: int) -> CanFrame:
    value = milliseconds.to_bytes(2, "little").hex()
    return CanFrame(0x605, bytes.fromhex(f"2B171000{value}0000"))


def segment(toggle: int) -> CanFrame:
    return CanFrame(0x605, bytes((0x60 | toggle << 4,)) + bytes(7))


def test_by_default_nothing_is_ever_due() -> None:
    node = started()
    node.receive(UPLOAD)
    assert node.wake_at is None
    assert node.advance(1e9) == []


def test_the_time_counts_from_the_last_frame_of_the_channel() -> None:
    node = started(2.0)
    assert node.wake_at is None
    node.receive(UPLOAD)
    assert node.wake_at == pytest.approx(102.0)
    assert node.advance(101.5) == []
    node.receive(segment(0))
    assert node.wake_at == pytest.approx(103.5)
    assert node.advance(103.4) == []
    assert node.advance(103.5) == [TIMED_OUT]
    assert node.wake_at is None
    assert node.advance(110.0) == []


def test_a_frame_that_comes_too_late_meets_no_transfer() -> None:
    node = started(2.0)
    node.receive(UPLOAD)
    assert node.advance(102.5) == [TIMED_OUT]
    (answer,) = node.receive(segment(0))
    assert answer.data.hex() == "8000000001000405"


@pytest.mark.parametrize("end", ["8008100000000008", "4000100000000000"], ids=["abort", "read"])
def test_a_transfer_that_has_ended_does_not_time_out(end: str) -> None:
    node = started(2.0)
    node.receive(UPLOAD)
    node.receive(CanFrame(0x605, bytes.fromhex(end)))
    assert node.wake_at is None
    assert node.advance(200.0) == []


def test_a_stop_ends_the_wait() -> None:
    node = started(2.0)
    node.receive(UPLOAD)
    node.receive(CanFrame(0, b"\x02\x05"))
    assert node.wake_at is None
    assert node.advance(200.0) == []


def test_heartbeats() -> None:
    node = started()
    node.receive(heartbeat_time(500))
    assert node.wake_at == pytest.approx(100.5)
    assert node.advance(100.4) == []
    assert node.advance(100.5) == [HEARTBEAT]
    assert node.wake_at == pytest.approx(101.0)
    node.receive(CanFrame(0, b"\x01\x05"))
    assert node.advance(101.0) == [CanFrame(0x705, b"\x05")]
    node.receive(CanFrame(0, b"\x02\x05"))
    assert node.advance(101.5) == [CanFrame(0x705, b"\x04")]


def test_heartbeats_that_were_missed_are_not_made_up_for() -> None:
    node = started()
    node.receive(heartbeat_time(500))
    assert node.advance(102.6) == [HEARTBEAT]
    assert node.wake_at == pytest.approx(103.0)


def test_heartbeats_end() -> None:
    node = started()
    node.receive(heartbeat_time(500))
    node.receive(heartbeat_time(0))
    assert node.wake_at is None
    node.receive(heartbeat_time(500))
    node.receive(CanFrame(0, b"\x82\x05"))
    assert node.wake_at is None
    assert node.advance(200.0) == []


def test_another_time_counts_from_now() -> None:
    node = started()
    node.receive(heartbeat_time(500))
    node.advance(100.3)
    node.receive(heartbeat_time(500))
    assert node.wake_at == pytest.approx(100.5)
    node.receive(heartbeat_time(1000))
    assert node.wake_at == pytest.approx(101.3)


def test_what_comes_first_wakes_it() -> None:
    node = started(0.2)
    node.receive(heartbeat_time(500))
    node.receive(UPLOAD)
    assert node.wake_at == pytest.approx(100.2)
    assert node.advance(100.6) == [TIMED_OUT, HEARTBEAT]
