"""The reference node stores its parameters and loads its defaults when it is told to."""

import pytest

from conformance.faults.catalogue import build_node
from conformance.reference.node import Node
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort, DownloadInitiate, DownloadInitiateResponse
from conformance.sdo.layout import Message, Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.storage_commands import LOAD, LOAD_ALL, ON_COMMAND, SAVE, SAVE_ALL

NUMBER = Multiplexer(0x2004)
DEFAULT, OTHER = bytes.fromhex("11223344"), bytes.fromhex("0A0B0C0D")


@pytest.fixture
def node() -> Node:
    booted = build_node(None, 5)
    booted.start()
    return booted


def write(node: Node, mux: Multiplexer, data: bytes, answer: Message | None = None) -> None:
    (frame,) = node.receive(CanFrame(0x605, DownloadInitiate.with_data(mux, data).encode()))
    assert frame.data == (answer or DownloadInitiateResponse(mux)).encode()


def value(node: Node) -> bytes:
    return node.objects.find(NUMBER).value


def test_what_was_stored_outlasts_resets(node: Node) -> None:
    write(node, NUMBER, OTHER)
    write(node, SAVE_ALL, SAVE)
    write(node, NUMBER, DEFAULT)
    node.follow(NmtCommand.RESET_NODE)
    assert value(node) == OTHER


def test_defaults_come_with_the_next_reset_of_the_node(node: Node) -> None:
    write(node, NUMBER, OTHER)
    write(node, SAVE_ALL, SAVE)
    write(node, LOAD_ALL, LOAD)
    assert value(node) == OTHER
    node.follow(NmtCommand.RESET_COMMUNICATION)
    assert value(node) == OTHER
    node.follow(NmtCommand.RESET_NODE)
    assert value(node) == DEFAULT


@pytest.mark.parametrize("mux", [SAVE_ALL, LOAD_ALL], ids=str)
@pytest.mark.parametrize("signature", [b"LOAD", b"evas", b"\1\0\0\0"])
def test_another_signature_is_refused(node: Node, mux: Multiplexer, signature: bytes) -> None:
    write(node, NUMBER, OTHER)
    write(node, mux, signature, Abort(mux, AbortCode.NOT_TRANSFERABLE))
    node.follow(NmtCommand.RESET_NODE)
    assert value(node) == DEFAULT


def test_a_command_reads_as_what_the_device_can_do(node: Node) -> None:
    for mux, signature in ((SAVE_ALL, SAVE), (LOAD_ALL, LOAD)):
        write(node, mux, signature)
        assert node.objects.find(mux).value == ON_COMMAND
