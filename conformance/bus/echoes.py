"""Which of the frames that come from a bus are those that we sent."""

from collections import deque

from conformance.sdo.can_frame import CanFrame

MOST_AWAITED = 1000


class UnmarkedEchoes:
    """Knows our own frames again where a bus brings back each of them once, like any other.

    They come in the order in which they were sent; some may have been lost. An equal frame of
    another node may be taken for ours: then ours, behind it, is taken for the other's, and is
    noticed.
    """

    def __init__(self) -> None:
        """Await nothing."""
        self._awaited: deque[str] = deque(maxlen=MOST_AWAITED)

    def sent(self, frame: CanFrame) -> None:
        """Await the echo of a frame."""
        self._awaited.append(str(frame))

    def is_echo(self, frame: CanFrame) -> bool:
        """Say whether a frame that came is one that we sent; then it is awaited no more."""
        written = str(frame)
        if written not in self._awaited:
            return False
        while self._awaited.popleft() != written:
            pass
        return True
