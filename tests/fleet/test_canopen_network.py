"""The reference node as the network of canopen sees it: boot-up, heartbeat, emergencies, NMT.

canopen reads what objects there are from the EDS of the built-in device.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from io import StringIO
from queue import SimpleQueue
from typing import IO

import can
import canopen
import pytest
from canopen.emcy import EmcyError
from canopen.objectdictionary.eds import import_eds
from canopen.sdo.client import SdoClient
from foreign_objects import DOMAIN, NODE_ID, NUMBER, TEXT, payload

from conformance.faults.catalogue import build_node
from conformance.reference.built_in_eds import eds_of
from conformance.reference.dictionary import ERROR_CODE
from conformance.reference.host import NodeHost
from conformance.reference.node import HEARTBEAT_TIME
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.emergency import ERROR_LIST, ERROR_REGISTER

LIMIT = 10.0
COMMUNICATION, CURRENT = 0x8110, 0x2310
SECOND = ChannelIds.parse("681:6A1")
BOOT_UP, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127


@dataclass
class Master:
    """canopen's network with our node in it; keeps what the node says of itself, in order.

    ``second`` is a client on a further channel, which the node does not have before 1201h says so.
    """

    node: canopen.RemoteNode
    second: SdoClient
    states: "SimpleQueue[int]" = field(default_factory=SimpleQueue)
    errors: "SimpleQueue[EmcyError]" = field(default_factory=SimpleQueue)

    def listen(self) -> None:
        """Have canopen tell what comes."""
        self.node.nmt.add_heartbeat_callback(self.states.put)
        self.node.emcy.add_callback(self.errors.put)

    def wait_for(self, *states: int) -> None:
        """Wait for these states, one after the other; they may be told several times."""
        for state in states:
            while self.states.get(timeout=LIMIT) != state:
                pass

    def error(self) -> tuple[int, int]:
        """Wait for an emergency; return its code and its error register."""
        error = self.errors.get(timeout=LIMIT)
        return error.code, error.register

    def read(self, index: int, sub_index: int = 0) -> int:
        """Read a number."""
        return int.from_bytes(self.node.sdo.upload(index, sub_index), "little")

    def write(self, index: int, number: int, length: int, sub_index: int = 0) -> None:
        """Write a number of ``length`` bytes."""
        self.node.sdo.download(index, sub_index, number.to_bytes(length, "little"))


@pytest.fixture
def master(virtual_channel: str) -> Iterator[Master]:
    """canopen's network, which is there before our node boots."""
    ours = build_node(None, NODE_ID)
    with canopen.Network(can.Bus(interface="virtual", channel=virtual_channel)) as network:
        network.NOTIFIER_CYCLE = 0.05
        described = import_eds(StringIO(eds_of(ours)), NODE_ID)  # type: ignore[no-untyped-call]
        node = canopen.RemoteNode(NODE_ID, described)
        second = node.add_sdo(SECOND.request.can_id, SECOND.response.can_id)  # type: ignore[no-untyped-call]
        network.add_node(node)
        second.network = network  # canopen does so for the default channel only
        network.connect()
        node.sdo.RESPONSE_TIMEOUT = second.RESPONSE_TIMEOUT = LIMIT
        found = Master(node, second)
        found.listen()
        with NodeHost(can.Bus(interface="virtual", channel=virtual_channel), ours):
            found.wait_for(BOOT_UP)
            yield found


def test_heartbeat_and_states(master: Master) -> None:
    """A node boots into Pre-operational and follows; each heartbeat tells where it is."""
    nmt = master.node.nmt
    master.write(HEARTBEAT_TIME.index, 10, 2)
    master.wait_for(PRE_OPERATIONAL, PRE_OPERATIONAL)
    nmt.state = "OPERATIONAL"
    master.wait_for(OPERATIONAL)
    assert master.read(NUMBER.index) == 0x44332211
    nmt.state = "STOPPED"
    master.wait_for(STOPPED)
    master.node.sdo.RESPONSE_TIMEOUT = 0.1
    with pytest.raises(canopen.SdoCommunicationError):
        master.read(NUMBER.index)
    master.node.sdo.RESPONSE_TIMEOUT = LIMIT
    nmt.state = "PRE-OPERATIONAL"
    master.wait_for(PRE_OPERATIONAL)
    assert master.read(NUMBER.index) == 0x44332211


@pytest.mark.parametrize(
    ("command", "number"), [("RESET", 0x44332211), ("RESET COMMUNICATION", 0x11111111)]
)
def test_resets(master: Master, command: str, number: int) -> None:
    """Either boots and ends the heartbeats; the application keeps its objects in one of them."""
    master.write(NUMBER.index, 0x11111111, 4)
    master.write(HEARTBEAT_TIME.index, 10, 2)
    master.wait_for(PRE_OPERATIONAL)
    master.node.nmt.state = command
    master.wait_for(BOOT_UP)
    assert master.read(HEARTBEAT_TIME.index) == 0
    assert master.read(NUMBER.index) == number


def test_emergencies(master: Master) -> None:
    """What is written as error code is told, listed, and taken back with 0."""
    master.write(ERROR_CODE.index, COMMUNICATION, 2)
    assert master.error() == (COMMUNICATION, 0x11)
    master.write(ERROR_CODE.index, CURRENT, 2)
    assert master.error() == (CURRENT, 0x03)
    assert [error.code for error in master.node.emcy.active] == [COMMUNICATION, CURRENT]
    assert master.read(ERROR_REGISTER.index) == 0x03
    assert [master.read(ERROR_LIST, sub) for sub in range(3)] == [2, CURRENT, COMMUNICATION]
    master.write(ERROR_CODE.index, 0, 2)
    assert master.error() == (0, 0)
    assert master.node.emcy.active == []
    assert master.read(ERROR_REGISTER.index) == 0
    master.write(ERROR_LIST, 0, 1)
    with pytest.raises(canopen.SdoAbortedError) as aborted:
        master.read(ERROR_LIST, 1)
    assert aborted.value.code == AbortCode.NO_DATA


def test_a_stopped_node_keeps_its_error_and_tells_it_after_a_reset(master: Master) -> None:
    master.write(ERROR_CODE.index, COMMUNICATION, 2)
    assert master.error() == (COMMUNICATION, 0x11)
    master.node.nmt.state = "STOPPED"
    master.node.nmt.state = "RESET COMMUNICATION"
    master.wait_for(BOOT_UP)
    assert master.error() == (COMMUNICATION, 0x11)
    assert master.read(ERROR_CODE.index) == COMMUNICATION


@pytest.mark.parametrize("blocks", [False, True], ids=["segmented", "block"])
def test_emergencies_within_transfers(master: Master, blocks: bool) -> None:
    """While one client is in a transfer, another provokes emergencies: no byte is disturbed."""
    master.write(0x1201, SECOND.request.can_id, 4, 1)
    master.write(0x1201, SECOND.response.can_id, 4, 2)

    def provoke(code: int) -> None:
        master.second.download(ERROR_CODE.index, 0, code.to_bytes(2, "little"))
        assert master.error()[0] == code

    data = payload(4096)
    segment_by_segment = {"block_transfer": blocks, "buffering": 0}
    with stream(master, "wb", size=len(data), **segment_by_segment) as opened:
        for number, start in enumerate(range(0, len(data), 7)):
            if number % 100 == 50:
                provoke(0x1000 + number)
            opened.write(data[start : start + 7])
    found = b""
    with stream(master, "rb", **segment_by_segment) as opened:
        for number in range(-(-len(data) // 7)):
            if number % 100 == 50:
                provoke(0x2000 + number)
            found += opened.read(7)
    assert found == data
    assert master.node.sdo.upload(TEXT.index, 0) == b"text"


def stream(master: Master, mode: str, **options: int) -> IO[bytes]:
    """Open the domain as a file: canopen's own way to move data piece by piece."""
    opened: IO[bytes] = master.node.sdo.open(DOMAIN.index, 0, mode, **options)
    return opened
