"""What goes over the bus before the first case, shown where the device dies or boots there."""

from collections import deque

from conformance.beginning.revival import Revival
from conformance.beginning.survey import FIRST_SEEN
from conformance.bus.channel import Channel
from conformance.bus.errors import DeviceLost
from conformance.bus.link import Captured, Direction
from conformance.dialogue.cause_of import cause_of
from conformance.dialogue.causes import Causes
from conformance.run.evidence import line_text
from conformance.run.trace import trace_of
from conformance.sdo.decoding import decode_request
from conformance.sdo.describe import describe
from conformance.sdo.layout import whole_frame
from conformance.sdo.nmt import NmtState, error_control
from conformance.sdo.rules import NO_REBOOT, Violation
from conformance.sdo.seen import Said

MOST_SHOWN = 12


class Watch:
    """Looks at what goes to a device and comes from it, until it is closed."""

    def __init__(self, channel: Channel, revival: Revival | None = None) -> None:
        """What ``revival`` brings back may boot."""
        self._channel = channel
        self._revival = revival
        self._boot_up = error_control(channel.node_id, NmtState.INITIALISING)
        self._last: deque[Captured] = deque(maxlen=MOST_SHOWN)
        self._asked: Captured | None = None
        self._answered = False
        self._booted: list[Violation] = []
        channel.link.listen(self._take)

    def close(self) -> None:
        """Look no more."""
        self._channel.link.ignore(self._take)

    def _take(self, captured: Captured) -> None:
        frame = captured.frame
        own = (self._channel.request_id, self._channel.response_id, self._boot_up.can_id)
        if frame.can_id not in own:
            return
        self._last.append(captured)
        if captured.direction is Direction.SENT:
            self._asked = captured
        brought_back = self._revival is not None and self._revival.is_active
        booted = frame == self._boot_up and self._answered and not brought_back
        if booted and self._asked is not None and len(self._booted) < MOST_SHOWN:
            self._booted.append(self._boot(self._asked))
        self._answered |= frame.can_id == self._channel.response_id

    def _boot(self, asked: Captured) -> Violation:
        request = decode_request(whole_frame(asked.frame.data))
        last = ", ".join(str(each.frame) for each in self._last)
        return Violation(
            NO_REBOOT,
            expected="no boot-up message",
            actual=Said(
                "the device booted",
                remark=f"; behind {describe(request)}; the last frames: {last}",
            ),
            asked=request,
        )

    def keep(self, causes: Causes) -> None:
        """Add that the device has booted to the causes: no case has failed for it."""
        for booted in self._booted:
            if booted.asked is not None:
                cause = cause_of(booted, booted.rule, booted.asked)
                causes.add(cause, FIRST_SEEN, booted, aside=True)

    def lost(self, error: DeviceLost) -> DeviceLost:
        """Return the loss of the device with the frames that went before."""
        trace = trace_of(
            list(self._last),
            [self._channel.ids],
            own=len(self._last),
            gap=None,
            aside=False,
            decisive=False,
        )
        shown = [f"  {line_text(line)}" for line in trace.lines]
        title = "  the last frames (> sent, < received):"
        return DeviceLost("\n".join([str(error), title, *shown]))
