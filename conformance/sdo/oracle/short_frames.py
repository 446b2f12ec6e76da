"""Requests of a wrong length: what a tolerant server may read in them (not defined by CiA 301)."""

from collections.abc import Callable
from dataclasses import replace

from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadSegment,
    Request,
    UploadInitiate,
)
from conformance.sdo.layout import FRAME_LENGTH, whole_frame
from conformance.sdo.oracle.knowledge import Memory

WITH_MULTIPLEXER = 4


def completed(decode: Callable[[bytes], Request], frame: bytes, memory: Memory) -> Request | None:
    """Return the request that a frame is if it holds all the bytes that matter; None if not."""
    if not frame:
        return None
    count = len(frame)
    request = decode(whole_frame(frame))
    if isinstance(request, DownloadSegment):
        return replace(request, unused=max(request.unused, FRAME_LENGTH - count, 0))
    return request if count >= _needed(request, memory) else None


def _needed(request: Request, memory: Memory) -> int:
    match request:
        case DownloadInitiate(expedited=True):
            length = len(request.data)
            if not request.sized:
                length = memory.facts(request.mux).length or length
            return WITH_MULTIPLEXER + length
        case DownloadInitiate(sized=True) | BlockDownloadInitiate(sized=True):
            return FRAME_LENGTH
        case DownloadInitiate() | UploadInitiate() | BlockDownloadInitiate():
            return WITH_MULTIPLEXER
        case BlockUploadInitiate():
            return WITH_MULTIPLEXER + 1
        case BlockAck() | BlockEnd():
            return 3
        case BlockSegment():
            # How many bytes of the last segment count is not known yet.
            return 1 if request.last else FRAME_LENGTH
        case _:
            return 1
