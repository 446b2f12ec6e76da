"""When the bench itself was not running: what that may have brought about is not the device's.

A server may give up a transfer whose client is silent. The suite answers within a millisecond, but
a busy machine may keep it waiting: then the server is right, and the case says nothing about it.
"""

import time
from collections.abc import Callable

from conformance.device.not_testable import NotTestable
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import Abort, Response

# The part of its declared time after which a server may have given up, as its clock goes.
MAY_GIVE_UP = 0.75
# Without a declared time: no server is known to give up sooner, in seconds.
SHORTEST_TIMEOUT = 0.02
NOT_JUDGED = (
    "the bench itself was not running at times, as on a busy machine: what came of it is no fault "
    "of the device, and the case has to be run again"
)


class Pauses:
    """The silences of the bench within one case, in seconds of the monotonic clock.

    ``active_at`` is when the last frame went or came; ``longest`` is the longest time from there to
    the next one sent while a transfer was open, or for which a response waited to be taken.
    ``notes`` say what was met.
    """

    def __init__(
        self, server_timeout: float | None, now: Callable[[], float] | None = None
    ) -> None:
        """``server_timeout`` is when the device gives up a silent client, None if not declared."""
        self._now = now or time.monotonic
        self.active_at: float | None = None
        self.longest = 0.0
        self.notes: list[str] = []
        self._declared = server_timeout is not None
        self._limit = SHORTEST_TIMEOUT if server_timeout is None else server_timeout * MAY_GIVE_UP
        self._told = False
        self._given_up = False
        self._deaf = False

    def sent(self, *, within: bool) -> None:
        """Take that a frame has just been sent, ``within`` a transfer or not, after a silence."""
        now = self._now()
        if within and self.active_at is not None:
            silent = now - self.active_at
            self.longest = silent if silent > self.longest else self.longest
        self.active_at = now

    def waited(self) -> None:
        """Take that the silence up to now was meant: the server had to give up, go on or answer."""
        self.active_at = self._now()

    def received(self, data: bytes, arrived: float, *, within: bool) -> None:
        """Take a response, and when it arrived: since then it may have waited for the bench."""
        if within:
            waited = self._now() - arrived
            self.longest = waited if waited > self.longest else self.longest
        if self.longest >= self._limit and is_timeout(decode_response(data)):
            self._given_up = True
        self.active_at = arrived

    def missed(self, seconds: float) -> None:
        """Take that no answer came, and how many seconds of the wait for it were missed."""
        self._deaf = True
        self.notes.append(
            f"bench: it was not running for {seconds * 1000:.0f} ms while an answer was awaited"
        )

    def repeated(self, seconds: float) -> None:
        """Take that a read was repeated because part of the wait for its answer was missed."""
        self.notes.append(
            f"bench: it was not running for {seconds * 1000:.0f} ms while an answer was awaited; "
            "the read was repeated"
        )

    @property
    def in_doubt(self) -> bool:
        """Whether what was found so far may be due to the bench."""
        was_silent = self.longest >= self._limit and self._declared
        return was_silent or self._given_up or self._deaf

    @property
    def excuse(self) -> bool:
        """Whether what is wrong with the device from here on may be due to the bench."""
        was_silent = self.longest >= self._limit and self._declared
        if (was_silent or self._given_up) and not self._told:
            self._told = True
            self.notes.append(
                f"bench: it was silent for {self.longest * 1000:.0f} ms, in which a server may "
                "give up"
            )
        return self.in_doubt

    def excuses(self, response: Response) -> bool:
        """Whether an unsolicited response tells of a transfer that was given up."""
        return self.longest >= self._limit and is_timeout(response)

    def forget(self) -> None:
        """Begin anew: what was met so far has been dealt with."""
        self.longest = 0.0
        self._told = self._given_up = self._deaf = False

    def not_judged(self) -> NotTestable:
        """Describe a case that says nothing about the device."""
        return NotTestable(NOT_JUDGED)


def is_timeout(response: Response) -> bool:
    """Say whether a response tells that the client was silent for too long."""
    return isinstance(response, Abort) and response.code == AbortCode.TIMED_OUT
