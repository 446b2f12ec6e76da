"""NMT: the table of states, the messages, and how a node follows them."""

import pytest
from sdo_server_bench import objects

from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.nmt import NmtCommand, NmtMessage, NmtState, decode_nmt, describe_nmt
from conformance.sdo.objects import ObjectDictionary

READ = bytes.fromhex("4000100000000000")
UPLOAD = bytes.fromhex("4008100000000000")
SEGMENT = bytes.fromhex("6000000000000000")
BOOT_UP = CanFrame(0x705, b"\0")

START, STOP, PRE_OPERATIONAL = b"\x01", b"\x02", b"\x80"
RESET_NODE, RESET_COMMUNICATION = b"\x81", b"\x82"


def started() -> Node:
    node = Node(5, Server(ObjectDictionary(objects())))
    node.start()
    return node


def command(specifier: bytes, node_id: int = 5) -> CanFrame:
    return CanFrame(0, specifier + bytes((node_id,)))


TABLE = {
    START: (NmtState.OPERATIONAL, []),
    STOP: (NmtState.STOPPED, []),
    PRE_OPERATIONAL: (NmtState.PRE_OPERATIONAL, []),
    RESET_NODE: (NmtState.PRE_OPERATIONAL, [BOOT_UP]),
    RESET_COMMUNICATION: (NmtState.PRE_OPERATIONAL, [BOOT_UP]),
}


@pytest.mark.parametrize("node_id", [0, 5], ids=["all", "own"])
@pytest.mark.parametrize("before", [START, STOP, PRE_OPERATIONAL], ids=bytes.hex)
@pytest.mark.parametrize("specifier", TABLE, ids=bytes.hex)
def test_every_command_in_every_state(before: bytes, specifier: bytes, node_id: int) -> None:
    node = started()
    node.receive(command(before))
    state, frames = TABLE[specifier]
    assert node.receive(command(specifier, node_id)) == frames
    assert node.state is state
    assert bool(node.receive(CanFrame(0x605, READ))) is (state is not NmtState.STOPPED)


@pytest.mark.parametrize(
    "frame",
    [
        command(STOP, 6),
        CanFrame(0, STOP),
        CanFrame(0, STOP + b"\x05\x00"),
        CanFrame(0, b"\x03\x05"),
        CanFrame(0, STOP + b"\x05", extended=True),
        CanFrame(0, remote=True, length=2),
        CanFrame(5, STOP + b"\x05"),
    ],
    ids=str,
)
def test_what_is_no_command_to_it(frame: CanFrame) -> None:
    node = started()
    assert node.receive(frame) == []
    assert node.state is NmtState.PRE_OPERATIONAL


def test_nothing_is_served_before_the_boot_up() -> None:
    node = Node(5, Server(ObjectDictionary(objects())))
    assert node.receive(CanFrame(0x605, READ)) == []
    assert node.start() == [BOOT_UP]
    assert node.receive(CanFrame(0x605, READ))


@pytest.mark.parametrize("specifier", [STOP, RESET_NODE, RESET_COMMUNICATION], ids=bytes.hex)
def test_a_running_transfer_ends_in_silence(specifier: bytes) -> None:
    node = started()
    node.receive(CanFrame(0x605, UPLOAD))
    assert CanFrame(0x585, SEGMENT) not in node.receive(command(specifier))
    node.receive(command(PRE_OPERATIONAL))
    (answer,) = node.receive(CanFrame(0x605, SEGMENT))
    assert answer.data.hex() == "8000000001000405"


@pytest.mark.parametrize("specifier", [START, PRE_OPERATIONAL], ids=bytes.hex)
def test_a_running_transfer_goes_on_where_sdo_does(specifier: bytes) -> None:
    node = started()
    node.receive(CanFrame(0x605, UPLOAD))
    node.receive(command(specifier))
    (answer,) = node.receive(CanFrame(0x605, SEGMENT))
    assert answer.data[0] >> 5 == 0


@pytest.mark.parametrize(
    ("specifier", "number", "heartbeat"),
    [(RESET_COMMUNICATION, "0700", "0000"), (RESET_NODE, "0500", "0000")],
    ids=["communication", "node"],
)
def test_power_on_values(specifier: bytes, number: str, heartbeat: str) -> None:
    """A reset of the communication leaves the objects of the application alone."""
    node = started()
    node.receive(CanFrame(0x605, bytes.fromhex("2B17100064000000")))
    node.receive(CanFrame(0x605, bytes.fromhex("2B03200007000000")))
    node.receive(command(specifier))
    (own,) = node.receive(CanFrame(0x605, bytes.fromhex("4003200000000000")))
    (beat,) = node.receive(CanFrame(0x605, bytes.fromhex("4017100000000000")))
    assert own.data[4:6].hex() == number
    assert beat.data[4:6].hex() == heartbeat


@pytest.mark.parametrize("specifier", list(NmtCommand))
def test_commands_on_the_wire(specifier: NmtCommand) -> None:
    message = NmtMessage(specifier, 17)
    assert message.frame() == CanFrame(0, bytes((specifier, 17)))
    assert decode_nmt(message.frame()) == message


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        (command(STOP), "NMT: stop, node 5"),
        (command(RESET_COMMUNICATION, 0), "NMT: reset communication, all nodes"),
        (BOOT_UP, "boot-up of node 5"),
        (CanFrame(0x705, b"\x7f"), "heartbeat of node 5: pre-operational"),
        (CanFrame(0x705, b"\x04"), "heartbeat of node 5: stopped"),
        (
            CanFrame(0x085, bytes.fromhex("1081110000000000")),
            "emergency of node 5: error code 8110h, error register 11h",
        ),
        (CanFrame(0x085, bytes(8)), "emergency of node 5: no error any more, error register 00h"),
        (CanFrame(0x080), ""),
        (CanFrame(0x705, b"\x09"), ""),
        (CanFrame(0x705, b""), ""),
        (CanFrame(0x605, READ), ""),
        (CanFrame(0, b"\x07\x05"), ""),
    ],
    ids=str,
)
def test_in_words(frame: CanFrame, words: str) -> None:
    assert describe_nmt(frame) == words
