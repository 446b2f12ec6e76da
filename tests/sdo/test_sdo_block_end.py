"""The end of a block upload that is wrong is told as what it is: n, the CRC, or what is missing."""

from collections.abc import Iterable

import pytest

from conformance.sdo.block_client import BlockClient
from conformance.sdo.checks import ResponseChecks
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    BlockEnd,
    BlockSegment,
    BlockUploadInitiateResponse,
    Response,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation
from conformance.sdo.rules.defects import WRONG_COUNT

MUX = Multiplexer(0x2010)
DATA = b"a value of 21 bytes, "


def breach(
    responses: Iterable[Response], *, size: int | None = None, block_size: int = 127
) -> Violation:
    """Return what an upload of DATA is ended for."""
    minor: list[Violation] = []  # bytes that n says are unused may be other than 0
    client = BlockClient(ResponseChecks(minor.append))
    transfer = client.block_upload(MUX, block_size=block_size)
    next(transfer)
    transfer.send(BlockUploadInitiateResponse.with_size(MUX, size, crc_supported=True))
    try:
        for response in responses:
            transfer.send(response)
    except Violation as found:
        return found
    raise AssertionError("all of it was right")


def segments(*, marked: bool = True) -> list[Response]:
    return [BlockSegment(n, DATA[7 * n - 7 : 7 * n], marked and n == 3) for n in (1, 2, 3)]


def test_a_count_that_the_crc_does_not_fit_is_wrong_itself() -> None:
    found = breach([*segments(), BlockEnd(7, crc16(DATA))])
    assert found.told_as == WRONG_COUNT
    assert found.expected == "n = 0: the CRC is that of 21 bytes"


@pytest.mark.parametrize("unused", [0, 3])
def test_a_crc_of_other_data_is_wrong(unused: int) -> None:
    found = breach([*segments(), BlockEnd(unused, crc16(b"other"))])
    assert (found.rule.id, found.told_as) == ("block.crc", None)
    assert found.expected == f"CRC {crc16(DATA[: 21 - unused]):04X}h"


def test_a_count_that_the_size_does_not_fit_is_told_by_the_size() -> None:
    assert breach([*segments(), BlockEnd(7, crc16(DATA))], size=21).rule.id == "upload.size"


def test_an_end_behind_a_sub_block_that_is_not_marked() -> None:
    """It is no segment 93, for which it could be taken by its first byte."""
    found = breach([*segments(marked=False), BlockEnd(7, crc16(DATA))], block_size=3)
    assert found.rule.id == "upload.ends"
    assert found.expected == "segment 3 to be marked as the last (80h), where no more follow"


def test_segments_out_of_order_are_told_as_such() -> None:
    rest = [BlockSegment(93, bytes(7))]
    assert breach([*segments(marked=False)[:2], *rest]).rule.id == "block.sequence"
    assert breach([*segments(marked=False), BlockSegment(3, bytes(7))], block_size=3).rule.id == (
        "block.sequence"
    )
