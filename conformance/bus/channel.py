"""An SDO channel to one device: its requests go out, its responses come in, the rest is watched."""

import time
from collections import deque
from collections.abc import Callable

from conformance.bus.link import Link, second_client
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort, Unknown
from conformance.sdo.layout import Message, Multiplexer

REQUEST_BASE = 0x600
RESPONSE_BASE = 0x580
ERROR_CONTROL_BASE = 0x700
BOOT_UP = bytes(1)
MOST_OVERHEARD = 1000


class Channel:
    """The pair of COB-IDs of one device on a link; by default 600h and 580h plus node-ID.

    Responses are all frames with the response identifier, well-formed or not. What else comes
    from the bus is kept in ``overheard``; boot-up messages of the device call ``on_boot_up``.
    """

    def __init__(self, link: Link, node_id: int, response_timeout: float) -> None:
        """``response_timeout`` is the time in seconds within which a response has to come."""
        self.link = link
        self.node_id = node_id
        self.response_timeout = response_timeout
        self.request_id = REQUEST_BASE + node_id
        self.response_id = RESPONSE_BASE + node_id
        self.overheard: deque[CanFrame] = deque(maxlen=MOST_OVERHEARD)
        self.on_boot_up: Callable[[], None] = lambda: None

    def send(self, request: Message | Unknown | bytes) -> None:
        """Send a request: a message, or data bytes as they are."""
        data = request if isinstance(request, bytes) else request.encode()
        self.send_frame(CanFrame(self.request_id, data))

    def send_frame(self, frame: CanFrame) -> None:
        """Send any frame."""
        self.link.send(frame)

    def abort(self, mux: Multiplexer, code: int) -> None:
        """End a transfer from the client's side."""
        self.send(Abort(mux, code))

    def receive(self, timeout: float | None = None) -> CanFrame | None:
        """Return the device's next response within ``timeout`` seconds (default: the channel's).

        None when there is none. Raises SecondClient when somebody else uses the channel.
        """
        left = self.response_timeout if timeout is None else timeout
        deadline = time.monotonic() + left
        while True:
            # Past the deadline the link looks at what has arrived already, and that not for ever.
            frame = self.link.receive(left)
            if frame is None or frame.can_id == self.response_id:
                return frame
            self._overhear(frame)
            left = deadline - time.monotonic()

    def _overhear(self, frame: CanFrame) -> None:
        if frame.can_id == self.request_id and not frame.extended:
            raise second_client(frame.can_id)
        self.overheard.append(frame)
        is_error_control = frame.can_id == ERROR_CONTROL_BASE + self.node_id and not frame.extended
        if is_error_control and frame.data == BOOT_UP:
            self.on_boot_up()
