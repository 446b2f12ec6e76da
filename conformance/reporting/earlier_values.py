"""What an object held when a case read it: the download that wrote it, which bus.log has before.

A case may read what another has left; at the end of the run the object was restored.
"""

from collections.abc import Sequence
from pathlib import Path

from conformance.device.safety import written_by
from conformance.reporting.logged import Logged, log_lines
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    DownloadInitiate,
    Request,
    Response,
    UploadInitiate,
)
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.line import Line

MOST_FRAMES = 20_000
# The number of the line with which a case begins, and its channel.
Begin = tuple[int, ChannelIds]
Downloads = dict[Multiplexer, list[Logged]]


def values_of_before(
    path: Path, cases: Sequence[tuple[Sequence[Logged], ChannelIds]]
) -> list[list[list[Logged]]]:
    """Return for each case the downloads that wrote what it reads and does not write.

    Those are left out after which the object was not restored: it has the value still. Raises
    OSError.
    """
    read = [_read_before_written(lines, ids) for lines, ids in cases]
    begins = [(lines[0].number, ids) for lines, ids in cases]
    wanted = [begin for begin, objects in zip(begins, read, strict=True) if objects]
    downloads = _earlier_downloads(path, wanted) if wanted else {}
    return [
        [downloads[begin][mux] for mux in objects if mux in downloads[begin]]
        for begin, objects in zip(begins, read, strict=True)
    ]


def _read_before_written(lines: Sequence[Logged], ids: ChannelIds) -> list[Multiplexer]:
    """Return the objects that a case reads before it may have written them itself."""
    channel = _Followed(ids)
    written: set[Multiplexer] = set()
    read: dict[Multiplexer, bool] = {}
    for logged in lines:
        channel.take(logged)
        request = channel.line.asked
        if isinstance(request, DownloadInitiate | BlockDownloadInitiate):
            written.add(request.mux)
        elif isinstance(request, UploadInitiate | BlockUploadInitiate):
            read.setdefault(request.mux, request.mux in written)
    return [mux for mux, is_own in read.items() if not is_own]


def _earlier_downloads(path: Path, wanted: Sequence[Begin]) -> dict[Begin, Downloads]:
    followed = {ids: _Followed(ids) for _, ids in wanted}
    waiting = sorted(set(wanted), key=lambda each: each[0], reverse=True)
    found: dict[Begin, Downloads] = {}
    for logged in log_lines(path):
        while waiting and waiting[-1][0] <= logged.number:
            each = waiting.pop()
            found[each] = dict(followed[each[1]].completed)
        for channel in followed.values():
            channel.take(logged)
    return {
        begin: {
            mux: frames
            for mux, frames in downloads.items()
            if _sent(frames) != _sent(followed[begin[1]].completed[mux])
        }
        for begin, downloads in found.items()
    }


def _sent(frames: Sequence[Logged]) -> list[str]:
    return [logged.frame for logged in frames if logged.sent]


class _Followed:
    """A channel: its ``line``, and the last download of each object that succeeded."""

    def __init__(self, ids: ChannelIds) -> None:
        self.completed: Downloads = {}
        self._request_id, self._response_id = ids.request.identifier, ids.response.identifier
        self.line = Line()
        self._open: list[Logged] | None = None

    def take(self, logged: Logged) -> None:
        """Take the next frame of the bus."""
        if logged.identifier not in (self._request_id, self._response_id):
            return
        data = logged.data
        if data is None or len(data) != FRAME_LENGTH:
            return
        if logged.identifier == self._request_id:
            self._request(logged, self.line.request(data))
        else:
            self._response(logged, self.line.response(data))

    def _request(self, logged: Logged, request: Request) -> None:
        if written_by(request) is not None:
            self._open = []
        elif isinstance(request, Abort | UploadInitiate | BlockUploadInitiate):
            self._open = None
        if self._open is not None:
            self._open.append(logged)

    def _response(self, logged: Logged, response: Response) -> None:
        if self._open is None:
            return
        self._open.append(logged)
        if isinstance(response, Abort) or len(self._open) > MOST_FRAMES:
            self._open = None
        elif self.line.completed is not None:
            self.completed[self.line.completed], self._open = self._open, None
