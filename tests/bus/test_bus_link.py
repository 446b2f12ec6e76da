"""A bus in use: frames go through unchanged, and what is wrong with the bus has a name."""

import errno
from collections.abc import Iterator

import can
import pytest
from bus_fakes import ANSWER, READ, Bench, FakeBus, error_frame, message

from conformance.bus.errors import BusOff, FramesDropped, InterfaceLost, TransmitBufferFull
from conformance.bus.link import Captured, Direction
from conformance.sdo.can_frame import CanFrame

REQUEST = CanFrame(0x605, READ)
FULL = OSError(errno.ENOBUFS, "No buffer space available")
CONTROLLER_PROBLEM, PROTOCOL_VIOLATION, NOT_ACKNOWLEDGED, BUS_OFF = 0x004, 0x008, 0x020, 0x040


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    bench = Bench(monkeypatch)
    yield bench
    bench.link.close()


# Sending


@pytest.mark.parametrize(
    "frame",
    [
        REQUEST,
        CanFrame(0x605, b""),
        CanFrame(0x605, READ[:3]),
        CanFrame(0x605, READ, extended=True),
        CanFrame(0x605, remote=True, length=8),
    ],
    ids=str,
)
def test_a_frame_is_sent_as_it_is(bench: Bench, frame: CanFrame) -> None:
    bench.link.send(frame)
    (sent,) = bench.bus.sent
    assert (sent.arbitration_id, bytes(sent.data), sent.dlc) == (0x605, frame.data, frame.dlc)
    assert (sent.is_extended_id, sent.is_remote_frame) == (frame.extended, frame.remote)
    assert bench.captured == [Captured(1000.0, Direction.SENT, frame)]


@pytest.mark.parametrize(
    "error",
    [
        FULL,
        can.CanOperationError("Failed to transmit", errno.ENOBUFS),
        can.CanOperationError("Transmit buffer full"),
    ],
    ids=["OSError", "error-code", "text"],
)
def test_a_full_buffer_is_tried_again(bench: Bench, error: Exception) -> None:
    bench.bus.send_errors.extend([error] * 5)
    bench.link.send(REQUEST)
    assert len(bench.bus.sent) == 1
    assert 1000.0 < bench.clock.now < 1000.5


def test_a_buffer_that_stays_full_is_named(bench: Bench) -> None:
    bench.bus.send_errors.extend([FULL] * 100_000)
    with pytest.raises(TransmitBufferFull, match="fake0 did not take a frame for 1 s"):
        bench.link.send(REQUEST)
    assert 1001.0 <= bench.clock.now < 1001.1
    assert bench.captured == []


@pytest.mark.parametrize(
    "error",
    [
        OSError(errno.ENETDOWN, "Network is down"),
        can.CanOperationError("Failed to transmit", errno.ENETDOWN),
    ],
    ids=["OSError", "error-code"],
)
def test_an_interface_that_goes_down_is_named(bench: Bench, error: Exception) -> None:
    bench.bus.send_errors.append(error)
    with pytest.raises(InterfaceLost, match=r"fake0 failed .* Bring it up: 'ip link set can0 up"):
        bench.link.send(REQUEST)
    assert bench.captured == []
    bench.bus.incoming.append(error)
    with pytest.raises(InterfaceLost, match=r"fake0 failed .* Bring it up: 'ip link set can0 up"):
        bench.link.receive(0.5)


def test_an_interface_that_goes_away_is_named(bench: Bench) -> None:
    bench.bus.incoming.append(OSError(errno.ENODEV, "No such device"))
    with pytest.raises(InterfaceLost, match="Does the interface exist"):
        bench.link.receive(0.5)


# Receiving


@pytest.mark.parametrize(
    "frame",
    [
        CanFrame(0x585, ANSWER),
        CanFrame(0x585, ANSWER[:3]),
        CanFrame(0x18FF0005, b"\x01", extended=True),
        CanFrame(0x585, remote=True, length=8),
    ],
    ids=str,
)
def test_a_frame_is_received_as_it_is(bench: Bench, frame: CanFrame) -> None:
    bench.bus.incoming.append(
        message(frame.can_id, frame.data, extended=frame.extended, remote=frame.remote)
    )
    assert bench.link.receive(0.5) == frame
    assert bench.captured == [Captured(1000.0, Direction.RECEIVED, frame)]


def test_silence_takes_the_time_out_and_no_more(bench: Bench) -> None:
    assert bench.link.receive(0.5) is None
    assert bench.clock.now == pytest.approx(1000.5, abs=0.01)


def test_a_look_takes_no_time(bench: Bench) -> None:
    assert bench.link.look() == []
    bench.bus.incoming.append(message(0x585, ANSWER))
    assert bench.link.look() == [CanFrame(0x585, ANSWER)]
    assert bench.clock.now == pytest.approx(1000, abs=0.0001)
    assert len(bench.captured) == 1


def test_a_look_is_at_so_many_frames(bench: Bench) -> None:
    frames = [CanFrame(can_id, ANSWER) for can_id in (0x585, 0x586, 0x587)]
    bench.bus.incoming.extend(message(frame.can_id, frame.data) for frame in frames)
    assert bench.link.look(2) == frames[:2]
    assert bench.link.look(2) == frames[2:]


def test_own_frames_that_come_back_are_not_received(bench: Bench) -> None:
    echo = message(0x605, READ)
    echo.is_rx = False
    bench.link.send(CanFrame(0x605, READ))
    bench.bus.incoming.extend([echo, message(0x585, ANSWER)])
    assert bench.link.receive(0.5) == CanFrame(0x585, ANSWER)
    assert len(bench.captured) == 2


def test_own_frames_that_come_back_like_any_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of as many equal frames as came, one was not ours: it is a second client's."""
    monkeypatch.setattr("conformance.bus.link.UdpMulticastBus", FakeBus)
    bench = Bench(monkeypatch)
    own, remote = CanFrame(0x605, READ), CanFrame(0x605, remote=True, length=8)
    for frame in (CanFrame(0x605, b"lost"), own, remote, own):
        bench.link.send(frame)
    echo = message(0x605, READ)
    bench.bus.incoming.extend(
        [echo, message(0x605, b"", remote=True), message(0x585, ANSWER), echo, echo]
    )
    received = [bench.link.receive(0.5), bench.link.receive(0.5), bench.link.receive(0.5)]
    assert received == [CanFrame(0x585, ANSWER), own, None]
    bench.link.close()


# Error frames


@pytest.mark.parametrize("kind", [BUS_OFF, BUS_OFF | CONTROLLER_PROBLEM])
def test_bus_off(bench: Bench, kind: int) -> None:
    bench.bus.incoming.append(error_frame(kind))
    with pytest.raises(BusOff, match="fake0 went bus-off"):
        bench.link.receive(0.5)


def test_receive_overflow(bench: Bench) -> None:
    bench.bus.incoming.append(error_frame(CONTROLLER_PROBLEM, bytes([0, 1, 0, 0, 0, 0, 0, 0])))
    with pytest.raises(FramesDropped, match="fake0 lost frames"):
        bench.link.receive(0.5)


@pytest.mark.parametrize(
    "harmless",
    [
        error_frame(PROTOCOL_VIOLATION, bytes([0, 1, 0, 0, 0, 0, 0, 0])),
        error_frame(NOT_ACKNOWLEDGED),
        error_frame(CONTROLLER_PROBLEM, bytes([0, 2, 0, 0, 0, 0, 0, 0])),
        error_frame(CONTROLLER_PROBLEM, b""),
    ],
    ids=["protocol", "no-acknowledgement", "transmit-overflow", "short"],
)
def test_other_error_frames_are_passed_over(bench: Bench, harmless: can.Message) -> None:
    bench.bus.incoming.extend([harmless, message(0x585, ANSWER)])
    assert bench.link.receive(0.5) == CanFrame(0x585, ANSWER)
    assert len(bench.captured) == 1


def test_a_flood_of_error_frames_ends_with_the_time_out(bench: Bench) -> None:
    bench.bus.receipt_takes = 0.0001
    bench.bus.incoming.extend([error_frame(NOT_ACKNOWLEDGED)] * 20_000)
    assert bench.link.receive(0.5) is None
    assert bench.clock.now < 1001.0


# Filters

PASSED = [
    *(0x000, 0x005, 0x085, 0x105, 0x185, 0x205, 0x285, 0x485, 0x505),
    *(0x580, 0x581, 0x585, 0x586, 0x5FF, 0x600, 0x605, 0x606, 0x67F, 0x700, 0x705, 0x711, 0x77F),
    *(0x091, 0x191, 0x291),
]
HELD_BACK = [0x080, 0x086, 0x100, 0x123, 0x186, 0x206, 0x57F, 0x680, 0x6E6, 0x780, 0x7E6]


def test_the_interface_passes_what_the_run_may_need(bench: Bench) -> None:
    """SDO of all nodes, NMT, error control, all that nodes 5 and 17 send, all 29-bit frames."""
    bench.link.watch([5, 17])
    bench.bus.incoming.extend(message(can_id) for can_id in sorted(PASSED + HELD_BACK))
    bench.bus.incoming.append(message(0x123, extended=True))
    received = iter(lambda: bench.link.receive(0.1), None)
    assert [(frame.can_id, frame.extended) for frame in received] == [
        *((can_id, False) for can_id in sorted(PASSED)),
        (0x123, True),
    ]


def test_further_identifiers_pass(bench: Bench) -> None:
    bench.link.watch([5], [0x681, 0x6A1])
    bench.bus.incoming.extend(message(can_id) for can_id in (0x680, 0x681, 0x6A0, 0x6A1, 0x6A2))
    received = iter(lambda: bench.link.receive(0.1), None)
    assert [frame.can_id for frame in received] == [0x681, 0x6A1]


def test_filters_for_the_kernel(bench: Bench) -> None:
    bench.link.watch([5])
    assert bench.bus.filters == [
        {"can_id": 0x000, "can_mask": 0x780, "extended": False},
        {"can_id": 0x700, "can_mask": 0x780, "extended": False},
        {"can_id": 0x580, "can_mask": 0x780, "extended": False},
        {"can_id": 0x600, "can_mask": 0x780, "extended": False},
        {"can_id": 0x005, "can_mask": 0x07F, "extended": False},
        {"can_id": 0, "can_mask": 0, "extended": True},
    ]


def test_error_frames_pass_the_filters(bench: Bench) -> None:
    bench.link.watch([5])
    bench.bus.incoming.append(error_frame(BUS_OFF))
    with pytest.raises(BusOff):
        bench.link.receive(0.1)


def test_close_closes_the_bus(bench: Bench) -> None:
    bench.link.close()
    assert bench.bus._is_shutdown
