"""Nodes that do something at a time of their own choice."""

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.node import Node


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
