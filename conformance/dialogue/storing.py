"""Ways to write a value, of which a device may refuse one and take another."""

from collections.abc import Generator

from conformance.dialogue.causes import Way
from conformance.sdo.block_client import BlockClient, Step
from conformance.sdo.frames import Response
from conformance.sdo.layout import Multiplexer

Transfer = Generator[Step, Response, object]


def in_segments(client: BlockClient, mux: Multiplexer, data: bytes) -> Transfer:
    """Write in segments, with the size indicated."""
    return client.download(mux, data, segmented=True)


def in_unsized_segments(client: BlockClient, mux: Multiplexer, data: bytes) -> Transfer:
    """Write in segments without a word on their size."""
    return client.download(mux, data, segmented=True, sized=False)


def in_blocks(client: BlockClient, mux: Multiplexer, data: bytes) -> Transfer:
    """Write in blocks."""
    return client.block_download(mux, data)


WAYS: tuple[Way, ...] = (in_segments, in_unsized_segments, in_blocks)
