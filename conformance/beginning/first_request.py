"""The first request behind a boot-up message: a device that has just started answers it."""

from collections.abc import Callable

from conformance.beginning.plain_reads import end_read
from conformance.beginning.revival import Revival
from conformance.beginning.survey import FIRST_SEEN
from conformance.bus.channel import Channel
from conformance.device.device import DEVICE_TYPE
from conformance.dialogue.causes import Causes
from conformance.sdo.decoding import decode_response
from conformance.sdo.describe import describe
from conformance.sdo.frames import Abort, UploadInitiate, UploadInitiateResponse
from conformance.sdo.rules import FIRST_REQUEST, Cause, Violation
from conformance.sdo.seen import NoAnswer, Received, Seen

# Seconds within which further responses to it come.
REST = 0.05


def ask_first(channel: Channel) -> Violation | None:
    """Read 1000h of a device that has just booted; return what was wrong with its answer, if any.

    Where it does not answer another read either, that is for others to say.
    """
    request = UploadInitiate(DEVICE_TYPE)
    channel.send(request)
    frame = channel.receive()
    if frame is None:
        wrong: Seen = NoAnswer(f"nothing within {channel.response_timeout * 1000:g} ms")
    else:
        response = decode_response(frame.data)
        serves = isinstance(response, UploadInitiateResponse | Abort)
        if serves and getattr(response, "mux", None) == DEVICE_TYPE:
            end_read(channel, frame, DEVICE_TYPE)
            return None
        wrong = Received(response)
    channel.until_quiet(REST)
    channel.send(request)
    if channel.receive() is None:
        return None
    expected = f"an answer to the first request: {describe(request)}"
    return Violation(FIRST_REQUEST, expected=expected, actual=wrong, asked=request)


class FirstRequest:
    """What came of the first request to a device that was started; once more where it was lost."""

    def __init__(self, channel: Channel, revival: Revival) -> None:
        """Ask it."""
        self._found = ask_first(channel) if revival.has_booted else None
        self._again = self._found
        if self._found is not None and channel.link.may_lose and not revival.attempt():
            self._again = ask_first(channel) if revival.has_booted else self._found

    def keep(self, causes: Causes, doubt: Callable[[str, str], None]) -> None:
        """Add what was wrong to the causes, or to the doubts: no case has failed for it."""
        if self._found is None:
            return
        cause = Cause(FIRST_REQUEST.id, *self._found.seen.kind)
        if self._again is None:
            doubt("before the first case", str(cause))
        else:
            causes.add(cause, FIRST_SEEN, self._found, aside=True)
