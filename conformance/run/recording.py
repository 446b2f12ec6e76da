"""The frames of a case: all of them, or the first and the last of very many."""

from collections import deque
from copy import copy
from dataclasses import dataclass

from conformance.bus.link import Captured, Direction
from conformance.sdo.describe import Decoder
from conformance.sdo.frames import Request, Response
from conformance.sdo.layout import FRAME_LENGTH

FIRST_KEPT = 1_000
LAST_KEPT = 10_000


@dataclass(frozen=True, slots=True)
class Gap:
    """Frames that were left out: behind how many, how many, how many of them we had sent.

    ``decoder`` has followed the conversation to the end of the gap.
    """

    at: int
    frames: int
    sent: int
    decoder: "ChannelDecoder"


class ChannelDecoder:
    """Reads captured frames as the messages of one SDO channel."""

    def __init__(self, request_id: int, response_id: int) -> None:
        """Start outside any transfer."""
        self._request_id = request_id
        self._response_id = response_id
        self._decoder = Decoder()

    def read(self, captured: Captured) -> Request | Response | None:
        """Return the message that a frame is; None for one that is none of this channel."""
        frame = captured.frame
        if frame.dlc != FRAME_LENGTH or frame.remote or frame.extended:
            return None
        if frame.can_id == self._request_id:
            return self._decoder.request(frame.data)
        if frame.can_id == self._response_id:
            return self._decoder.response(frame.data)
        return None

    def fork(self) -> "ChannelDecoder":
        """Return another one that goes on from here."""
        other = copy(self)
        other._decoder = copy(self._decoder)
        return other


class Recording:
    """Takes the frames of a case as they come, and keeps a bounded number of them."""

    def __init__(self, request_id: int, response_id: int) -> None:
        """Start empty."""
        self._ids = request_id, response_id
        self.clear()

    def clear(self) -> None:
        """Forget everything: another case begins."""
        self._first: list[Captured] = []
        self._last: deque[Captured] = deque()
        self._left_out = 0
        self._left_out_sent = 0
        self._decoder = ChannelDecoder(*self._ids)

    def add(self, captured: Captured) -> None:
        """Take a frame; leave the oldest out behind the first ones when there are too many."""
        if len(self._first) < FIRST_KEPT:
            self._first.append(captured)
            return
        self._last.append(captured)
        if len(self._last) > LAST_KEPT:
            self._leave_out(self._last.popleft())

    def _leave_out(self, captured: Captured) -> None:
        if not self._left_out:
            for earlier in self._first:
                self._decoder.read(earlier)
        self._decoder.read(captured)
        self._left_out += 1
        self._left_out_sent += captured.direction is Direction.SENT

    def __len__(self) -> int:
        """How many frames came, left out or not."""
        return len(self._first) + self._left_out + len(self._last)

    def kept(self) -> list[Captured]:
        """Return the frames that are there."""
        return [*self._first, *self._last]

    def gap(self) -> Gap | None:
        """Return what was left out of them."""
        if not self._left_out:
            return None
        return Gap(len(self._first), self._left_out, self._left_out_sent, self._decoder.fork())
