"""The lowest layer of a case: one request out, one response in, nothing else in between.

Every response is held to the shape that any response must have. What comes although nothing was
asked is a breach of its own. That a frame must *not* be answered is proven by a fence, never by
waiting: the read of 1000h that the run began with is sent behind it, and only its answer may come.
"""

import time

from conformance.bus.channel import Channel
from conformance.bus.errors import DeviceLost
from conformance.device.deny import OTHER_NODES, READ_ONLY_PROBES
from conformance.device.device import Device, NotTestable
from conformance.device.safety import written_by
from conformance.run.pauses import Pauses
from conformance.run.tracker import TransferTracker
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE, CobId
from conformance.sdo.decoding import decode_request, decode_response
from conformance.sdo.describe import describe, describe_response, hex_bytes
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockSegment,
    BlockUploadInitiate,
    Request,
    Unknown,
    UploadInitiate,
)
from conformance.sdo.layout import FRAME_LENGTH, Message
from conformance.sdo.rules import ANSWERED, FRAME_SHAPE, SPECIFIER, UNSOLICITED, Violation

MOST_STRAY = 16
SEGMENTS_PER_LOOK = 4
_ACKNOWLEDGES = BlockAck(0, 0).encode()[:1]


class Wire:
    """A channel to a device within one case."""

    def __init__(self, channel: Channel, device: Device) -> None:
        """Start with no transfer open."""
        self.channel = channel
        self.device = device
        self.tracker = TransferTracker()
        self.pauses = Pauses(device.server_timeout)
        self.latency = 0.0
        self.waited = 0.0
        self.channels = [channel.ids]
        self._last_sent: Request = Unknown(b"")
        # Segments that were sent and not acknowledged; those that an abort may have crossed.
        self._segments = 0
        self._crossed = 0
        self._sent_at = 0.0
        self._read = b""
        channel.overheard.clear()

    # One frame at a time

    def send(self, request: Message | Unknown | bytes) -> None:
        """Send a request: a message, or 0 to 8 data bytes as they are.

        Raises WriteNotPermitted for one that would write where the user has not allowed it.
        """
        if self._crossed:
            self._let_pass()
        data = request if isinstance(request, bytes) else request.encode()
        within = self.tracker.open is not None
        decoded = self.tracker.request(data)
        if len(data) < FRAME_LENGTH:
            # What a careless device may take it for decides on what it may write.
            decoded = decode_request(data.ljust(FRAME_LENGTH, b"\0"))
        self.about_to_send(decoded)
        self.channel.send(data)
        self.pauses.sent(within=within)
        if isinstance(decoded, UploadInitiate | BlockUploadInitiate) and self.tracker.open is None:
            self._read = data

    def send_frame(self, frame: CanFrame) -> None:
        """Send any CAN frame, a request or not; raises NotTestable for one that the bus cannot."""
        if frame.remote and not self.channel.link.sends_remote_frames:
            raise NotTestable(f"needs remote frames, which {self.channel.link.name} cannot send")
        if not self.may_ask(frame):
            raise NotTestable(
                "needs permission to send SDO requests to other nodes, which may end a transfer "
                f"that somebody has open there: add --allow={OTHER_NODES}"
            )
        self.about_to_send(decode_request(frame.data.ljust(FRAME_LENGTH, b"\0")))
        self.channel.send_frame(frame)
        self.pauses.sent(within=self.tracker.open is not None)

    def may_ask(self, frame: CanFrame) -> bool:
        """Say whether a frame is for this node, or requests to others are permitted."""
        asks = frame.can_id & ~0x7F == REQUEST_BASE and not frame.extended
        own = frame.can_id in (self.channel.request_id, REQUEST_BASE + self.device.node_id)
        return own or not asks or OTHER_NODES in self.device.permissions

    def about_to_send(self, request: Request) -> None:
        """Take note of what goes out next; raises WriteNotPermitted or NotTestable."""
        target = written_by(request)
        if target is not None and self.device.policy.needs_probes(target):
            raise NotTestable(
                f"needs permission to write to {target}, which a device that is right refuses: "
                f"add --allow={READ_ONLY_PROBES}"
            )
        self.device.policy.check(request)
        self._last_sent = request
        self._segments = self._segments + 1 if isinstance(request, BlockSegment) else 0
        self._sent_at = time.monotonic()
        self._read = b""

    def receive(self) -> bytes:
        """Return the data bytes of the next response, which has to come.

        Raises Violation when none comes in time, or one that has not the shape of a response.
        """
        frame = self.next_frame()
        if frame is None and self._read and self.channel.waited_again:
            frame = self._read_again()
        if frame is None:
            raise Violation(
                ANSWERED,
                expected=f"an answer to: {describe(self._last_sent)}",
                actual=f"nothing within {self.channel.response_timeout * 1000:g} ms"
                + self._heard_elsewhere(),
            )
        return self._take(frame)

    def _read_again(self) -> CanFrame | None:
        """Repeat a read, once, of which the answer may have been missed; no other request is."""
        self.pauses.repeated(self.channel.missed)
        again = time.monotonic()
        self.send(self._read)
        frame = self.next_frame()
        if frame is not None and self.channel.arrived < again:
            self.channel.receive()  # the first answer has come after all, so there is another one
        return frame

    def has_left(self) -> bool:
        """Say whether the server has said something else than that it takes segments.

        What follows an abort within a sub-block would be requests to an idle server. This only
        looks at what has arrived, and only now and then: before an answer to a segment could be
        here, some more are on their way.
        """
        if self._segments % SEGMENTS_PER_LOOK:
            return False
        return any(frame.data[:1] != _ACKNOWLEDGES for frame in self.channel.waiting())

    def wait(self, seconds: float) -> bytes | None:
        """Send nothing for so many seconds; return the response that is due within them."""
        frame = self.channel.receive(seconds)
        if frame is None:
            self._note_missed()
        data = None if frame is None else self._take(frame)
        self.pauses.waited()
        return data

    def pause(self, seconds: float) -> bytes | None:
        """Send nothing for so many seconds by the clock; return the response that ends the pause.

        To the server that is a silence of its client like any other.
        """
        frame = self.channel.pause(seconds)
        if frame is None:
            return None
        self._note_received(frame)
        return self._take(frame)

    def next_frame(self, timeout: float | None = None) -> CanFrame | None:
        """Return the next response as it came, or None."""
        begin = time.monotonic()
        frame = self.channel.receive(timeout)
        if frame is None:
            self.waited += time.monotonic() - begin
            self._note_missed()
        else:
            self.latency = max(self.latency, self.channel.arrived - self._sent_at)
            self._note_received(frame)
        return frame

    def _note_received(self, frame: CanFrame) -> None:
        within = self.tracker.open is not None
        self.pauses.received(frame.data, self.channel.arrived, within=within)

    def _note_missed(self) -> None:
        if self.channel.in_doubt:
            self.pauses.missed(self.channel.missed)

    def _take(self, frame: CanFrame) -> bytes:
        check_shape(frame, self.channel.ids.response)
        self.tracker.response(frame.data)
        response = decode_response(frame.data)
        if isinstance(response, Abort):
            self._crossed = max(self._segments - 1, 0)
        elif isinstance(response, BlockAck) and response.sequence == self._segments:
            self._segments = 0
        return frame.data

    def _let_pass(self) -> None:
        """Wait for the answers to segments that were on their way when the server aborted.

        It was idle then, and may refuse each of them as a request.
        """
        stray = self.fence()
        if stray:
            raise _unsolicited(stray)

    def _heard_elsewhere(self) -> str:
        heard = [str(frame) for frame in self.channel.overheard if frame.dlc == FRAME_LENGTH]
        return f"; heard on other identifiers: {', '.join(heard[-3:])}" if heard else ""

    # Proof that nothing was answered

    def fence(self, most: int = MOST_STRAY) -> list[bytes]:
        """Read 1000h and return what came before its answer: so many frames at the most.

        Not the refusals of segments that crossed with an abort of the server.
        """
        stray: list[bytes] = []
        crossed, self._crossed = self._crossed, 0
        self._send_baseline(0)
        retried = False
        while True:
            frame = self.next_frame()
            if frame is None:
                # One request right behind another may get lost in a small device (a read is
                # harmless to repeat); one that follows silence may not.
                if retried:
                    raise Violation(
                        SPECIFIER if stray else ANSWERED,
                        expected="an answer to the read of 1000h that follows",
                        actual="; ".join(["no answer", *map(describe_response, stray)])
                        + self._heard_elsewhere(),
                    )
                retried = True
                self._send_baseline(0)
                continue
            data = self._take(frame)
            if data == self.device.baseline[0][1]:
                break
            if crossed and isinstance(decode_response(data), Abort):
                crossed -= 1
                continue
            if self.pauses.excuses(data):
                continue
            stray.append(data)
            if len(stray) > most:
                raise _unsolicited(stray)
        for request, due in self.device.baseline[1:]:
            self.send(request)
            data = self.receive()
            if data != due:
                raise Violation(
                    UNSOLICITED, expected=hex_bytes(due), actual=describe_response(data)
                )
        return stray

    def _send_baseline(self, position: int) -> None:
        self.send(self.device.baseline[position][0])

    def reaction(self) -> bytes | None:
        """Return the answer to what was sent last, or None when there was none.

        Ends the open transfer, if any, by an abort, so that the fence finds the server idle.
        Raises Violation when more than one answer came.
        """
        if self.tracker.open is not None:
            self.end_transfer()
        stray = self.fence()
        if len(stray) > 1:
            raise _unsolicited(stray, "one answer at most")
        return stray[0] if stray else None

    def end_transfer(self) -> None:
        """Abort the open transfer from the client's side; a server never answers that."""
        mux = self.tracker.open
        if mux is not None:
            abort = Abort(mux, AbortCode.GENERAL_ERROR)
            self.tracker.request(abort.encode())
            self.channel.send(abort)
            self.pauses.sent(within=True)

    def overheard_of_others(self) -> set[int]:
        """Return the node-IDs to which somebody else sent requests during this case."""
        return {
            frame.can_id & 0x7F
            for frame in self.channel.overheard
            if frame.can_id & ~0x7F == REQUEST_BASE and not frame.extended
        }

    def drain(self) -> list[CanFrame]:
        """Return the responses that are there though nothing was asked."""
        found = []
        while (frame := self.channel.receive(0)) is not None:
            found.append(frame)
        return found

    def lost(self) -> DeviceLost:
        """Describe a device that stopped answering."""
        return DeviceLost(
            f"Node {self.device.node_id} answered before and does not any more, not even a read of "
            "1000h after an abort. Reset or power-cycle it; the cases before this one show what "
            "was sent to it last."
        )


def check_shape(frame: CanFrame, response: CobId) -> None:
    """Raise Violation unless a frame is a data frame of 8 bytes in the format of the channel."""
    wrong = []
    if frame.extended != response.extended:
        wrong.append(f"{'a 29' if frame.extended else 'an 11'}-bit identifier")
    if frame.remote:
        wrong.append("a remote frame")
    if frame.dlc != FRAME_LENGTH:
        wrong.append(f"DLC {frame.dlc}")
    if wrong:
        raise Violation(
            FRAME_SHAPE,
            expected=f"a data frame of 8 bytes on {response} with "
            f"{'a 29' if response.extended else 'an 11'}-bit identifier",
            actual=f"{frame} ({', '.join(wrong)})",
        )


def _unsolicited(frames: list[bytes], expected: str = "no answer") -> Violation:
    return Violation(
        UNSOLICITED, expected=expected, actual="; ".join(map(describe_response, frames))
    )
