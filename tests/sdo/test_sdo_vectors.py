"""The worked exchanges: the reference server answers and the reference client asks like them."""

from collections.abc import Iterator
from itertools import pairwise

import pytest
from sdo_conversation import Transfer, drive
from sdo_vector_objects import OBJECTS, WRITTEN, entries
from support.sdo_vectors import Step, Vector, load

from conformance.reference.server import Server
from conformance.sdo.checks import ResponseChecks, ServerAborted
from conformance.sdo.client import Client
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import (
    DownloadInitiate,
    DownloadSegment,
    UploadInitiate,
)
from conformance.sdo.objects import ObjectDictionary
from conformance.sdo.rules import Violation

VECTORS = load()

# These are replayed in test_sdo_block_transfers.
BLOCK_TRANSFERS = [
    *("V04", "V23", "V24", "V25", "V26", "V27", "V28", "V29", "V61", "V63", "V70", "V80", "V81"),
    *("V82", "V84", "V85", "V86", "V87", "V89", "V91", "V92", "V93", "V99", "V102"),
]
PLAIN = [vector_id for vector_id in VECTORS if vector_id not in BLOCK_TRANSFERS]

# Where CiA 301 leaves a choice, or the server of the exchange was at fault.
SERVER_DEVIATIONS = {
    "V15": "the multiplexer of an abort without a transfer is open; there it was a stale one",
    "V18": "a value too high is refused with 06090031h, more precise than 06090030h",
    "V33": "a restricted CAN-ID is a limit like any other here, refused with 06090032h",
    "V60": "its server echoes the multiplexer in reserved bytes",
    "V64": "the answer to an upload of 1 byte indicates its size",
    "V65": "its server delivers more than it announces",
}
# Requests that a strict client does not send.
CLIENT_DEVIATIONS = {
    "V15": "there is no command specifier 7",
    "V22": "the toggle bit of the first segment is 0",
    "V44": "reserved bytes are sent as 0",
    "V55": "n is stated in every segment",
    "V56": "the client does not fall silent in mid-transfer",
    "V94": "only the last segment is short",
    "V97": "no more is sent than was announced",
    "V101": "the client does not abort in mid-transfer",
}
# What the client minds in the responses.
VIOLATIONS = {
    "V60": ["response.reserved", "response.reserved"],
    "V65": ["upload.size"],
}


def test_the_block_transfers_are_those_listed() -> None:
    found = [vector.id for vector in VECTORS.values() if vector.uses_block_transfer]
    assert found == BLOCK_TRANSFERS
    assert list(OBJECTS) == PLAIN
    assert {*SERVER_DEVIATIONS, *CLIENT_DEVIATIONS, *WRITTEN, *VIOLATIONS} <= set(PLAIN)


# The server


def answered(server: Server, vector: Vector) -> list[bytes]:
    """Return what the server sends when the client sends what it sent in the exchange."""
    answers: list[bytes] = []
    for step in vector.steps:
        if step.direction == "request":
            answers += server.receive(step.frame)
        elif step.direction == "silence":
            answers += server.expire()
    return answers


@pytest.mark.parametrize("vector_id", PLAIN)
def test_server(vector_id: str) -> None:
    vector = VECTORS[vector_id]
    server = Server(ObjectDictionary(entries(vector_id)))
    as_worked = answered(server, vector) == vector.of("response")
    assert as_worked == (vector_id not in SERVER_DEVIATIONS), vector.text


@pytest.mark.parametrize("vector_id", [name for name in PLAIN if name not in SERVER_DEVIATIONS])
def test_server_answers_each_request_at_once(vector_id: str) -> None:
    server = Server(ObjectDictionary(entries(vector_id)))
    pending: list[bytes] = []
    for step in VECTORS[vector_id].steps:
        if step.direction == "response":
            assert pending.pop(0) == step.frame
        else:
            assert pending == []
            pending = server.expire() if not step.frame else server.receive(step.frame)
    assert pending == []


@pytest.mark.parametrize("vector_id", PLAIN)
def test_what_the_server_has_written(vector_id: str) -> None:
    objects = entries(vector_id)
    answered(Server(ObjectDictionary(objects)), VECTORS[vector_id])
    expected = {mux: entry.value for mux, entry in entries(vector_id).items()}
    if vector_id in WRITTEN:
        assert len(expected) == 1
        expected = dict.fromkeys(expected, WRITTEN[vector_id])
    assert {mux: entry.value for mux, entry in objects.items()} == expected


# The client


def transfers(vector: Vector, client: Client) -> Iterator[tuple[Transfer, list[Step]]]:
    """Split an exchange into the client's transfers, with the frames of each."""
    starts = [
        number
        for number, step in enumerate(vector.steps)
        if step.direction == "request" and step.frame[0] >> 5 in (1, 2)
    ]
    for start, stop in pairwise([*starts, len(vector.steps)]):
        steps = list(vector.steps[start:stop])
        yield transfer_of(client, steps), steps


def transfer_of(client: Client, steps: list[Step]) -> Transfer:
    """Tell from the requests what the client was about to do."""
    requests = [decode_request(step.frame) for step in steps if step.direction == "request"]
    match requests[0]:
        case UploadInitiate(mux=mux):
            return client.upload(mux)
        case DownloadInitiate(mux=mux, expedited=True, sized=sized, data=data):
            return client.download(mux, data, segmented=False, sized=sized)
        case DownloadInitiate(mux=mux, size=size):
            segments = [segment for segment in requests if isinstance(segment, DownloadSegment)]
            data = b"".join(segment.data for segment in segments)[:size]
            # A download that was refused at once has shown nothing but its size.
            data = data if segments else bytes(size or 0)
            return client.download(mux, data, segmented=True, sized=size is not None)
    raise AssertionError(f"no transfer begins with {requests[0]}")


def asked(vector: Vector, noted: list[Violation]) -> list[bytes]:
    """Return what the client sends when the server answers as in the exchange."""
    requests = []
    for transfer, steps in transfers(vector, Client(ResponseChecks(noted.append))):
        responses = [step.frame for step in steps if step.direction == "response"]
        ended = drive(transfer, responses)
        requests += ended.requests
        assert ended.finished or vector.id in CLIENT_DEVIATIONS
        if isinstance(ended.error, Violation):
            noted.append(ended.error)
        elif isinstance(ended.error, ServerAborted):
            assert ended.error.abort.encode() == responses[-1]
    return requests


@pytest.mark.parametrize("vector_id", PLAIN)
def test_client(vector_id: str) -> None:
    vector = VECTORS[vector_id]
    as_worked = asked(vector, []) == vector.of("request")
    assert as_worked == (vector_id not in CLIENT_DEVIATIONS), vector.text


@pytest.mark.parametrize("vector_id", [name for name in PLAIN if name not in CLIENT_DEVIATIONS])
def test_what_the_client_minds(vector_id: str) -> None:
    noted: list[Violation] = []
    asked(VECTORS[vector_id], noted)
    assert [violation.rule.id for violation in noted] == VIOLATIONS.get(vector_id, [])
