"""A link on real SocketCAN: what the kernel keeps for it, and what it does not pass on."""

import os
import socket
import struct
from collections.abc import Iterator

import can
import pytest

from conformance.bus.link import Link
from conformance.bus.opening import BusSettings, open_bus
from conformance.sdo.can_frame import CanFrame

from .programs import CHANNEL, NODE_ID

FRAME = struct.Struct("=IB3x8s")
# Seconds; on a vcan nothing is on its way for long.
PATIENCE = 120
# As many frames as a block of a block transfer has at most.
BURST = [CanFrame(0x580 + NODE_ID, bytes([number, *range(7)])) for number in range(1, 128)]
LAST = CanFrame(0x580 + NODE_ID, b"the last")


class Peer:
    """Another program on the bus, without python-can: what it sends and receives is certain."""

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self._socket.bind((CHANNEL,))
        self._socket.settimeout(PATIENCE)

    def send(self, frame: CanFrame) -> None:
        flags = frame.extended * socket.CAN_EFF_FLAG | frame.remote * socket.CAN_RTR_FLAG
        self._socket.send(FRAME.pack(frame.can_id | flags, frame.dlc, frame.data))

    def receive(self) -> CanFrame:
        return read_frame(self._socket)

    def close(self) -> None:
        self._socket.close()


def read_frame(raw: socket.socket) -> CanFrame:
    """Return the next frame that the kernel has for a socket."""
    can_id, length, data = FRAME.unpack(raw.recv(FRAME.size))
    remote = bool(can_id & socket.CAN_RTR_FLAG)
    return CanFrame(
        can_id & socket.CAN_EFF_MASK,
        b"" if remote else data[:length],
        bool(can_id & socket.CAN_EFF_FLAG),
        remote,
        length if remote else None,
    )


@pytest.fixture
def bus() -> can.BusABC:
    """The bus of the link."""
    return open_bus(BusSettings("socketcan", CHANNEL))


@pytest.fixture
def link(bus: can.BusABC) -> Iterator[Link]:
    """A link as a run has it."""
    opened = Link(bus, CHANNEL)
    opened.watch([NODE_ID])
    yield opened
    opened.close()


@pytest.fixture
def peer(link: Link) -> Iterator[Peer]:
    """Another node on the bus, which is there when the link is."""
    opened = Peer()
    yield opened
    opened.close()


def test_a_block_goes_out_without_loss(link: Link, peer: Peer) -> None:
    for frame in BURST:
        link.send(frame)
    assert [peer.receive() for _ in BURST] == BURST


def test_a_block_comes_in_without_loss(link: Link, peer: Peer) -> None:
    for frame in BURST:
        peer.send(frame)
    assert [link.receive(PATIENCE) for _ in BURST] == BURST
    assert link.receive(0) is None


def test_what_the_link_sends_does_not_come_back(link: Link, peer: Peer) -> None:
    for frame in BURST:
        link.send(frame)
    peer.send(LAST)
    assert link.receive(PATIENCE) == LAST


def test_the_same_frame_from_another_program_does_come_in(link: Link, peer: Peer) -> None:
    """It is the sign of a second client; the kernel marks it as one from this machine, too."""
    request = CanFrame(0x600 + NODE_ID, bytes.fromhex("4000100000000000"))
    link.send(request)
    peer.send(request)
    assert link.receive(PATIENCE) == request


PASSED = [
    CanFrame(0x000, b"\x81\x05"),  # NMT
    CanFrame(0x085, bytes(8)),  # EMCY of the node
    CanFrame(0x185, bytes(8)),  # its PDO
    CanFrame(0x585, bytes(8)),
    CanFrame(0x585, b""),
    CanFrame(0x585, remote=True, length=8),
    CanFrame(0x585, bytes(8), extended=True),
    CanFrame(0x585, remote=True, length=0, extended=True),
    CanFrame(0x605, bytes(8)),
    CanFrame(0x586, bytes(8)),  # SDO of another node
    CanFrame(0x606, bytes(8)),
    CanFrame(0x705, b"\x00"),
    CanFrame(0x77F, b"\x05"),
    CanFrame(0x1234567, bytes(8), extended=True),
]
HELD_BACK = [
    CanFrame(0x080, b""),  # SYNC
    CanFrame(0x100, bytes(6)),  # TIME
    CanFrame(0x086, bytes(8)),  # EMCY of another node
    CanFrame(0x186, bytes(8)),  # its PDOs
    CanFrame(0x506, bytes(8)),
    CanFrame(0x506, remote=True, length=8),
    CanFrame(0x7E4, bytes(8)),  # LSS
]


@pytest.mark.parametrize("frame", PASSED, ids=str)
def test_the_link_receives_a_frame_as_it_is(link: Link, peer: Peer, frame: CanFrame) -> None:
    peer.send(frame)
    assert link.receive(PATIENCE) == frame


def test_the_kernel_holds_back_what_the_run_does_not_need(
    bus: can.BusABC, link: Link, peer: Peer
) -> None:
    for frame in (*HELD_BACK, *PASSED, *HELD_BACK, LAST):
        peer.send(frame)
    # Past python-can, which would filter in software what the kernel lets through; several
    # filters fit some frames, and still they are delivered once.
    with socket.socket(fileno=os.dup(bus.fileno())) as raw:
        raw.settimeout(PATIENCE)
        delivered = list(iter(lambda: read_frame(raw), LAST))
    assert delivered == PASSED
