"""The worked exchanges with block transfers: every frame can be read, every CRC is right."""

from dataclasses import dataclass, field

import pytest
from support.sdo_vectors import Vector, load

from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    Request,
    Response,
    Unknown,
)
from conformance.sdo.layout import Message
from conformance.sdo.line import Line

VECTORS = {name: vector for name, vector in load().items() if vector.uses_block_transfer}
# Exchanges that carry data to the end, and the data of their last block transfer.
DATA = {
    "V04": b"Tiny Node - Mega Domains !",
    "V23": bytes.fromhex("91010F00"),
    "V24": bytes(2),
    "V25": b"CANopenDemoPIC32",
    "V26": b"CANopenDemoPIC32",
    "V27": bytes(2),
    "V61": b"A really really long string...",
    "V63": b"Tiny Node - Mega Domains !",
    "V70": bytes.fromhex("8813"),
    "V80": bytes(range(0x30, 0x3E)),
    "V81": bytes(range(0x40, 0x54)),
    "V82": bytes(range(0x60, 0x83)),
    "V84": bytes(range(0x30, 0x3E)),
    "V85": bytes.fromhex("01020304"),
    "V86": bytes(range(0x30, 0x3E)),
    "V87": bytes(range(0x30, 0x3E)),
    "V89": b"Tiny Node - Mega Domains !",
    "V93": bytes.fromhex("92010200"),
    "V102": bytes.fromhex("1122334455667788"),
}
# Their CRC field is 0: one side, or both, cannot generate a CRC.
WITHOUT_CRC = {"V04", "V23", "V24", "V25", "V70", "V87"}


def read(vector: Vector) -> list[Request | Response]:
    line = Line()
    return [
        line.request(step.frame) if step.direction == "request" else line.response(step.frame)
        for step in vector.steps
    ]


@dataclass(slots=True)
class Transferred:
    """What a block transfer brought, put together from its segments and acknowledgements."""

    data: bytearray = field(default_factory=bytearray)
    sub_block: list[BlockSegment] = field(default_factory=list)
    sizes: set[int | None] = field(default_factory=set)
    with_crc: list[bool] = field(default_factory=list)
    ends: list[BlockEnd] = field(default_factory=list)

    def take(self, message: Request | Response) -> None:
        match message:
            case BlockSegment():
                self.sub_block.append(message)
            case BlockAck(sequence=sequence):
                good = [segment for segment in self.sub_block if segment.sequence <= sequence]
                assert [segment.sequence for segment in good] == list(range(1, sequence + 1))
                self.data += b"".join(segment.payload for segment in good)
                self.sub_block.clear()
            case BlockEnd(unused=unused):
                self.ends.append(message)
                del self.data[len(self.data) - unused :]
            case BlockDownloadInitiate() | BlockUploadInitiateResponse():
                self.sizes.add(message.size)
                self.with_crc.append(message.crc_supported)
            case BlockDownloadInitiateResponse() | BlockUploadInitiate():
                self.with_crc.append(message.crc_supported)


def last_transfer(vector: Vector) -> Transferred:
    found = Transferred()
    for message in read(vector):
        if isinstance(message, BlockDownloadInitiate | BlockUploadInitiate):
            found = Transferred()
        found.take(message)
    return found


@pytest.mark.parametrize("vector_id", VECTORS)
def test_every_frame_is_read_without_loss(vector_id: str) -> None:
    vector = VECTORS[vector_id]
    for step, message in zip(vector.steps, read(vector), strict=True):
        assert message.encode() == step.frame
        assert not isinstance(message, Unknown)


@pytest.mark.parametrize("vector_id", VECTORS)
def test_no_frame_has_reserved_bits_or_bytes(vector_id: str) -> None:
    for message in read(VECTORS[vector_id]):
        assert isinstance(message, Message)
        assert message.reserved_fields() == []


@pytest.mark.parametrize("vector_id", VECTORS)
def test_exchange_ends_as_it_should(vector_id: str) -> None:
    ended = any(isinstance(message, BlockEndResponse) for message in read(VECTORS[vector_id]))
    assert ended == (vector_id in DATA and vector_id != "V84")


@pytest.mark.parametrize("vector_id", DATA)
def test_data_size_and_crc(vector_id: str) -> None:
    transfer = last_transfer(VECTORS[vector_id])
    data = bytes(transfer.data)
    assert data == DATA[vector_id]
    assert transfer.sizes == ({None} if vector_id == "V86" else {len(data)})
    (end,) = transfer.ends
    assert all(transfer.with_crc) == (vector_id not in WITHOUT_CRC)
    due = crc16(data) if all(transfer.with_crc) else 0
    assert (end.crc == due) == (vector_id != "V84")


def test_v84_is_aborted_for_its_crc() -> None:
    assert VECTORS["V84"].irregularity == "crcbad"
    last = read(VECTORS["V84"])[-1]
    assert isinstance(last, Abort)
    assert last.code == 0x05040004
