"""Nodes that do something at a time of their own choice."""

from collections import deque

from conformance.reference.node import Node
from conformance.reference.segmented_server import SegmentedServer
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.nmt import NMT_ID


class OwnClock(Node):
    """Gives up, or does something else, at a time of its own choice."""

    own_due: float | None = None

    @property
    def wake_at(self) -> float | None:
        """Also look at the own time."""
        due = [time for time in (super().wake_at, self.own_due) if time is not None]
        return min(due, default=None)

    def advance(self, now: float) -> list[CanFrame]:
        """Do it when its time has come."""
        frames = super().advance(now)
        if self.own_due is not None and now >= self.own_due:
            self.own_due = None
            frames += [self.respond(data) for data in self.when_due()]
        return frames

    def when_due(self) -> list[bytes]:
        """Give up."""
        return self.server.expire()


class AnswersLater(Node):
    """Takes ``delay`` seconds for each answer."""

    delay = 0.0

    def __init__(
        self, node_id: int, *servers: SegmentedServer, server_timeout: float | None = None
    ) -> None:
        super().__init__(node_id, *servers, server_timeout=server_timeout)
        self.held: deque[tuple[float, CanFrame]] = deque()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Hold back what answers a request."""
        frames = super().receive(frame)
        if frame.can_id == NMT_ID:
            return frames
        self.hold(frames)
        return []

    def hold(self, frames: list[CanFrame]) -> None:
        """Keep the answers to a request until they are due."""
        self.held.extend((self.now + self.delay, answer) for answer in frames)

    @property
    def wake_at(self) -> float | None:
        """Also look at the answers."""
        times = (super().wake_at, self.held[0][0] if self.held else None)
        due = [time for time in times if time is not None]
        return min(due, default=None)

    def advance(self, now: float) -> list[CanFrame]:
        """Answer what is due."""
        frames = super().advance(now)
        while self.held and self.held[0][0] <= now:
            frames.append(self.held.popleft()[1])
        return frames


class OneByOne(Node):
    """Deals with one frame after the other, each of which takes ``seconds_for`` it.

    What comes meanwhile waits. Where an answer has several frames, each takes as long.
    """

    def __init__(
        self, node_id: int, *servers: SegmentedServer, server_timeout: float | None = None
    ) -> None:
        super().__init__(node_id, *servers, server_timeout=server_timeout)
        self.waiting: deque[CanFrame] = deque()
        self.leaving: deque[tuple[float, CanFrame]] = deque()
        self.busy_until: float | None = None

    def seconds_for(self, frame: CanFrame) -> float:
        """Return how long a frame takes that comes next."""
        del frame
        return 0.0

    def loses(self, frame: CanFrame) -> bool:
        """Say whether there is no room for a frame."""
        del frame
        return False

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Let a frame wait for its turn."""
        if not self.loses(frame):
            self.waiting.append(frame)
            self._take_next(self.now)
        return self.advance(self.now)

    def _take_next(self, now: float) -> None:
        if self.busy_until is None and self.waiting:
            self.busy_until = now + self.seconds_for(self.waiting[0])

    @property
    def wake_at(self) -> float | None:
        """Also look at the frame that it is dealing with, and at those that leave."""
        leaves = self.leaving[0][0] if self.leaving else None
        due = [time for time in (super().wake_at, self.busy_until, leaves) if time is not None]
        return min(due, default=None)

    def advance(self, now: float) -> list[CanFrame]:
        """Be done with what is due."""
        while self.busy_until is not None and self.busy_until <= now:
            done, frame = self.busy_until, self.waiting.popleft()
            each = self.seconds_for(frame)
            answers = [*super().advance(done), *super().receive(frame)]
            self.leaving.extend((done + number * each, one) for number, one in enumerate(answers))
            self.busy_until = None
            self._take_next(self.leaving[-1][0] if len(answers) > 1 else done)
        frames = super().advance(now)
        while self.leaving and self.leaving[0][0] <= now:
            frames.append(self.leaving.popleft()[1])
        return frames
