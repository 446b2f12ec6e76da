"""How long to wait for an answer of this device: by its pace, and by what it is busy with."""

from conformance.bus.channel import Channel
from conformance.bus.deadline import Deadline
from conformance.dialogue.timing import Timing

# In seconds, how long a frame takes at least where many come that nobody has asked for.
FRAME_TIME = 0.002
# How many seconds longer an answer is awaited at the most where other frames come first.
MOST_SURPLUS = 5.0


class Waits:
    """The waits for answers on one channel."""

    def __init__(self, channel: Channel, timing: Timing) -> None:
        """Take the pace of the channel's device, and what it may be busy with."""
        self._channel = channel
        self._timing = timing

    @property
    def patience(self) -> float:
        """How many seconds to wait for an answer that has to come."""
        return self._channel.pace.patience(self._channel.response_timeout, self._timing.due)

    @property
    def soon(self) -> float:
        """How many seconds to wait for what comes as soon as this device answers, if it does."""
        return self._channel.pace.soon(self._channel.response_timeout, self._timing.due)

    @property
    def look(self) -> float:
        """How many seconds to look for what comes so soon, where it may come later as well."""
        return self._channel.pace.look(self._channel.response_timeout, self._timing.due)

    def deadline(self, frames: int) -> Deadline:
        """Return when an answer has to be there, though so many other ``frames`` came before it."""
        each = max(self._channel.pace.nearly_all, FRAME_TIME)
        return self._channel.link.deadline(self.patience + min(frames * each, MOST_SURPLUS))

    def unanswered(self) -> None:
        """Take that an answer which had to come did not."""
        if not self._channel.in_doubt:
            self._channel.pace.unanswered()
