"""A node with several SDO channels: their records (CiA 301, 7.5.2.33), their transfers."""

import pytest
from sdo_server_bench import objects

from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import CobId
from conformance.sdo.objects import ObjectDictionary

READ = bytes.fromhex("4000100000000000")
ANSWER = bytes.fromhex("4300100091010F00")
UPLOAD = bytes.fromhex("4008100000000000")
SEGMENT = bytes.fromhex("6000000000000000")
INVALID = 0x8000_0000
CONFIRMED = "60"
VALUE_INVALID = "06090030"
READ_ONLY = "06010002"


def started(server_timeout: float | None = None) -> Node:
    dictionary = ObjectDictionary(objects())
    node = Node(5, *(Server(dictionary) for _ in range(3)), server_timeout=server_timeout)
    node.start()
    return node


def write(node: Node, index: int, sub_index: int, value: int, length: int = 4) -> str:
    """Write a number; return "60" or the abort code."""
    specifier = 0x23 | (4 - length) << 2
    head = bytes((specifier,)) + index.to_bytes(2, "little") + bytes((sub_index,))
    (answer,) = node.receive(CanFrame(0x605, head + value.to_bytes(4, "little")))
    if answer.data[0] == 0x80:
        return answer.data[4:][::-1].hex()
    return answer.data[:1].hex()


def read(node: Node, index: int, sub_index: int) -> int:
    head = b"\x40" + index.to_bytes(2, "little") + bytes((sub_index,))
    (answer,) = node.receive(CanFrame(0x605, head + bytes(4)))
    assert answer.data[0] & 0xE3 == 0x43
    return int.from_bytes(answer.data[4:], "little")


def configure(node: Node, index: int, request: CobId, response: CobId) -> None:
    for sub_index, cob_id in ((1, request), (2, response)):
        assert write(node, index, sub_index, int.from_bytes(bytes(cob_id), "little")) == CONFIRMED


def test_the_default_record() -> None:
    node = started()
    assert [read(node, 0x1200, sub) for sub in range(3)] == [2, 0x605, 0x585]
    for sub_index, length in ((0, 1), (1, 4), (2, 4)):
        assert write(node, 0x1200, sub_index, 0x77, length) == READ_ONLY
    assert [read(node, 0x1200, sub) for sub in range(3)] == [2, 0x605, 0x585]


def test_the_further_records() -> None:
    node = started()
    assert [read(node, 0x1201, sub) for sub in range(3)] == [2, INVALID, INVALID]
    assert [read(node, 0x1202, sub) for sub in range(4)] == [3, INVALID, INVALID, 1]
    (answer,) = node.receive(CanFrame(0x605, bytes.fromhex("4003120100000000")))
    assert answer.data.hex() == "8003120100000206"


@pytest.mark.parametrize(
    ("request_", "response"),
    [
        (CobId(0x681), CobId(0x6A1)),
        (CobId(0x18FF_0681, True), CobId(0x18FF_06A1, True)),
        (CobId(0x681), CobId(0x681, True)),
    ],
    ids=["11-bit", "29-bit", "mixed"],
)
def test_a_channel_in_use(request_: CobId, response: CobId) -> None:
    node = started()
    configure(node, 0x1201, request_, response)
    assert node.receive(request_.frame(READ)) == [response.frame(ANSWER)]
    assert node.receive(CanFrame(0x605, READ)) == [CanFrame(0x585, ANSWER)]
    other_format = CanFrame(request_.can_id, READ, not request_.extended)
    assert node.receive(other_format) == []
    assert node.receive(CanFrame(request_.can_id, b"", request_.extended, True, 8)) == []


@pytest.mark.parametrize("half", [1, 2])
def test_both_halves_have_to_be_valid(half: int) -> None:
    node = started()
    configure(node, 0x1201, CobId(0x681), CobId(0x6A1))
    value = read(node, 0x1201, half)
    assert write(node, 0x1201, half, value | INVALID) == CONFIRMED
    assert node.receive(CanFrame(0x681, READ)) == []
    assert write(node, 0x1201, half, value) == CONFIRMED
    assert node.receive(CanFrame(0x681, READ)) == [CanFrame(0x6A1, ANSWER)]


# What may be written: from, to, answer
CHANGES = [
    (INVALID, 0x681, CONFIRMED),
    (INVALID, 0x8000_0681, CONFIRMED),
    (INVALID, 0x4000_0681, CONFIRMED),
    (INVALID, 0x3FFF_FFFF, CONFIRMED),
    (0x681, 0x681, CONFIRMED),
    (0x681, 0x8000_0681, CONFIRMED),
    (0x681, 0x4000_0681, CONFIRMED),
    (0x681, 0x682, VALUE_INVALID),
    (0x681, 0x8000_0682, VALUE_INVALID),
    (0x681, 0x2000_0681, VALUE_INVALID),
    (0x681, INVALID, VALUE_INVALID),
    (INVALID, 0x0000_0881, VALUE_INVALID),
    (INVALID, 0x8000_0881, VALUE_INVALID),
    (INVALID, 0x1000_0681, VALUE_INVALID),
    *(
        (INVALID, can_id, VALUE_INVALID)
        for can_id in (0, 0x7F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x701, 0x7FF)
    ),
    (0x8000_0601, 0x601, VALUE_INVALID),
]


@pytest.mark.parametrize(("before", "wanted", "answer"), CHANGES)
@pytest.mark.parametrize("sub_index", [1, 2])
def test_changes_of_a_cob_id(before: int, wanted: int, answer: str, sub_index: int) -> None:
    node = started()
    assert write(node, 0x1201, sub_index, before) == CONFIRMED
    assert write(node, 0x1201, sub_index, wanted) == answer
    assert read(node, 0x1201, sub_index) == (wanted if answer == CONFIRMED else before)


@pytest.mark.parametrize(
    ("value", "answer"),
    [(0, VALUE_INVALID), (1, "60"), (127, "60"), (128, VALUE_INVALID), (255, VALUE_INVALID)],
)
def test_the_client_of_a_channel(value: int, answer: str) -> None:
    node = started()
    assert write(node, 0x1202, 3, value, 1) == answer
    assert read(node, 0x1202, 3) == (value if answer == CONFIRMED else 1)
    assert write(node, 0x1202, 0, 3, 1) == READ_ONLY
    assert write(node, 0x1201, 3, 1, 1) == "06090011"


def test_each_channel_has_its_own_transfer() -> None:
    node = started()
    configure(node, 0x1201, CobId(0x681), CobId(0x6A1))
    (first,) = node.receive(CanFrame(0x605, UPLOAD))
    (second,) = node.receive(CanFrame(0x681, UPLOAD))
    assert (first.can_id, second.can_id) == (0x585, 0x6A1)
    (of_first,) = node.receive(CanFrame(0x605, SEGMENT))
    assert node.receive(CanFrame(0x605, bytes.fromhex("8008100000000008"))) == []
    (of_second,) = node.receive(CanFrame(0x681, SEGMENT))
    assert of_first.data == of_second.data


def test_each_channel_has_its_own_deadline() -> None:
    node = started(1.0)
    configure(node, 0x1201, CobId(0x681), CobId(0x6A1))
    node.receive(CanFrame(0x605, UPLOAD))
    node.advance(0.5)
    node.receive(CanFrame(0x681, UPLOAD))
    assert node.wake_at == 1.0
    assert node.advance(1.0) == [CanFrame(0x585, bytes.fromhex("8008100000000405"))]
    assert node.wake_at == 1.5
    assert node.advance(1.5) == [CanFrame(0x6A1, bytes.fromhex("8008100000000405"))]


@pytest.mark.parametrize("specifier", [b"\x81", b"\x82"], ids=["node", "communication"])
def test_a_reset_takes_further_channels_out_of_use(specifier: bytes) -> None:
    node = started()
    configure(node, 0x1201, CobId(0x681), CobId(0x6A1))
    node.receive(CanFrame(0, specifier + b"\x05"))
    assert node.receive(CanFrame(0x681, READ)) == []
    assert read(node, 0x1201, 1) == INVALID


def test_stopped_concerns_all_channels() -> None:
    node = started()
    configure(node, 0x1201, CobId(0x681), CobId(0x6A1))
    node.receive(CanFrame(0, b"\x02\x05"))
    assert node.receive(CanFrame(0x681, READ)) == []
    node.receive(CanFrame(0, b"\x01\x05"))
    assert node.receive(CanFrame(0x681, READ)) == [CanFrame(0x6A1, ANSWER)]
