"""Looks in the frames of a run for requests that were sent before the one in front was over."""

from collections.abc import Iterable, Iterator

from conformance.logs.reading import Seen
from conformance.sdo.cob_id import ChannelIds

# So many seconds behind a frame without an answer a device with room for one request has served it.
ROOM = 0.0015
ABORT = 0x80
# The bits that tell the answers of a block download apart, and what they are in those behind which
# a sub-block follows: to the initiate, and to a sub-block.
SPECIFIER, INITIATED, ACKNOWLEDGED = 0xE3, 0xA0, 0xA2


class OneAtATime:
    """Follows one channel: a request, its answer, the next request.

    The segments of a sub-block are one request: they follow one another without a pause.
    """

    def __init__(self, node_id: int) -> None:
        self._ids = ChannelIds.default(node_id)
        self._open: Seen | None = None
        self._in_sub_block = False

    def too_early(self, frames: Iterable[Seen]) -> Iterator[tuple[Seen, Seen]]:
        """Yield the requests that came too early, each behind the one that was not over."""
        for seen in frames:
            if self._ids.request.matches(seen.frame):
                before, self._open = self._open, seen
                if before is not None and self._comes_early(before, seen):
                    yield before, seen
                if self._is_abort(seen):
                    self._in_sub_block = False
            elif self._ids.response.matches(seen.frame) and seen.frame.data:
                self._follow(seen.frame.data)
                self._open = None

    def _comes_early(self, before: Seen, seen: Seen) -> bool:
        if self._in_sub_block and not self._is_abort(seen):
            return False
        return seen.time - before.time < ROOM

    def _is_abort(self, seen: Seen) -> bool:
        return seen.frame.data[:1] == bytes([ABORT])

    def _follow(self, answer: bytes) -> None:
        """Take an answer: a sub-block begins behind it, goes on, or is the last that was due."""
        kind = answer[0] & SPECIFIER
        if kind != ACKNOWLEDGED:
            self._in_sub_block = kind == INITIATED
        elif self._open is not None and self._open.frame.data[0] == ABORT | answer[1]:
            self._in_sub_block = False
