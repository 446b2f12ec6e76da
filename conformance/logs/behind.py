"""A server that answers each request when the next frame of the client comes.

An answer may come late, also behind the next request. But answers that always come right behind the
next frame, whether the client waits for a moment or a second with that, wait for the client.
"""

from collections.abc import Sequence

from conformance.logs.reading import Seen
from conformance.sdo.decoding import decode_request, decode_response, is_answer
from conformance.sdo.frames import Abort, Request, Response
from conformance.sdo.rules import ANSWERED, Violation

# Seconds within which such an answer follows the frame that it waited for.
PROMPT = 0.02
# So many in a row say what is wrong, where one is not allowed.
FEW = 3
# So many show that, where some have waited for so many seconds, and another for less than half as
# long: answers that take a time of their own do not.
ENOUGH = 6
LONG = 0.5
LONG_ONES = 2


class Behind:
    """Follows one channel: its latest two requests, and how long their answers have waited."""

    __slots__ = ("_before", "_last", "_waits", "is_certain")

    def __init__(self) -> None:
        """Begin with nothing asked."""
        self._before: Seen | None = None
        self._last: Seen | None = None
        self._waits: list[float] = []
        self.is_certain = False

    def clear(self) -> None:
        """Forget all."""
        self._before = self._last = None
        self._waits.clear()
        self.is_certain = False

    def asked(self, seen: Seen) -> None:
        """Take a request, or an abort of the client."""
        self._before, self._last = self._last, seen

    def answered(self, seen: Seen) -> None:
        """Take a response."""
        before, last = self._before, self._last
        if before is None or last is None:
            self.clear()
            return
        response = decode_response(seen.frame.data)
        if not _answers(response, before):
            self.clear()
            return
        self._before = None
        if _answers(response, last):
            return  # the same was asked twice
        if seen.time - last.time > PROMPT:
            self._waits.clear()
        else:
            self._waits.append(seen.time - before.time)

    def found(self, *, blamed: bool) -> Violation | None:
        """Return the breach behind a response, once; ``blamed``: that is not allowed anyway."""
        shows = _shows(self._waits) or (blamed and len(self._waits) >= FEW)
        return self._breach() if shows and not self.is_certain else None

    def at_the_end(self, now: float) -> Violation | None:
        """Return the breach where the latest request still waits for its answer, once."""
        last, waits = self._last, self._waits
        if last is None or len(waits) < ENOUGH or isinstance(_request(last), Abort):
            return None
        shows = now - last.time >= max(LONG, 2 * min(waits))
        return self._breach() if shows and not self.is_certain else None

    def _breach(self) -> Violation:
        self.is_certain = True
        return Violation(
            ANSWERED,
            expected="an answer before the next request",
            actual="answers are one request behind",
        )


def _shows(waits: Sequence[float]) -> bool:
    shortest, *others = sorted(waits) or [0.0]
    return len(waits) >= ENOUGH and others[-LONG_ONES] >= max(LONG, 2 * shortest)


def _request(seen: Seen) -> Request:
    return decode_request(seen.frame.data)


def _answers(response: Response, asked: Seen) -> bool:
    """Say whether a response may be the answer to a request, by its multiplexer."""
    request = _request(asked)
    if isinstance(request, Abort):
        return False
    refuses = isinstance(response, Abort) and response.mux == getattr(request, "mux", None)
    return refuses or is_answer(response, request)
