"""Block transfers: the worked exchanges, and client and server against each other with losses."""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from random import Random
from typing import Any

import pytest
from support.sdo_vectors import Step as Frame
from support.sdo_vectors import Vector, load, mux
from test_sdo_vectors import BLOCK_TRANSFERS, answered

from conformance.reference.server import Server
from conformance.sdo.block_client import BlockClient, Burst, Step
from conformance.sdo.checks import ServerAborted
from conformance.sdo.client import Uploaded
from conformance.sdo.crc import crc16
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    DownloadInitiate,
    Response,
    UploadInitiate,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.line import Line
from conformance.sdo.objects import DataType, Entry, ObjectDictionary
from conformance.sdo.rules import Violation
from conformance.sdo.stepping import Ended, Result, advance

VECTORS = load()
TINY = b"Tiny Node - Mega Domains !"
DEMO = b"CANopenDemoPIC32"
U32, U16, TEXT = DataType.UNSIGNED32, DataType.UNSIGNED16, DataType.VISIBLE_STRING
DOMAIN = DataType.DOMAIN

OBJECTS: dict[str, list[tuple[str, bytes, DataType]]] = {
    "V04": [("1008", TINY, TEXT)],
    "V23": [("1000", bytes.fromhex("91010F00"), U32)],
    "V24": [("1017", bytes(2), U16)],
    "V25": [("1008", DEMO, TEXT)],
    "V26": [("1008", DEMO, TEXT)],
    "V27": [("1017", bytes(2), U16)],
    "V28": [("1000", bytes.fromhex("91010F00"), U32)],
    "V29": [("1000", bytes.fromhex("91010F00"), U32)],
    "V61": [("2000", b"", TEXT)],
    "V63": [("1008", TINY, TEXT)],
    "V70": [("1000", bytes.fromhex("92010200"), U32), ("1017", bytes(2), U16)],
    **{name: [("2004", b"", DOMAIN)] for name in ("V80", "V81", "V82", "V84", "V86", "V87")},
    "V85": [("2000", bytes(4), U32)],
    "V89": [("1008", TINY, TEXT)],
    "V91": [("1008", TINY, TEXT)],
    "V92": [("1000", bytes.fromhex("92010200"), U32)],
    "V93": [("1000", bytes.fromhex("92010200"), U32)],
    "V99": [("1008", TINY, TEXT)],
    "V102": [("2005", bytes.fromhex("1122334455667788"), DOMAIN)],
}
SERVER_DEVIATIONS = {
    "V04": "its server computes no CRC",
    "V29": "an impossible ackseq is refused with 05040003h, more precise than 05040001h",
    "V87": "whether a server offers a CRC to a client without one is open; there it did not",
}
CLIENT_DEVIATIONS = {
    "V84": "the client computes the right CRC",
    "V99": "the client starts before it acknowledges",
}


def objects_of(vector_id: str) -> dict[Multiplexer, Entry]:
    return {mux(name): Entry(value, kind) for name, value, kind in OBJECTS[vector_id]}


def test_all_block_exchanges_are_here() -> None:
    assert set(OBJECTS) == set(BLOCK_TRANSFERS)


@pytest.mark.parametrize("vector_id", BLOCK_TRANSFERS)
def test_server(vector_id: str) -> None:
    vector = VECTORS[vector_id]
    server = Server(ObjectDictionary(objects_of(vector_id)))
    as_worked = answered(server, vector) == vector.of("response")
    assert as_worked == (vector_id not in SERVER_DEVIATIONS), vector.text


# The client


@dataclass
class Driven:
    """What a transfer sent while it was fed the responses of an exchange."""

    requests: list[bytes] = field(default_factory=list)
    error: Exception | None = None


def drive(transfer: Generator[Step, Response, object], responses: Sequence[bytes]) -> Driven:
    """Run a transfer until it ends or the responses are used up."""
    driven, left = Driven(), list(responses)
    try:
        step = next(transfer)
        while True:
            burst = step if isinstance(step, Burst) else Burst((step,))
            driven.requests += [request.encode() for request in burst.requests]
            if burst.awaited and not left:
                break
            step = transfer.send(decode_response(left.pop(0))) if burst.awaited else next(transfer)
    except StopIteration:
        pass
    except (Violation, ServerAborted) as error:
        driven.error = error
    return driven


def transfers(vector: Vector) -> list[list[Frame]]:
    """Split an exchange where initiates begin, outside of sub-blocks."""
    line = Line()
    starts = []
    for number, step in enumerate(vector.steps):
        if step.direction == "response":
            line.response(step.frame)
            continue
        initiates = (BlockDownloadInitiate, BlockUploadInitiate, DownloadInitiate, UploadInitiate)
        if isinstance(line.request(step.frame), initiates):
            starts.append(number)
    return [
        list(vector.steps[start:stop]) for start, stop in pairwise([*starts, len(vector.steps)])
    ]


def transfer_of(steps: list[Frame]) -> Generator[Step, Response, Any]:
    """Tell from the requests of an exchange what its client was about to do."""
    line, requests = Line(), []
    for step in steps:
        if step.direction == "request":
            requests.append(line.request(step.frame))
        else:
            line.response(step.frame)
    client = BlockClient()
    acks = [request for request in requests if isinstance(request, BlockAck)]
    match requests[0]:
        case UploadInitiate(mux=name):
            return client.upload(name)
        case BlockUploadInitiate(mux=name, block_size=size, threshold=pst, crc_supported=crc):
            sequences = [ack.sequence for ack in acks]
            sizes = [ack.block_size for ack in acks]
            return client.block_upload(
                name,
                block_size=size,
                threshold=pst,
                crc=crc,
                acknowledge=lambda received: sequences.pop(0),
                next_block_size=lambda before: sizes.pop(0),
            )
        case BlockDownloadInitiate(mux=name, crc_supported=crc, size=announced):
            segments = [request for request in requests if isinstance(request, BlockSegment)]
            lost = [3] if vector_loses(segments) else []
            data = payload_of(segments, lost)
            end = next(request for request in requests if isinstance(request, BlockEnd))
            data = data[: len(data) - end.unused]

            def lose(sub_block: list[BlockSegment]) -> list[BlockSegment]:
                gone = lost.pop() if lost else 0
                return [segment for segment in sub_block if segment.sequence != gone]

            sized = announced is not None
            return client.block_download(name, data, sized=sized, crc=crc, mangle=lose)
    raise AssertionError(f"no transfer begins with {requests[0]}")


def vector_loses(segments: list[BlockSegment]) -> bool:
    numbers = [segment.sequence for segment in segments]
    return numbers != list(range(1, len(numbers) + 1))


def payload_of(segments: list[BlockSegment], lost: list[int]) -> bytes:
    """Put together what the client had: with a segment lost, what came before and what again."""
    if not lost:
        return b"".join(segment.payload for segment in segments)
    again = [number for number, segment in enumerate(segments) if segment.sequence == 1][1]
    return b"".join(segment.payload for segment in [*segments[: lost[0] - 1], *segments[again:]])


@pytest.mark.parametrize("vector_id", BLOCK_TRANSFERS)
def test_client(vector_id: str) -> None:
    vector = VECTORS[vector_id]
    requests: list[bytes] = []
    for steps in transfers(vector):
        responses = [step.frame for step in steps if step.direction == "response"]
        driven = drive(transfer_of(steps), responses)
        assert not isinstance(driven.error, Violation) or vector_id in CLIENT_DEVIATIONS
        requests += driven.requests
    as_worked = requests == vector.of("request")
    assert as_worked == (vector_id not in CLIENT_DEVIATIONS), vector.text


# Client and server, with what lies between them

NAME = Multiplexer(0x2000)
SIZES = [*range(23), 888, 889, 890, 1778, 65_535, 65_536, 70_000]


def converse(transfer: Generator[Step, Response, Result], server: Server) -> Result:
    """Run a transfer against a server; return its result."""
    answers: list[Response] = []
    step = advance(transfer)
    while not isinstance(step, Ended):
        burst = step if isinstance(step, Burst) else Burst((step,))
        for request in burst.requests:
            answers += map(decode_response, server.receive(request.encode()))
        step = advance(transfer, answers.pop(0) if burst.awaited else None)
    assert answers == []
    return step.result


def server_with(value: bytes) -> tuple[Server, Entry]:
    entry = Entry(value, DOMAIN, capacity=1 << 21)
    return Server(ObjectDictionary({NAME: entry})), entry


def losing(random: Random) -> Callable[[list[BlockSegment]], list[BlockSegment]]:
    """Lose a segment of every other sub-block, but never the one at its end."""

    def mangle(sub_block: list[BlockSegment]) -> list[BlockSegment]:
        if len(sub_block) < 2 or random.random() < 0.5:
            return sub_block
        gone = random.randrange(len(sub_block) - 1)
        return sub_block[:gone] + sub_block[gone + 1 :]

    return mangle


@pytest.mark.parametrize("crc", [True, False])
@pytest.mark.parametrize("size", SIZES)
def test_download_with_losses(size: int, crc: bool) -> None:
    random = Random(size)
    data = random.randbytes(size)
    server, entry = server_with(b"")
    transfer = BlockClient().block_download(NAME, data, crc=crc, mangle=losing(random))
    converse(transfer, server)
    assert entry.value == data


@pytest.mark.parametrize("crc", [True, False])
@pytest.mark.parametrize("size", SIZES)
def test_upload_with_losses(size: int, crc: bool) -> None:
    random = Random(size)
    data = random.randbytes(size)
    server, _ = server_with(data)
    transfer = BlockClient().block_upload(
        NAME,
        block_size=random.randint(1, 127),
        crc=crc,
        acknowledge=lambda received: received - (random.random() < 0.3 and received > 1),
        next_block_size=lambda before: random.randint(1, 127),
    )
    result: Uploaded = converse(transfer, server)
    assert result.data == data


def test_a_mebibyte_both_ways() -> None:
    data = Random(1).randbytes(1 << 20)
    server, entry = server_with(b"")
    converse(BlockClient().block_download(NAME, data), server)
    assert crc16(entry.value) == crc16(data)
    assert converse(BlockClient().block_upload(NAME), server).data == data
