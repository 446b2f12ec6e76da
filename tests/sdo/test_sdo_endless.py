"""Transfers that a server does not let come to an end: the client ends them."""

from collections.abc import Generator, Iterable
from itertools import count, repeat

import pytest

from conformance.sdo.block_client import BlockClient, Step
from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiateResponse,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiateResponse,
    Response,
    UploadInitiateResponse,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation

MUX = Multiplexer(0x2010)
BLOCK = 16


def limited(longest: int) -> BlockClient:
    return BlockClient(longest=lambda mux: longest)


def ended(
    transfer: Generator[Step, Response, object], initiated: Response, rest: Iterable[Response]
) -> tuple[str, str, int]:
    """Return the rule by which a transfer is ended, what came, and behind how many responses."""
    next(transfer)
    transfer.send(initiated)
    for number, response in enumerate(rest, 1):
        try:
            transfer.send(response)
        except Violation as breach:
            return breach.rule.id, breach.actual, number
    raise AssertionError("it was not ended")


def segments(data: bytes) -> Iterable[Response]:
    return (UploadSegmentResponse.with_data(data, toggle=number % 2) for number in range(200_000))


@pytest.mark.parametrize(
    ("size", "rule", "behind"),
    [(None, "upload.ends", 144), (100, "upload.size", 16), (112, "upload.size", 32)],
)
def test_a_block_upload_ends_behind_what_is_due(size: int | None, rule: str, behind: int) -> None:
    transfer = limited(1000).block_upload(MUX, block_size=BLOCK)
    initiated = BlockUploadInitiateResponse.with_size(MUX, size, crc_supported=True)
    blocks = (BlockSegment(number % BLOCK + 1, bytes(7)) for number in count())
    found, _, after = ended(transfer, initiated, blocks)
    assert (found, after) == (rule, behind)


def test_an_upload_ends_behind_what_the_object_can_hold() -> None:
    initiated = UploadInitiateResponse.with_size(MUX, 0xFFFF_FFFF)
    found = ended(limited(1000).upload(MUX), initiated, segments(bytes(7)))
    assert found == ("upload.ends", "143 segments with 1001 bytes and none marked as last", 143)


def test_an_upload_of_a_byte_a_segment_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conformance.sdo.client.MOST_SEGMENTS", 20)
    initiated = UploadInitiateResponse.with_size(MUX, None)
    found = ended(BlockClient().upload(MUX), initiated, segments(b"a"))
    assert found == ("upload.ends", "21 segments with 21 bytes and none marked as last", 21)


def test_a_block_download_of_which_nothing_is_taken_ends() -> None:
    transfer = BlockClient().block_download(MUX, bytes(7000))
    initiated = BlockDownloadInitiateResponse(MUX, 127, crc_supported=True)
    rule, actual, after = ended(transfer, initiated, repeat(BlockAck(0, 127), 1000))
    assert (rule, after) == ("block.progress", 65)
    assert actual.startswith("65 times none")


def test_a_block_download_of_which_little_is_taken_goes_on() -> None:
    transfer = BlockClient().block_download(MUX, bytes(7000))
    next(transfer)
    transfer.send(BlockDownloadInitiateResponse(MUX, 127, crc_supported=True))
    for number in range(2000):
        transfer.send(BlockAck(number % 2, 127))
    with pytest.raises(StopIteration) as done:
        transfer.send(BlockEndResponse())
    assert done.value.value > 100_000, "segments that were sent again"
