"""Errors of the application: the emergencies that the node sends, its register and its list."""

import pytest
from sdo_server_bench import objects

from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.emergency import ErrorCode, error_list, register_of
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import ObjectDictionary

ERROR_CODE = Multiplexer(0x2140)
CONFIRMED = CanFrame(0x585, bytes.fromhex("6040210000000000"))
BOOT_UP = CanFrame(0x705, b"\0")
EMPTY = "0800 0024"
NOT_ALLOWED = "0609 0030"
STOP, PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION = b"\x02", b"\x80", b"\x81", b"\x82"


def started(places: int = 2) -> Node:
    entries = objects() | {ERROR_CODE: ErrorCode.none()} | error_list(places)
    node = Node(5, Server(ObjectDictionary(entries)))
    assert node.start() == [BOOT_UP]
    return node


def command(specifier: bytes) -> CanFrame:
    return CanFrame(0, specifier + b"\x05")


def emergency(code: int, register: int) -> CanFrame:
    return CanFrame(0x085, code.to_bytes(2, "little") + bytes((register,)) + bytes(5))


def written(code: int) -> CanFrame:
    return CanFrame(0x605, b"\x2b\x40\x21\x00" + code.to_bytes(2, "little") + bytes(2))


def read(node: Node, index: int, sub_index: int = 0) -> str:
    """Read an entry of up to 4 bytes: its number in hexadecimal, or the abort code."""
    request = b"\x40" + index.to_bytes(2, "little") + bytes((sub_index, 0, 0, 0, 0))
    (answer,) = node.receive(CanFrame(0x605, request))
    number = answer.data[7:3:-1].hex()
    return f"{number[:4]} {number[4:]}" if answer.data[0] == 0x80 else number.lstrip("0") or "0"


def test_a_change_of_the_error_code_is_told_once() -> None:
    node = started()
    assert node.receive(written(0)) == [CONFIRMED]
    assert node.receive(written(0x8110)) == [CONFIRMED, emergency(0x8110, 0x11)]
    assert node.receive(written(0x8110)) == [CONFIRMED]
    assert read(node, 0x1001) == "11"
    assert node.receive(written(0x3100)) == [CONFIRMED, emergency(0x3100, 0x05)]
    assert node.receive(written(0)) == [CONFIRMED, emergency(0, 0)]
    assert read(node, 0x1001) == "0"
    assert node.receive(written(0)) == [CONFIRMED]


@pytest.mark.parametrize(
    ("code", "register"),
    [
        (0x0000, 0x00),
        (0x0055, 0x00),
        (0x1000, 0x01),
        (0x2310, 0x03),
        (0x3110, 0x05),
        (0x4200, 0x09),
        (0x6100, 0x01),
        (0x8000, 0x01),
        (0x8130, 0x11),
        (0x8210, 0x11),
        (0x9000, 0x01),
        (0xF010, 0x01),
        (0xFF00, 0x81),
    ],
    ids=lambda number: f"{number:04X}h",
)
def test_the_register_says_what_kind_of_error_there_is(code: int, register: int) -> None:
    assert register_of(code) == register


def test_the_list_keeps_the_latest_errors() -> None:
    node = started(places=2)
    assert [read(node, 0x1003, sub) for sub in range(4)] == ["0", EMPTY, EMPTY, "0609 0011"]
    node.receive(written(0x1000))
    assert [read(node, 0x1003, sub) for sub in range(3)] == ["1", "1000", EMPTY]
    node.receive(written(0))
    assert read(node, 0x1003) == "1", "that an error is over is no error"
    node.receive(written(0x2000))
    node.receive(written(0x3000))
    assert [read(node, 0x1003, sub) for sub in range(3)] == ["2", "3000", "2000"]


def test_only_0_is_taken_for_the_number_of_errors_and_clears_the_list() -> None:
    node = started()
    node.receive(written(0x1000))
    (refused,) = node.receive(CanFrame(0x605, bytes.fromhex("2F03100001000000")))
    assert refused.data.hex() == "8003100030000906"
    assert read(node, 0x1003, 1) == "1000"
    (cleared,) = node.receive(CanFrame(0x605, bytes.fromhex("2F03100000000000")))
    assert cleared.data.hex() == "6003100000000000"
    assert [read(node, 0x1003, sub) for sub in range(2)] == ["0", EMPTY]
    assert read(node, 0x1001) == "1", "the error itself is still there"


def test_an_error_outlives_a_reset_of_the_communication_only() -> None:
    node = started()
    node.receive(written(0x8110))
    told_anew = [BOOT_UP, emergency(0x8110, 0x11)]
    assert node.receive(command(RESET_COMMUNICATION)) == told_anew
    assert read(node, 0x1001) == "11"
    assert [read(node, 0x1003, sub) for sub in range(3)] == ["1", "8110", EMPTY]
    assert node.receive(command(RESET_NODE)) == [BOOT_UP]
    assert read(node, 0x1001) == "0"
    assert read(node, 0x1003) == "0"


def test_a_stopped_node_tells_of_no_error() -> None:
    node = started()
    node.receive(command(STOP))
    assert node.receive(written(0x8110)) == []
    assert node.receive(command(PRE_OPERATIONAL)) == []
    assert read(node, 0x1001) == "0"


def test_a_node_without_an_error_code_has_no_errors() -> None:
    node = Node(5, Server(ObjectDictionary(objects())))
    assert node.start() == [BOOT_UP]
    assert read(node, 0x1001) == "0"
    assert read(node, 0x1003) == "0602 0000"
