"""Frames with an identifier of the channel that need not be the device's: whose they are.

Anybody may send 29-bit, remote or FD frames with the number of the channel. Such a frame is taken
for the device's only where it holds the answer to what was asked. An abort on the identifier of the
requests is the device's where it names what was asked and no other node answers that.
"""

from collections import Counter, deque
from collections.abc import Iterable, Sequence

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE, ChannelIds
from conformance.sdo.decoding import decode_request, decode_response, has_object, is_answer
from conformance.sdo.frames import Abort, Request
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer, whole_frame

_CODES = frozenset(AbortCode)
_NO_OBJECT = Multiplexer(0)
# An abort that comes now may be about one of this number of requests.
RECENT = 4


class Strangers:
    """Tells the frames of the device from those of other nodes; keeps one of each kind of these.

    ``confirmed``: the device is known to send its aborts on the identifier of the requests.
    """

    def __init__(self, ids: ChannelIds) -> None:
        """Nothing was asked yet."""
        self.confirmed = False
        self._ids = ids
        # The requests as they went out: they are read where somebody else is heard.
        self._asked: deque[CanFrame] = deque(maxlen=2)
        # For each of the latest, the one that named the object that it is about.
        self._naming: deque[CanFrame] = deque([CanFrame(ids.request.can_id)], maxlen=RECENT)
        self._counts: Counter[str] = Counter()
        self._first: dict[str, CanFrame] = {}

    def asked(self, frame: CanFrame) -> None:
        """Take what was sent to the device, in whatever format."""
        if frame.can_id == self._ids.request.can_id:
            self._asked.append(frame)
            self._naming.append(frame if has_object(frame.data) else self._naming[-1])

    def is_answer(self, frame: CanFrame) -> bool:
        """Say whether a frame of another format holds an answer to what was asked last."""
        if frame.remote or not frame.data or not self._asked:
            return False
        response = decode_response(whole_frame(frame.data))
        asked = self._asked[-1]
        if isinstance(response, Abort):
            return response.code in _CODES
        # What names no object could be anything, unless the request had the other format too.
        return is_answer(response, _request(asked)) and (
            has_object(asked.data) or not self._ids.request.matches(asked)
        )

    def is_abort(self, frame: CanFrame) -> bool:
        """Say whether a frame on the identifier of the requests may be the device's."""
        if not self._ids.request.matches(frame) or frame.dlc != FRAME_LENGTH:
            return False
        abort = decode_request(frame.data)
        return isinstance(abort, Abort) and abort.mux in (*map(_object, self._naming), _NO_OBJECT)

    def another_answers(self, abort: CanFrame, frame: CanFrame) -> bool:
        """Say whether a response answers the same request as an abort that came before it."""
        aborted = decode_request(abort.data)
        answered = getattr(decode_response(frame.data), "mux", _object(self._naming[-1]))
        if not isinstance(aborted, Abort) or aborted.mux != answered:
            return False
        # It may answer our own abort: the response is for what was asked behind that.
        before = _request(self._asked[0])
        return not (isinstance(before, Abort) and before.mux == aborted.mux)

    def note(self, frame: CanFrame) -> None:
        """Keep that another node sends such a frame."""
        kind = format_of(frame)
        self._first.setdefault(kind, frame)
        self._counts[kind] += 1

    def lines(self) -> list[str]:
        """Say, once for each format, what other nodes send."""
        return [
            f"another node sends {kind}s with the CAN-ID of the device's responses: "
            f"{self._first[kind]}" + (f" and {count - 1} more" if count > 1 else "")
            for kind, count in self._counts.items()
        ]


def _request(frame: CanFrame) -> Request:
    """Read what was asked, whatever the length of the frame."""
    return decode_request(whole_frame(frame.data))


def _object(frame: CanFrame) -> Multiplexer | None:
    """Return the multiplexer that a request names."""
    return getattr(_request(frame), "mux", None)


def format_of(frame: CanFrame) -> str:
    """Return the format of a frame in words.

    >>> format_of(CanFrame(0x585, extended=True, remote=True))
    '29-bit remote frame'
    """
    kind = "remote frame" if frame.remote else "CAN FD frame" if frame.fd else "frame"
    return f"{'29' if frame.extended else '11'}-bit {kind}"


def heard_elsewhere(overheard: Sequence[CanFrame], number: int) -> str:
    """Say what was heard instead of an answer on an identifier with a number."""
    alike = [frame for frame in overheard if frame.can_id == number]
    heard = [str(frame) for frame in overheard if frame.dlc == FRAME_LENGTH and frame not in alike]
    told = f"; received on other identifiers: {', '.join(heard[-3:])}" if heard else ""
    if alike:
        told += f"; received with that CAN-ID, but as {format_of(alike[-1])}: {alike[-1]}"
    return told


def asked_by_others(overheard: Iterable[CanFrame]) -> set[int]:
    """Return the node-IDs to which another client sent requests."""
    return {
        frame.can_id & 0x7F
        for frame in overheard
        if frame.can_id & ~0x7F == REQUEST_BASE and not (frame.extended or frame.remote)
    }
