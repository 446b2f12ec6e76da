"""Hypothesis strategies: every message of both directions, with all that its fields can hold."""

from collections.abc import Callable

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

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
    BlockUploadStart,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Message, Multiplexer

# A busy machine is no failure.
UNHURRIED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])

Strategies = dict[type[Message], SearchStrategy[Message]]

FRAMES = st.binary(min_size=8, max_size=8)
OTHER_LENGTHS = st.one_of(st.binary(max_size=7), st.binary(min_size=9, max_size=64))


def bits(count: int) -> SearchStrategy[int]:
    return st.integers(0, 2**count - 1)


def raw(length: int) -> SearchStrategy[bytes]:
    return st.binary(min_size=length, max_size=length)


FLAG = st.booleans()
MUX = st.builds(Multiplexer, bits(16), bits(8))
ABORT = st.builds(Abort, MUX, bits(32), bits(5))
ACK = st.builds(BlockAck, bits(8), bits(8), bits(3), raw(5))
END = st.builds(BlockEnd, bits(3), bits(16), bits(1), raw(5))
END_RESPONSE = st.builds(BlockEndResponse, bits(3), raw(7))


def initiate(kind: Callable[..., Message]) -> SearchStrategy[Message]:
    return st.builds(kind, MUX, FLAG, FLAG, bits(2), raw(4), bits(1))


def segment(kind: Callable[..., Message]) -> SearchStrategy[Message]:
    return st.builds(kind, raw(7), bits(1), bits(3), FLAG)


def block_initiate(kind: Callable[..., Message]) -> SearchStrategy[Message]:
    return st.builds(kind, MUX, FLAG, FLAG, raw(4), bits(2))


REQUESTS: Strategies = {
    DownloadInitiate: initiate(DownloadInitiate),
    DownloadSegment: segment(DownloadSegment),
    UploadInitiate: st.builds(UploadInitiate, MUX, bits(5), raw(4)),
    UploadSegment: st.builds(UploadSegment, bits(1), bits(4), raw(7)),
    Abort: ABORT,
    BlockDownloadInitiate: block_initiate(BlockDownloadInitiate),
    BlockEnd: END,
    BlockUploadInitiate: st.builds(
        BlockUploadInitiate, MUX, bits(8), bits(8), FLAG, bits(2), raw(2)
    ),
    BlockUploadStart: st.builds(BlockUploadStart, bits(3), raw(7)),
    BlockAck: ACK,
    BlockEndResponse: END_RESPONSE,
}
RESPONSES: Strategies = {
    DownloadInitiateResponse: st.builds(DownloadInitiateResponse, MUX, bits(5), raw(4)),
    DownloadSegmentResponse: st.builds(DownloadSegmentResponse, bits(1), bits(4), raw(7)),
    UploadInitiateResponse: initiate(UploadInitiateResponse),
    UploadSegmentResponse: segment(UploadSegmentResponse),
    Abort: ABORT,
    BlockDownloadInitiateResponse: st.builds(
        BlockDownloadInitiateResponse, MUX, bits(8), FLAG, bits(2), raw(3)
    ),
    BlockAck: ACK,
    BlockEndResponse: END_RESPONSE,
    BlockUploadInitiateResponse: block_initiate(BlockUploadInitiateResponse),
    BlockEnd: END,
}
# Sequence number 0 marked as last would be 80h, which is an abort; an abort has no bits to spare.
SEGMENTS: Strategies = {
    BlockSegment: st.builds(BlockSegment, bits(7), raw(7), FLAG).filter(
        lambda segment: segment.sequence > 0 or not segment.last
    ),
    Abort: st.builds(Abort, MUX, bits(32)),
}
