"""The reference server as a node: what reaches it, and how it answers."""

import pytest
from sdo_server_bench import objects

from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.objects import ObjectDictionary

READ = bytes.fromhex("4000100000000000")
UPLOAD = bytes.fromhex("4008100000000000")


def node(node_id: int = 5) -> Node:
    booted = Node(node_id, Server(ObjectDictionary(objects())))
    booted.start()
    return booted


@pytest.mark.parametrize(
    ("node_id", "request_id", "response_id"), [(1, 0x601, 0x581), (127, 0x67F, 0x5FF)]
)
def test_default_channel(node_id: int, request_id: int, response_id: int) -> None:
    answer = bytes.fromhex("4300100091010F00")
    assert node(node_id).receive(CanFrame(request_id, READ)) == [CanFrame(response_id, answer)]


@pytest.mark.parametrize(
    "frame",
    [
        CanFrame(0x604, READ),
        CanFrame(0x585, READ),
        CanFrame(0x605, READ, extended=True),
        CanFrame(0x605, remote=True, length=8),
        CanFrame(0x605, READ[:7]),
    ],
    ids=str,
)
def test_what_is_no_request_to_it_is_not_answered(frame: CanFrame) -> None:
    assert node().receive(frame) == []


def test_boot_up_message() -> None:
    assert node().start() == [CanFrame(0x705, b"\x00")]


@pytest.mark.parametrize(
    ("frame", "text", "dlc"),
    [
        (CanFrame(0x605, READ), "605#4000100000000000", 8),
        (CanFrame(0x605, b""), "605#", 0),
        (CanFrame(0x18FF0005, b"\x01", extended=True), "18FF0005#01", 1),
        (CanFrame(0x605, remote=True, length=8), "605#R8", 8),
        (CanFrame(0x605, remote=True, length=0), "605#R", 0),
        (CanFrame(0x605, READ, fd=True), "605##04000100000000000", 8),
    ],
)
def test_a_frame_is_written_as_cansend_takes_it(frame: CanFrame, text: str, dlc: int) -> None:
    assert str(frame) == text
    assert frame.dlc == dlc
    read = CanFrame.parse(text)
    assert (str(read), read.dlc) == (text, dlc)


@pytest.mark.parametrize("text", ["", "605", "605#4", "65#40", "605#R9", "605#40 x", "x#40"])
def test_other_text_is_no_frame(text: str) -> None:
    with pytest.raises(ValueError, match="is no frame as cansend takes it"):
        CanFrame.parse(text)
