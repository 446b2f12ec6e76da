"""The lowest layer of a case: one request out, one response in, nothing else in between.

Every response is held to the shape that any response must have. What comes although nothing was
asked is a breach of its own. That a frame must *not* be answered is proven by a fence, never by
waiting: the read of 1000h that the run began with is sent behind it, and only its answer may come.
"""

import time
from collections import Counter
from collections.abc import Callable

from conformance.bus.channel import Channel
from conformance.bus.errors import DeviceLost
from conformance.bus.strangers import format_of
from conformance.device.deny import OTHER_NODES, READ_ONLY_PROBES
from conformance.device.device import DEVICE_TYPE, Device
from conformance.device.lacking import NotTestable
from conformance.device.safety import written_by
from conformance.dialogue.allowance import Allowance
from conformance.dialogue.causes import DEAF, NOTHING_SENT, Causes, kind_of_answer
from conformance.dialogue.delivered import Delivered
from conformance.dialogue.early import INITIATES, EarlyAborts, is_early
from conformance.dialogue.odd_frames import check_shape, in_words, unasked, unsolicited
from conformance.dialogue.one_defect import NO_ANSWER
from conformance.dialogue.pauses import Pauses
from conformance.dialogue.sub_blocks import SubBlocks
from conformance.dialogue.tracker import TransferTracker
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE
from conformance.sdo.decoding import decode_request, decode_response, decode_segment
from conformance.sdo.describe import describe, describe_response, hex_bytes
from conformance.sdo.errors import ERROR_REGISTER
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockSegment,
    BlockUploadInitiate,
    Request,
    Response,
    Unknown,
    UploadInitiate,
)
from conformance.sdo.layout import FRAME_LENGTH, Message
from conformance.sdo.rules import ANSWERED, NOT_REFUSED, SPECIFIER, UNSOLICITED, Violation

# Three sub-blocks that a server sends though nobody wants them are taken to their end.
MOST_STRAY = 400
MOST_NOTED = 100
# What comes faster than it is taken has no end.
MOST_DRAINED = 10_000
SEGMENTS_PER_LOOK = 4
_ABORTS = b"\x80"
_ACKNOWLEDGES = BlockAck(0, 0).encode()[:1]


class Wire:
    """A channel to a device within one case.

    ``causes`` is what is known to be wrong with the device: of one that sends what nobody asked
    for, that is taken away before the next transfer begins. ``minor`` are breaches that stop
    nothing; ``misshapen`` is one by the answer to what was sent last. ``own`` has breaches that
    are what the case is about, whatever their rules. ``answered_after`` is the time in seconds
    after which an answer came that a case had given up to wait for, None if there is none.
    While it is ``fencing``, what comes may have been asked for by what went before;
    ``after_fence`` is called then. It ``calms_down`` a noisy device only where that is sure to
    answer. It ``looks_for_aborts`` before it sends, unless an oracle is shown whatever comes. The
    ``allowance`` is how long answers may take; None without a limit.
    """

    def __init__(self, channel: Channel, device: Device, causes: Causes | None = None) -> None:
        """Start with no transfer open."""
        self.channel = channel
        self.device = device
        self.causes = Causes() if causes is None else causes
        self.minor: list[Violation] = []
        self._noted: Counter[str] = Counter()
        self.tracker = TransferTracker()
        self.delivered = Delivered()
        self._sub_blocks = SubBlocks()
        self.pauses = Pauses(device.server_timeout)
        self.latency = 0.0
        self.waited = self.answering = 0.0
        self.answers = 0
        self.channels = [channel.ids]
        self._sent = b""
        self._last_sent: Request = NOTHING_SENT
        # Segments that were sent and not acknowledged; those that an abort may have crossed.
        self._segments = 0
        self._crossed = 0
        self._sent_before: Request = self._last_sent
        self._abort: Abort | None = None
        self.own: set[BaseException | None] = set()
        # What was wrong with the shape of an answer to what the case has sent last.
        self.misshapen: Violation | None = None
        self._server_aborted = False
        self.early = EarlyAborts()
        self.fencing = False
        self.after_fence: Callable[[], None] = lambda: None
        self.calms_down = True
        self.allowance: Allowance | None = None
        self.looks_for_aborts = True
        self._unanswered = False
        self._unanswered_at: float | None = None
        self.answered_after: float | None = None
        self._sent_at = self._answered = 0.0
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
        self.misshapen = None
        # An abort of the client is behind all segments: no look of ``has_left`` comes any more.
        self._look_for_abort(within_burst=data[:1] != _ABORTS)
        if self.causes.noisy and self.tracker.open is None and not self._unanswered:
            self._calm_before(data)
        self._transmit(data)
        self._sent = data
        self._unanswered = not self.has_aborted

    def _look_for_abort(self, *, within_burst: bool) -> None:
        """Raise Violation where the server has ended the transfer before the next request.

        To an idle server that request would be another one.
        """
        if self._leaves_unasked(within_burst=within_burst):
            actual = describe_response(self.receive())
            found = Violation(NOT_REFUSED, expected="the transfer to go on", actual=actual)
            found.request = self._last_sent
            raise found

    def _leaves_unasked(self, *, within_burst: bool = False) -> bool:
        """Say whether the server has ended the transfer though it owes no answer.

        ``within_burst`` leaves segments of a block to ``has_left``.
        """
        if not self.looks_for_aborts:
            return False
        running = self.tracker.open
        owed = self._unanswered and (within_burst or not self._segments)
        if running is None or owed or self.fencing:
            return False
        waiting = self.channel.waiting()
        return bool(waiting) and is_early(waiting[0].data, running)

    def _transmit(self, data: bytes) -> None:
        within = self.tracker.open is not None
        self._sub_blocks.request(data)
        decoded = self.tracker.request(data)
        self.delivered.request(decoded)
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
                f"that somebody has open there: add --sdo-allow={OTHER_NODES}"
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
                f"add --sdo-allow={READ_ONLY_PROBES}"
            )
        self.device.policy.check(request)
        self._sent_before, self._last_sent = self._last_sent, request
        if not self.fencing:
            self.early.sent(request)
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
            self._unanswered_at = self._sent_at
            actual = f"nothing within {self.patience * 1000:.4g} ms" + self._heard_elsewhere()
            self.unanswered()
            expected = f"an answer to: {describe(self._last_sent)}"
            found = Violation(ANSWERED, expected=expected, actual=actual)
            found.request = self._last_sent
            raise found
        return self._take(frame)

    @property
    def patience(self) -> float:
        """How many seconds to wait for an answer that has to come."""
        return self.channel.pace.patience(self.channel.response_timeout)

    def unanswered(self) -> None:
        """Take that an answer which had to come did not."""
        if not self.channel.in_doubt:
            self.channel.pace.unanswered()

    def _read_again(self) -> CanFrame | None:
        """Repeat a read, once, of which the answer may have been missed; no other request is."""
        self.pauses.repeated(self.channel.missed)
        again = time.monotonic()
        self._transmit(self._read)
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

    def read_as(self, frame: bytes) -> Response:
        """Return what a response is by the state in which it came: a segment of a block may be it.

        A segment uses all of byte 0, and looks like any other response; also like an abort, but for
        80h, where a block upload may be running still.
        """
        response = decode_response(frame)
        unlike_abort = isinstance(response, Abort) and frame[:1] != _ABORTS
        if frame in self.tracker.segments or (unlike_abort and self.tracker.in_blocks):
            return decode_segment(frame)
        return response

    def words(self, frame: bytes) -> str:
        """Return a response in words, by the state in which it came, with its bytes."""
        return in_words(self.read_as(frame), frame)

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
        timeout = self.patience if timeout is None else timeout
        frame = self.channel.receive(timeout)
        while frame is not None and self._is_surplus(frame):
            frame = self.channel.receive(timeout)
        if frame is None:
            self.waited += time.monotonic() - begin
            self._note_missed()
        else:
            latency = self.channel.arrived - self._sent_at
            self.latency = max(self.latency, latency)
            if self._sent_at != self._answered:  # what comes behind it is no answer of its own
                self._answered = self._sent_at
                self.channel.pace.answered(latency)
                self.answers += 1
                self.answering += latency
                if self.allowance is not None:
                    self.allowance.take(latency)
            self._note_received(frame)
        return frame

    def _is_surplus(self, frame: CanFrame) -> bool:
        """Say whether this is a segment beyond its sub-block, and note that: no answer is."""
        found = self._sub_blocks.surplus(frame.data, expected=self.causes.sub_blocks_are_exceeded)
        if found is not None:
            self.note(found)
        return found is not None

    def _note_received(self, frame: CanFrame) -> None:
        within = self.tracker.open is not None
        self.pauses.received(frame.data, self.channel.arrived, within=within)

    def _note_missed(self) -> None:
        if self.channel.in_doubt:
            self.pauses.missed(self.channel.missed)

    def _take(self, frame: CanFrame) -> bytes:
        """Return 8 data bytes of a response; that it has another length is noted."""
        data = frame.data
        try:
            check_shape(frame, self.channel.ids.response)
        except Violation as odd:
            if not data or frame.extended or frame.remote or frame.fd:
                raise
            self.note(odd)
            self.misshapen = odd
            data = data[:FRAME_LENGTH].ljust(FRAME_LENGTH, b"\0")
        refused = self._unanswered and isinstance(self._last_sent, INITIATES)
        if not refused and not self.fencing:
            self.early.received(data, self.tracker.open)
        self.tracker.response(data)
        self.delivered.response(decode_response(data))
        self._unanswered = False
        response = decode_response(data)
        if not self.fencing:
            self._server_aborted = isinstance(response, Abort)
        if isinstance(response, Abort):
            self._crossed = max(self._segments - 1, 0)
        elif isinstance(response, BlockAck) and response.sequence == self._segments:
            self._segments = 0
        return data

    def note(self, violation: Violation) -> None:
        """Keep a breach that does not stop a transfer; of very many of a rule the first ones."""
        self._noted[violation.rule.id] += 1
        if self._noted[violation.rule.id] <= MOST_NOTED:
            violation.request = violation.request or self._last_sent
            self.minor.append(violation)

    def _let_pass(self) -> None:
        """Wait for the answers to segments that were on their way when the server aborted.

        It was idle then, and may refuse each of them as a request.
        """
        stray = self.fence()
        if stray:
            raise unsolicited(stray, read=self.read_as)

    def _heard_elsewhere(self) -> str:
        number = self.channel.response_id
        alike = [frame for frame in self.channel.overheard if frame.can_id == number]
        heard = [
            str(frame)
            for frame in self.channel.overheard
            if frame.dlc == FRAME_LENGTH and frame not in alike
        ]
        told = f"; heard on other identifiers: {', '.join(heard[-3:])}" if heard else ""
        if alike:
            told += f"; heard with that number, but a {format_of(alike[-1])}: {alike[-1]}"
        return told

    # Proof that nothing was answered

    def fence(self, most: int = MOST_STRAY) -> list[bytes]:
        """Read 1000h and return what came before its answer: so many frames at the most.

        Not the refusals of segments that crossed with an abort of the server.
        """
        before, asked = self._sent_before, self._last_sent
        self.fencing = True
        try:
            return self._fence(most)
        except Violation as found:
            if asked is NOTHING_SENT:
                found.request = self._last_sent
            raise
        finally:
            self.fencing = False
            self._sent_before, self._last_sent = before, asked
            self.after_fence()

    def _fence(self, most: int) -> list[bytes]:
        stray: list[bytes] = []
        crossed, self._crossed = self._crossed, 0
        at_rest = self.channel.at_rest and self.tracker.open is None
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
                        actual="; ".join(["no answer", *map(self.words, stray)])
                        + self._heard_elsewhere(),
                    )
                retried = True
                self.unanswered()
                self._send_baseline(0)
                continue
            data = self._take(frame)
            if data == self.device.baseline[0][1]:
                if at_rest:
                    self.channel.pace.read(answered=not retried)
                break
            if crossed and isinstance(self.read_as(data), Abort):
                crossed -= 1
                continue
            if self.pauses.excuses(data):
                continue
            stray.append(data)
            if self._unanswered_at is not None and self.answered_after is None:
                self.answered_after = time.monotonic() - self._unanswered_at
                self.channel.pace.late(self.answered_after)
            if len(stray) > most:
                raise unsolicited(stray, read=self.read_as)
        if retried:
            self._take_second_answer()
        for request, due in self.device.baseline[1:]:
            self._transmit(request)
            data = self.receive()
            if data != due:
                raise Violation(UNSOLICITED, expected=hex_bytes(due), actual=self.words(data))
        return stray

    def _take_second_answer(self) -> None:
        """Take the answer to the other of two reads, lest it be taken for that to what comes next.

        Whichever was answered, the other may be still: a server that was busy has both to answer.
        Another read behind them, of what each device has (7.5.2.2), tells without waiting.
        """
        baseline = self.device.baseline[0][1]
        self._transmit(UploadInitiate(ERROR_REGISTER).encode())
        while (frame := self.next_frame()) is not None and self._take(frame) == baseline:
            pass
        if len(self.device.baseline) > 1:
            self._send_baseline(0)
            self.receive()

    def _send_baseline(self, position: int) -> None:
        self._transmit(self.device.baseline[position][0])

    def _calm_before(self, data: bytes) -> None:
        begins = len(data) == FRAME_LENGTH and isinstance(decode_request(data), INITIATES)
        # What comes right behind an abort would be answered second. (81h to 9Fh may be a segment.)
        aborted = self._sent[:1] == _ABORTS and self.has_aborted
        behind_abort = aborted and data[:1] != _ABORTS and self.causes.aborts_are_answered
        if (begins or behind_abort) and self.calms_down:
            self.calm()

    def calm(self) -> None:
        """Take what the device sends though nobody asked, and note it.

        Not the segments of a sub-block that were on their way when the client ended the transfer.
        """
        aborted = self.has_aborted
        for frame in self.fence():
            if not (aborted and isinstance(self.read_as(frame), BlockSegment)):
                self.note(unasked(frame, aborted=aborted, read=self.read_as))

    def recover(self) -> bool:
        """Leave the server idle after a breach, whatever it may still send.

        Say whether it answers at all: a device that is lost has nothing to recover.
        """
        self.end_transfer()
        try:
            self.calm()
        except Violation as breach:
            self.drain()
            return breach.rule is not ANSWERED or not self._is_gone()
        return True

    def _is_gone(self) -> bool:
        """Say whether not even a read of 1000h is answered behind an abort of what may run."""
        self.channel.abort(self.tracker.latest or DEVICE_TYPE, AbortCode.GENERAL_ERROR)
        try:
            self.fence()
        except Violation as breach:
            return breach.rule is ANSWERED
        return False

    def reaction(self) -> bytes | None:
        """Return the answer to what was sent last, or None when there was none.

        Ends the open transfer, if any, by an abort, so that the fence finds the server idle.
        Raises Violation when more than one answer came.
        """
        ended = self.tracker.open is not None
        if ended:
            self._abort_open()
        stray = self.fence()
        if ended:
            self._take_answer_to_abort(stray)
        if len(stray) > 1:
            raise unsolicited(stray, "one answer at most", read=self.read_as)
        return stray[0] if stray else None

    def _take_answer_to_abort(self, stray: list[bytes]) -> None:
        """Take away what answers the suite's own abort, which came behind the point of a case.

        One abort may be the answer to what the case has sent, unless the device is known to answer
        aborts.
        """
        least = 0 if self.causes.aborts_are_answered else 1
        while len(stray) > least and isinstance(self.read_as(stray[-1]), Abort):
            violation = unasked(stray.pop(), aborted=True, read=self.read_as)
            violation.request = self._abort
            self.note(violation)

    def end_transfer(self) -> None:
        """Abort the open transfer from the client's side; a server never answers that."""
        if self._leaves_unasked():
            self.receive()  # it has ended the transfer itself
        if self.tracker.open is None:
            return
        # What answers a request before the abort is no noise: the case will look at it.
        segment = isinstance(self._last_sent, BlockSegment) and not self._last_sent.last
        owed = self._unanswered and not segment
        self._sent_before, self._last_sent = self._last_sent, self._abort_open()
        if self.causes.noisy and self.calms_down and not owed:
            self._calm_afterwards()

    def _calm_afterwards(self) -> None:
        """Calm the device down where a transfer was ended; whoever asks next will meet its silence.

        It is ended in the middle of tidying as well, where nothing may be raised.
        """
        try:
            self.calm()
        except Violation:
            self.drain()

    @property
    def server_aborted(self) -> bool:
        """Whether the last response outside a fence was an abort."""
        return self._server_aborted

    @property
    def last_sent(self) -> Request:
        """What was sent last, the reads of fences left out."""
        return self._last_sent

    @property
    def sent_before(self) -> Request:
        """What was sent before that."""
        return self._sent_before

    @property
    def has_aborted(self) -> bool:
        """Whether the last that was sent was an abort."""
        return isinstance(self._last_sent, Abort)

    def _abort_open(self) -> Abort:
        mux = self.tracker.open
        if mux is None:
            raise RuntimeError("no transfer is open")
        self._abort = Abort(mux, AbortCode.GENERAL_ERROR)
        self.delivered.request(self.tracker.request(self._abort.encode()))
        self.channel.send(self._abort)
        self.pauses.sent(within=True)
        return self._abort

    def overheard_of_others(self) -> set[int]:
        """Return the node-IDs to which somebody else sent requests during this case."""
        return {
            frame.can_id & 0x7F
            for frame in self.channel.overheard
            if frame.can_id & ~0x7F == REQUEST_BASE and not (frame.extended or frame.remote)
        }

    def drain(self) -> list[CanFrame]:
        """Return the responses that are there though nothing was asked."""
        found: list[CanFrame] = []
        while len(found) < MOST_DRAINED and (frame := self.channel.receive(0)) is not None:
            found.append(frame)
        return found

    def explain(self, violation: Violation, *, lost: bool = False) -> None:
        """Say of a silence that no answer has broken since what has brought it about.

        ``lost``: the device was told to end whatever it thinks is running.
        """
        abandoned = self.tracker.abandoned or (lost and self.tracker.asks_for_segments)
        if abandoned and kind_of_answer(violation.actual) == NO_ANSWER:
            violation.habit = DEAF

    def lost(self) -> DeviceLost:
        """Describe a device that stopped answering."""
        return DeviceLost(
            f"Node {self.device.node_id} answered before and does not any more, not even a read of "
            "1000h after an abort. Reset or power-cycle it; the cases before this one show what "
            "was sent to it last."
        )
