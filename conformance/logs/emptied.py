"""Strings that a server empties when a download begins that the client aborts at once."""

from conformance.sdo.decoding import decode_request, decode_response, is_abort
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer

# An empty string may read as the 00h that ends it.
MOST_OF_AN_EMPTY_ONE = 1


class Emptied:
    """Follows one channel: ordinary uploads, and downloads that have not brought a segment.

    ``_filled`` are the objects that were read with more than an empty string has, and ``_doubtful``
    those of them of which a download was begun since, and aborted before its first segment. Of the
    transfer that runs, ``_read`` or ``_written`` is the object; ``_size`` counts what was read.
    """

    __slots__ = ("_confirmed", "_doubtful", "_filled", "_read", "_size", "_written")

    def __init__(self) -> None:
        """Nothing was read yet."""
        self._filled: set[Multiplexer] = set()
        self._doubtful: set[Multiplexer] = set()
        self._begin()

    def _begin(
        self, *, read: Multiplexer | None = None, written: Multiplexer | None = None
    ) -> None:
        self._read, self._written = read, written
        self._size, self._confirmed = 0, False

    def clear(self) -> None:
        """Forget all: it may be another device."""
        self._filled.clear()
        self._doubtful.clear()
        self._begin()

    def asked(self, frame: bytes, *, in_sub_block: bool) -> None:
        """Take a request."""
        if in_sub_block and not is_abort(frame):
            return
        match decode_request(frame):
            case UploadInitiate(mux=mux):
                self._begin(read=mux)
            case DownloadInitiate(mux=mux, expedited=False):
                self._begin(written=mux)
            case DownloadInitiate(mux=mux) | BlockDownloadInitiate(mux=mux):
                self._begin()
                self._forget(mux)
            case BlockUploadInitiate():
                self._begin()
            case DownloadSegment() if self._written is not None:
                self._forget(self._written)
                self._begin()
            case Abort():
                if self._confirmed and self._written in self._filled:
                    self._doubtful.add(self._written)
                self._begin()

    def answered(self, frame: bytes) -> str | None:
        """Take a response; return in words which object is empty now, None for none."""
        if self._read is None and self._written is None:
            return None
        match decode_response(frame):
            case DownloadInitiateResponse(mux=mux) if mux == self._written:
                self._confirmed = True
            case UploadInitiateResponse(mux=mux) as response if mux == self._read:
                if response.expedited:
                    return self._ended(mux, len(response.data))
            case UploadSegmentResponse() as response if self._read is not None:
                self._size += len(response.data)
                if response.last:
                    return self._ended(self._read, self._size)
            case _:
                self._begin()
        return None

    def _ended(self, mux: Multiplexer, size: int) -> str | None:
        self._begin()
        was_doubtful = mux in self._doubtful
        self._forget(mux)
        if size > MOST_OF_AN_EMPTY_ONE:
            self._filled.add(mux)
        elif was_doubtful:
            return (
                f"{mux} was not empty before a download to it, which the client has aborted before "
                "its first segment, and is empty now"
            )
        return None

    def _forget(self, mux: Multiplexer) -> None:
        self._filled.discard(mux)
        self._doubtful.discard(mux)
