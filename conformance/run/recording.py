"""The frames of a case: all of them, or the first and the last of very many."""

from collections import deque
from copy import copy, deepcopy
from dataclasses import dataclass

from conformance.bus.link import Captured, Direction
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.describe import describe
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.line import Line

FIRST_KEPT = 1_000
LAST_KEPT = 10_000


@dataclass(frozen=True, slots=True)
class LeftOut:
    """Frames that were left out: behind how many, how many, how many of them we had sent.

    ``decoders`` have followed the conversation to the end of the gap.
    """

    at: int
    frames: int
    sent: int
    decoders: dict[ChannelIds, "ChannelDecoder"]


class ChannelDecoder:
    """Reads the frames of one SDO channel."""

    def __init__(self, ids: ChannelIds) -> None:
        """Start outside any transfer."""
        self._ids = ids
        self._line = Line()

    def read(self, frame: CanFrame) -> tuple[str, str] | None:
        """Return the name of the message in a frame, empty for a malformed one, and its words.

        None for a frame of another channel.
        """
        ids = self._ids
        for cob_id, decode in (
            (ids.request, self._line.request),
            (ids.response, self._line.response),
        ):
            if cob_id.matches(frame) and frame.dlc == FRAME_LENGTH:
                message = decode(frame.data)
                return type(message).__name__, describe(message)
            if cob_id.can_id == frame.can_id:
                bits = "a 29" if cob_id.extended else "an 11"
                shape = f"not a data frame of 8 bytes with {bits}-bit identifier"
                return "", f"DLC {frame.dlc}, {shape}"
        return None

    def words(self, frame: CanFrame) -> str:
        """Return the words of a frame; empty for a frame of another channel."""
        _, words = self.read(frame) or ("", "")
        return words

    def follow(self, frame: CanFrame) -> None:
        """Take a frame that is not shown."""
        for cob_id, decode in (
            (self._ids.request, self._line.request),
            (self._ids.response, self._line.response),
        ):
            if cob_id.matches(frame) and frame.dlc == FRAME_LENGTH:
                decode(frame.data)

    def fork(self) -> "ChannelDecoder":
        """Return another one that goes on from here."""
        other = copy(self)
        other._line = deepcopy(self._line)
        return other


class Recording:
    """Takes the frames of a case as they come, and keeps a bounded number of them."""

    def __init__(self, ids: ChannelIds) -> None:
        """Start empty. ``ids`` is the channel that is followed over what is left out."""
        self._ids = ids
        self.clear()

    def clear(self) -> None:
        """Forget everything: another case begins."""
        self._first: list[Captured] = []
        self._last: deque[Captured] = deque()
        self._left_out = 0
        self._left_out_sent = 0
        self._decoder = ChannelDecoder(self._ids)

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
                self._decoder.follow(earlier.frame)
        self._decoder.follow(captured.frame)
        self._left_out += 1
        self._left_out_sent += captured.direction is Direction.SENT

    def __len__(self) -> int:
        """How many frames came, left out or not."""
        return len(self._first) + self._left_out + len(self._last)

    def kept(self) -> list[Captured]:
        """Return the frames that are there."""
        return [*self._first, *self._last]

    def gap(self) -> LeftOut | None:
        """Return what was left out of them."""
        if not self._left_out:
            return None
        decoders = {self._ids: self._decoder.fork()}
        return LeftOut(len(self._first), self._left_out, self._left_out_sent, decoders)
