"""An SDO channel to one device: its requests go out, its responses come in, the rest is watched."""

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from conformance.bus.deadline import Deadline
from conformance.bus.link import Link, second_client
from conformance.bus.pace import Pace
from conformance.bus.patience import Patience
from conformance.bus.strangers import Strangers
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.decoding import is_abort
from conformance.sdo.emergency import tells_of_error
from conformance.sdo.frames import Abort, Unknown
from conformance.sdo.layout import Message, Multiplexer
from conformance.sdo.nmt import EMERGENCY_BASE, NmtMessage, NmtState, error_control

MOST_OVERHEARD = 1000
# Frames with the times at which they arrived.
Waiting = deque[tuple[CanFrame, float]]
# Seconds for which a device may go on to talk before it is no longer waited for that it ends.
MOST_TALK = 2.0
# How many times at most a silence in doubt is waited out again.
MOST_WAITS = 5


class Channel:
    """A pair of COB-IDs of one device on a link; by default 600h and 580h plus node-ID.

    Responses are all frames with the response identifier, well-formed or not, and what else is the
    device's by what it holds. They wait for this channel in the order in which they came, also
    while another channel of the link receives. What else comes from the bus is kept in
    ``overheard``, and told by ``strangers`` where it might be mistaken; ``boot_ups`` counts the
    boot-up messages of the device, and ``emergency`` is the latest one since the last of them that
    tells of an error. ``pace`` is how fast the device answers there. It is ``at_rest``
    when the last frame on it was a response, and no abort. It ``is_calm`` when nothing but what was
    due came before the answer to what was sent last.

    A device may have room for one request: behind a frame without an answer there is a pause in
    which it may be served.
    """

    def __init__(
        self,
        link: Link,
        node_id: int,
        response_timeout: float,
        ids: ChannelIds | None = None,
        pace: Pace | None = None,
    ) -> None:
        """``response_timeout`` is the time in seconds within which a response has to come.

        ``pace`` is that of another channel of the device.
        """
        self.link = link
        self.node_id = node_id
        self.response_timeout = response_timeout
        self.pace = Pace(pace)
        self.at_rest = self.is_calm = False
        self.ids = ids or ChannelIds.default(node_id)
        self.request_id = self.ids.request.can_id
        self.response_id = self.ids.response.can_id
        self.overheard: deque[CanFrame] = deque(maxlen=MOST_OVERHEARD)
        self.boot_ups = 0
        self.emergency: CanFrame | None = None
        # How many seconds the device needs behind an abort of the client, and when it has had them.
        self.rest_behind_abort = 0.0
        self._rests_until: Deadline | None = None
        self._boot_up = error_control(node_id, NmtState.INITIALISING)
        self._emergency_id = EMERGENCY_BASE + node_id
        # When the response that was received last arrived, by the clock of the link, in seconds.
        self.arrived = 0.0
        # When the frame that was sent last left, behind the pauses that the device was given.
        self.sent_at = 0.0
        self.waited_since = 0.0
        # Of the last wait: the seconds of it that this process was not running, whether the silence
        # may be due to that, and whether one was waited out again for it.
        self.missed = 0.0
        self.in_doubt = False
        self.waited_again = False
        self.strangers = Strangers(self.ids)
        # Until when the frame that was sent last may take up the room for a request.
        self._served_at = 0.0
        self._pauses = True
        self._responses: Waiting = deque()
        # Aborts on the identifier of the requests of which it is open whose they are.
        self._held: Waiting = deque()
        self._error_control: Waiting = deque(maxlen=MOST_OVERHEARD)
        link.add_receiver(self._take)

    @property
    def is_default(self) -> bool:
        """Whether this is the default channel of the device, which is always there."""
        return self.ids == ChannelIds.default(self.node_id)

    def close(self) -> None:
        """Take no more frames from the link."""
        self.link.remove_receiver(self._take)

    def send(self, request: Message | Unknown | bytes, *, in_burst: bool = False) -> None:
        """Send a request: a message, or data bytes as they are.

        ``in_burst``: it is a segment behind another one of a sub-block, which leaves no pause.
        """
        data = request if isinstance(request, bytes) else request.encode()
        self._send(self.ids.request.frame(data), in_burst=in_burst)

    def send_frame(self, frame: CanFrame) -> None:
        """Send any frame."""
        self._send(frame)

    def _send(self, frame: CanFrame, *, in_burst: bool = False) -> None:
        if self._served_at and self._pauses and not in_burst:
            self._leave_room()
        self.at_rest = self.is_calm = False
        self._rest()
        self.strangers.asked(frame)
        self.sent_at = self.link.now()
        self._served_at = self.sent_at + self.pace.room(self.response_timeout)
        self.link.send(frame)
        if self.rest_behind_abort and is_abort(frame.data):
            self._rests_until = self.link.deadline(self.rest_behind_abort)

    def _rest(self) -> None:
        """Leave the device the time that it is known to need; what comes waits to be received."""
        until, self._rests_until = self._rests_until, None
        while until is not None and not until.has_passed:
            frame = self.link.receive(until.left)
            if frame is not None:
                self._check_own(frame)

    @contextmanager
    def without_rest(self) -> Iterator[None]:
        """Send each frame at once within this, whatever the device needs."""
        rest, self.rest_behind_abort = self.rest_behind_abort, 0.0
        try:
            yield
        finally:
            self.rest_behind_abort = rest

    @contextmanager
    def without_pause(self) -> Iterator[None]:
        """Send requests right behind one another, where that is the point."""
        self._pauses = False
        try:
            yield
        finally:
            self._pauses = True

    def _leave_room(self) -> None:
        """Wait until what was sent last is answered, or may be served without an answer."""
        left = self._served_at - self.link.now()
        patience = self.link.patience(max(left, 0.0), plain=True)
        while self._served_at and left > 0 and (frame := self.link.receive_with(patience)):
            if self._served_at:
                self._check_own(frame)
                patience.looked(silent=False)

    def send_nmt(self, message: NmtMessage) -> None:
        """Send an NMT command; error control frames that came before it are forgotten."""
        self._error_control.clear()
        self.is_calm = False
        self.link.send(message.frame())

    def abort(self, mux: Multiplexer, code: int) -> None:
        """End a transfer from the client's side."""
        self.send(Abort(mux, code))

    def receive(self, timeout: float | None = None) -> CanFrame | None:
        """Return the device's next response within ``timeout`` seconds (default: the channel's).

        None after a silence of this time, while the suite was listening. One in doubt is waited
        out again. Raises SecondClient when another client uses the channel, InterfaceLost
        when the bus is not reached any more.
        """
        return self._next(self._responses, timeout)

    def pause(self, seconds: float) -> CanFrame | None:
        """Send nothing for a time, by the clock; return a response that ends the pause."""
        return self._next_within(self._responses, self.link.patience(seconds, plain=True))

    def until_quiet(self, rest: float) -> bool:
        """Take responses until none has come for ``rest`` seconds; say whether that was reached."""
        deadline = self.link.deadline(MOST_TALK)
        while not deadline.has_passed:
            if self.receive(rest) is None:
                return True
        return False

    def waiting(self) -> list[CanFrame]:
        """Look, without waiting, for a frame more; return the responses not yet taken.

        Raises SecondClient when another client uses the channel.
        """
        for frame in self.link.look():
            self._check_own(frame)
        return [frame for frame, _ in self._responses]

    def take_arrived(self, most: int, is_wanted: Callable[[CanFrame], bool]) -> list[CanFrame]:
        """Return responses that have arrived, without waiting, as long as they are wanted.

        ``arrived`` is that of the last one, and ``waited_since`` that of the first.
        """
        queue = self._responses
        due = len(queue)
        if due < most:
            others = self.link.look(most - due)
            if len(queue) < due + len(others):
                for frame in others:
                    self._check_own(frame)
        taken: list[CanFrame] = []
        while queue and len(taken) < most:
            frame, arrived = queue[0]
            if (self._held and self._held[0][1] < arrived) or not is_wanted(frame):
                break
            queue.popleft()
            if not taken:
                self.waited_since = arrived
            taken.append(frame)
            self.arrived = arrived
        return taken

    def receive_error_control(self, timeout: float | None = None) -> CanFrame | None:
        """Return the device's next boot-up or heartbeat message, under the terms of ``receive``."""
        return self._next(self._error_control, timeout)

    def _next(self, queue: Waiting, timeout: float | None) -> CanFrame | None:
        seconds = self.response_timeout if timeout is None else timeout
        frame = self._next_within(queue, self.link.patience(seconds))
        waits, missed = 1, self.missed
        while frame is None:
            if seconds >= self.response_timeout:
                self.link.check()
            if not (self.in_doubt and seconds > 0 and waits < MOST_WAITS):
                break
            frame = self._next_within(queue, self.link.patience(seconds))
            waits, missed = waits + 1, missed + self.missed
        self.missed, self.waited_again = missed, waits > 1
        return frame

    def _next_within(self, queue: Waiting, patience: Patience) -> CanFrame | None:
        waits_for_answer = queue is self._responses and patience.left > 0
        while not queue:
            frame = self.link.receive_with(patience)
            if queue:
                break
            if frame is None:
                self.missed, self.in_doubt = patience.missed, patience.in_doubt
                return self._from_device() if self._held and waits_for_answer else None
            self._check_own(frame)
            patience.looked(silent=False)
        self.missed, self.in_doubt = patience.missed, False
        if self._held and queue is self._responses:
            held, _ = self._held[0]
            if self.strangers.another_answers(held, queue[0][0]):
                self._held.clear()
                raise second_client(self.ids.request)
            return self._from_device()
        found, self.arrived = queue.popleft()
        self.at_rest = queue is self._responses and not is_abort(found.data)
        return found

    def _from_device(self) -> CanFrame:
        """Take an abort on the identifier of the requests for the device's: no other answers."""
        self.strangers.confirmed = True
        found, self.arrived = self._held.popleft()
        self.at_rest = False
        return found

    def is_response(self, frame: CanFrame) -> bool:
        """Say whether a frame that has just come is the device's, in the right shape or not."""
        if frame.can_id == self.response_id:
            return self.ids.response.matches(frame) or self.strangers.is_answer(frame)
        return self.strangers.confirmed and self.strangers.is_abort(frame)

    def _check_own(self, frame: CanFrame) -> None:
        if self.ids.request.matches(frame) and not self.strangers.is_abort(frame):
            raise second_client(self.ids.request)

    def _take(self, frame: CanFrame) -> None:
        if self.is_response(frame):
            self._served_at = 0.0
            self._responses.append((frame, self.link.arrived))
            return
        if self.strangers.is_abort(frame):
            self._held.append((frame, self.link.arrived))
            return
        self.overheard.append(frame)
        if frame.can_id == self.ids.response.can_id:
            self.strangers.note(frame)
        plain = not (frame.extended or frame.remote or frame.fd)
        if frame.can_id == self._boot_up.can_id and plain and frame.dlc == 1:
            self._error_control.append((frame, self.link.arrived))
            self.boot_ups += frame == self._boot_up
            self.emergency = None if frame == self._boot_up else self.emergency
        elif plain and frame.can_id == self._emergency_id and tells_of_error(frame):
            self.emergency = frame
