"""Two faults in one server: both act. The table of ``pairs`` is a program of its own."""

import pytest

from conformance.faults.catalogue import UnknownServer, build_node, find_deviation
from conformance.faults.registry import Deviation
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.node import Node
from conformance.sdo.server import Server

NODE_ID = 5
ABORT = "80 18 10 01 00 00 00 08"
ANSWERED = "80 00 00 00 01 00 04 05"
IDENTITY = "43 18 10 01 00 00 00 00"
UNKNOWN = "E0 00 00 00 00 00 00 00"
START_TEXT = "21 10 20 00 0E 00 00 00"
WRONG_TOGGLE = "10 41 42 43 44 45 46 47"


def known(name: str) -> Deviation:
    deviation = find_deviation(name)
    assert deviation is not None
    return deviation


def answers_of(name: str, *requests: str) -> list[tuple[int, str]]:
    """Return what a server answers to some requests: identifiers and data."""
    node = build_node(name, NODE_ID)
    node.start()
    return [
        (answer.can_id, answer.data.hex(" ").upper())
        for request in requests
        for answer in node.receive(CanFrame(0x600 + NODE_ID, bytes.fromhex(request)))
    ]


def test_two_servers_are_one() -> None:
    pair = known("every-abort-answered+unknown-specifier-ignored")
    assert issubclass(pair.kind, Server)
    assert answers_of(pair.name, ABORT) == [(0x585, ANSWERED)]
    assert answers_of(pair.name, UNKNOWN) == []


def test_two_nodes_are_one() -> None:
    pair = known("answer-as-long-as-request+response-copied-to-other-id")
    assert issubclass(pair.kind, Node)
    assert answers_of(pair.name, "40 18 10 01") == [(0x585, IDENTITY[:11]), (0x485, IDENTITY)]


@pytest.mark.parametrize("turned", [False, True])
def test_a_node_and_a_server_are_one(*, turned: bool) -> None:
    names = ["every-abort-answered", "response-copied-to-other-id"]
    pair = known("+".join(reversed(names) if turned else names))
    assert issubclass(pair.kind, Node)
    assert answers_of(pair.name, ABORT) == [(0x585, ANSWERED), (0x485, ANSWERED)]


def test_a_reaction_of_both_is_that_of_both() -> None:
    pair = "abort-in-transfer-unnamed+download-toggle-ignored"
    assert answers_of(pair, START_TEXT, WRONG_TOGGLE)[-1] == (0x585, "30" + " 00" * 7)
    unnamed = (0x585, ANSWERED)
    assert answers_of(pair, START_TEXT, UNKNOWN)[-1] == unnamed


def test_a_pair_of_an_unknown_one_is_unknown() -> None:
    with pytest.raises(UnknownServer, match="every-abort-answered"):
        find_deviation("every-abort-answerd+unknown-specifier-ignored")
