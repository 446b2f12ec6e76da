"""What downloads have brought to the objects that they are about, as far as a server may take it.

A download that is aborted may have written that much through, where an object is a string or a
domain. What did not come in sequence, or came behind an abort, is never a part of it.
"""

from collections import defaultdict
from collections.abc import Iterable
from itertools import chain

from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEndResponse,
    BlockSegment,
    DownloadInitiate,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
)
from conformance.sdo.layout import Multiplexer


class Delivered:
    """Follows requests and responses; keeps by object what came since a download was completed."""

    def __init__(self) -> None:
        """Nothing has been sent."""
        self._parts: dict[Multiplexer, list[bytearray]] = defaultdict(list)
        self._open: Multiplexer | None = None
        # What the download that is open has brought.
        self._part = bytearray()
        self._toggle = 0
        self._due = 1
        self._last = False

    def of(self, mux: Multiplexer) -> list[bytes]:
        """Return what each download of an object brought."""
        return [bytes(part) for part in self._parts[mux]]

    def forget(self, mux: Multiplexer) -> None:
        """Begin anew with what an object holds."""
        self._parts.pop(mux, None)

    def request(self, request: Request) -> None:
        """Take what the client sends."""
        match request:
            case BlockSegment():
                if request.sequence == self._due:
                    self._take(request.payload)
                    self._due += 1
            case DownloadInitiate(expedited=False) | BlockDownloadInitiate():
                self._open, self._toggle, self._due = request.mux, 0, 1
                self._last = False
                self._part = bytearray()
                self._parts[request.mux].append(self._part)
            case DownloadSegment(toggle=toggle) if toggle == self._toggle:
                self._take(request.payload)
                self._toggle ^= 1
                self._last = request.last
            case Abort():
                self._open = None

    def response(self, response: Response) -> None:
        """Take what the server sent."""
        match response:
            case BlockAck():
                self._due = 1
            case BlockEndResponse():
                self._complete()
            case DownloadSegmentResponse() if self._last:
                self._complete()
            case Abort():
                self._open = None

    def _take(self, data: bytes) -> None:
        if self._open is not None:
            self._part += data

    def _complete(self) -> None:
        if self._open is not None:
            self.forget(self._open)
        self._open = None


def is_written_through(found: bytes, before: bytes, parts: Iterable[bytes]) -> bool:
    """Say whether a value is one of which some bytes have been written, each at its place.

    The others are what they were, or 0.

    >>> is_written_through(b"newold", b"oldold", [b"newest"])
    True
    """
    sources = [before, *parts]
    return all(
        byte in chain((0,), (source[place] for source in sources if place < len(source)))
        for place, byte in enumerate(found)
    )
