"""The lowest layer of a case: one request out, one response in, on one channel.

Every response is held to the shape that any response must have, and every frame is shown to what
follows the conversation. What is sent has to pass the write policy first.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from conformance.bus.channel import Channel
from conformance.bus.kinds import task_of
from conformance.bus.strangers import heard_elsewhere
from conformance.device.device import Device
from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.device.protected_objects import OTHER_NODES
from conformance.device.safety import may_ask
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.cause_of import NOTHING_SENT
from conformance.dialogue.pauses import Pauses
from conformance.dialogue.refusals import of_other_service, step_aside
from conformance.dialogue.server_aborts import leaves
from conformance.dialogue.shape_breaches import check_shape
from conformance.dialogue.timing import Timing
from conformance.dialogue.waits import MOST_SURPLUS, Waits
from conformance.dialogue.write_guard import READING, Effects
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_request, decode_segment
from conformance.sdo.describe import describe
from conformance.sdo.frames import (
    INITIATES,
    Abort,
    BlockDownloadInitiate,
    BlockSegment,
    BlockUploadInitiate,
    DownloadInitiate,
    RemoteFrame,
    Request,
    Response,
    Unknown,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.kinds import NO_ANSWER
from conformance.sdo.layout import FRAME_LENGTH, Message, Multiplexer, whole_frame
from conformance.sdo.line import Line
from conformance.sdo.rules import ANSWERED, Violation
from conformance.sdo.rules.block_download import WHOLE_SUB_BLOCK
from conformance.sdo.rules.defects import DEAF
from conformance.sdo.seen import NoAnswer

UPLOADS = UploadInitiate, BlockUploadInitiate
OUT_OF_PLACE = "what is out of place"
PLAIN_READING = UploadInitiate, UploadSegment


class Wire:
    """The frames of one channel within one case.

    ``last_sent`` and ``sent_before`` are what the case has sent, and not what a fence has. The
    ``line`` follows the conversation; ``parts`` are what downloads of each object have brought
    since one was completed. ``crossed`` counts the requests that an abort of the server may have
    crossed, and ``let_pass`` are refusals of these. ``misshapen`` is the breach by the shape of an
    answer to what was sent last, and ``server_aborted`` says that the last response was an abort;
    it is the ``refusal`` where it was that of an initiate. By ``own_abort`` the suite has ended a
    transfer since the case sent anything. While it is ``fencing``, what comes may have been asked
    for by what went before; ``after_fence`` is called then. It ``looks_for_aborts`` before it
    sends, unless an oracle is shown whatever comes.
    ``is_proven``: a fence has proven the server idle, and nothing but ordinary uploads followed.
    """

    def __init__(self, channel: Channel, device: Device, record: CaseRecord) -> None:
        """Start with no transfer open."""
        self.channel = channel
        self.device = device
        self.record = record
        self.line = Line()
        self.parts: defaultdict[Multiplexer, list[bytearray]] = defaultdict(list)
        self.effects = Effects(device, record)
        self.pauses = Pauses(device.server_timeout, channel.link.now)
        record.pauses.append(self.pauses)
        self.timing = Timing(channel.pace, channel.link.now)
        self.waits = Waits(channel, self.timing)
        self.is_proven = False
        self.last_sent: Request = NOTHING_SENT
        self.sent_before: Request = NOTHING_SENT
        self.crossed = 0
        self.let_pass: list[bytes] = []
        self.misshapen: Violation | None = None
        self.server_aborted = False
        self.refusal: Abort | None = None
        self.own_abort: Abort | None = None
        self.fencing = False
        self.after_fence: Callable[[], None] = lambda: None
        self.looks_for_aborts = True
        self._read = b""
        channel.overheard.clear()
        record.channels.append(channel.ids)

    # What is sent

    def send(self, data: bytes, built: Message | None = None) -> None:
        """Send a request of the case or of a fence: 0 to 8 data bytes, and what they were built of.

        Raises WriteNotPermitted for one that would write where the user has not allowed it.
        """
        running = self.line.open
        within = running is not None
        decoded = self._follow(data, built)
        in_burst = self.line.unacknowledged > 1
        if in_burst and isinstance(decoded, BlockSegment):
            self._about_to_send_another(decoded)
        else:
            if isinstance(decoded, Abort):
                self.record.early.aborted(running)
            if len(data) < FRAME_LENGTH:
                decoded = decode_request(whole_frame(data))
            self._about_to_send(_as_asked(decoded, data), decoded)
        self.channel.send(data, in_burst=in_burst)
        self.timing.left(self.channel.sent_at)
        self.pauses.sent(within=within)
        if not within and isinstance(decoded, UPLOADS):
            self._read = data

    def send_frame(self, frame: CanFrame) -> None:
        """Send any CAN frame, a request or not; raises NotTestable for one that the bus cannot."""
        if frame.remote and not self.channel.link.sends_remote_frames:
            raise NotTestable(f"needs remote frames, which {self.channel.link.name} cannot send")
        if not may_ask(frame, self.channel, self.device.permissions):
            raise NotTestable(
                "needs permission to send SDO requests to other nodes, which may end a transfer "
                f"that another client has open there: add --sdo-allow={OTHER_NODES}",
                Missing(Lack.PERMISSION, OTHER_NODES),
            )
        like = decode_request(whole_frame(frame.data))
        self.line.unacknowledged = 0
        remote = RemoteFrame(frame.data, frame.dlc) if frame.remote else None
        self._about_to_send(remote or _as_asked(like, frame.data), like)
        self.channel.send_frame(frame)
        self.timing.left(self.channel.sent_at)
        self.pauses.sent(within=self.line.open is not None)

    def abort_open(self) -> Abort:
        """Abort the open transfer from the client's side; return the abort."""
        mux = self.line.open
        if mux is None:
            raise RuntimeError("no transfer is open")
        self.own_abort = abort = Abort(mux, AbortCode.GENERAL_ERROR)
        self.is_proven = False
        self.line.request(abort.encode())
        self.channel.send(abort)
        self.pauses.sent(within=True)
        self.timing.ended()
        return abort

    def _about_to_send(self, request: Request, like: Request) -> None:
        """Take note of what goes out next, before an interruption could come in between.

        A careless device may take it for the request that it is ``like``: that decides on what it
        may write. Raises WriteNotPermitted or NotTestable.
        """
        reads = isinstance(like, READING)
        target = None if reads else self.effects.permit(like)
        self.sent_before, self.last_sent = self.last_sent, request
        if not self.fencing:
            self.own_abort = None
            self.record.early.sent(request)
        self.timing.sent(task_of(request, self.line.open))
        self._read = b""
        self.is_proven = self.is_proven and isinstance(request, PLAIN_READING)
        if not reads:
            self.effects.note(like, target)

    def _about_to_send_another(self, segment: BlockSegment) -> None:
        """Take note of a segment behind another one: nothing is new but what it brings."""
        self.sent_before, self.last_sent = self.last_sent, segment
        self.timing.sent(task_of(segment, None))
        self.effects.note_segment(segment)

    def _follow(self, data: bytes, built: Message | None) -> Request:
        """Take a request that goes out next; return which it is."""
        request = self.line.request(data, built)
        match request:
            case DownloadInitiate(mux=mux, expedited=False) | BlockDownloadInitiate(mux=mux):
                self.parts[mux].append(self.line.in_flight)
        return request

    @property
    def out_of_place(self) -> str:
        """Words for a request that continues no transfer and begins none; empty for any other."""
        return OUT_OF_PLACE if self.line.is_out_of_place else ""

    @property
    def has_aborted(self) -> bool:
        """Whether the last that was sent was an abort."""
        return isinstance(self.last_sent, Abort)

    # What is received

    def receive(self) -> Response:
        """Return the next response, which has to come.

        Raises Violation when none comes in time, or one that has not the shape of a response.
        """
        patience = self.waits.patience
        frame = self.next_frame()
        if frame is None and self._read and self.channel.waited_again:
            frame = self._read_again()
        if frame is None:
            self.timing.gave_up()
            actual = NoAnswer(f"nothing within {patience * 1000:.4g} ms{self.heard_elsewhere()}")
            self.waits.unanswered()
            expected = f"an answer to: {describe(self.last_sent)}"
            raise Violation(
                ANSWERED,
                expected=expected,
                actual=actual,
                asked=self.last_sent,
                asked_as=self.out_of_place,
            )
        return self.take(frame)

    def arrived_segments(self, behind: Response, most: int) -> list[Response]:
        """Return the segments that have arrived ``behind`` another and are due, but a marked one.

        Nothing is asked between them, so they need no more than to be counted.
        """
        if not isinstance(behind, BlockSegment) or not self.line.is_due(behind.sequence + 1):
            return []
        frames = self.channel.take_arrived(most, self._is_due_segment)
        if not frames:
            return []
        self.timing.received(self.channel.arrived)
        self.pauses.received(frames[0].data, self.channel.waited_since, within=True)
        self.pauses.received(frames[-1].data, self.channel.arrived, within=True)
        return [decode_segment(frame.data) for frame in frames]

    def _is_due_segment(self, frame: CanFrame) -> bool:
        return self.channel.ids.response.matches(frame) and self.line.take_due(frame.data)

    def heard_elsewhere(self) -> str:
        """Say what was heard since the case began, and not as a response on this channel."""
        return heard_elsewhere(self.channel.overheard, self.channel.response_id)

    def _read_again(self) -> CanFrame | None:
        """Repeat a read, once, of which the answer may have been missed; no other request is."""
        self.pauses.repeated(self.channel.missed)
        again = self.channel.link.now()
        self.send(self._read)
        frame = self.next_frame()
        if frame is not None and self.channel.arrived < again:
            self.channel.receive()  # the first answer has come after all, so there is another one
        return frame

    def wait(self, seconds: float) -> Response | None:
        """Send nothing for a time; return the response that is due within it."""
        frame = self.channel.receive(seconds)
        if frame is None:
            self._note_missed()
        response = None if frame is None else self.take(frame)
        self.pauses.waited()
        return response

    def pause(self, seconds: float) -> Response | None:
        """Send nothing for a time, by the clock; return the response that ends the pause.

        To the server that is a silence of its client like any other.
        """
        frame = self.channel.pause(seconds)
        if frame is None:
            return None
        self._note_received(frame)
        return self.take(frame)

    def next_frame(self, timeout: float | None = None) -> CanFrame | None:
        """Return the next response as it came, or None; where it has to come, without a time-out.

        That the device gives up a transfer while it owes an answer is no doing of the bench.
        """
        begin, has_to_come = self.channel.link.now(), timeout is None
        timeout = self.waits.patience if timeout is None else timeout
        deadline = self.channel.link.deadline(timeout + MOST_SURPLUS)
        frame = self.channel.receive(timeout)
        while frame is not None and self._is_surplus(frame):
            frame = self.channel.receive(min(timeout, deadline.left))
            if deadline.has_passed:
                break
        if frame is None:
            self.timing.waited_since(begin)
            self._note_missed()
            owed = self.line.owed or self.fencing
            if has_to_come and owed and not self.channel.in_doubt:
                self.record.waited()
        else:
            self.timing.received(self.channel.arrived)
            self._note_received(frame)
        return frame

    def _is_surplus(self, frame: CanFrame) -> bool:
        """Say whether this is a segment beyond its sub-block, and note that: no answer is."""
        exceeded = self.record.causes.sub_blocks_are_exceeded
        found = self.line.surplus(frame.data, expected=exceeded)
        if found is not None:
            self.note(found)
        return found is not None

    def _note_received(self, frame: CanFrame) -> None:
        within = self.line.open is not None
        self.pauses.received(frame.data, self.channel.arrived, within=within)

    def _note_missed(self) -> None:
        if self.channel.in_doubt:
            self.pauses.missed(self.channel.missed)

    def take(self, frame: CanFrame) -> Response:
        """Return a response as a message; that it has not 8 bytes is noted."""
        data = frame.data
        try:
            check_shape(frame, self.channel.ids.response)
        except Violation as odd:
            if not data or frame.extended or frame.remote or frame.fd:
                raise
            self.note(odd)
            self.misshapen = odd
            data = whole_frame(data)
        running, owed, segments = self.line.open, self.line.owed, self.line.unacknowledged
        response = self.read(data)
        abort = response if isinstance(response, Abort) else None
        self.refusal = abort if owed and isinstance(self.last_sent, INITIATES) else None
        ended = None if self.refusal or self.fencing else running
        self.record.early.received(response, ended)
        if abort is not None:
            # What the server was asked when it left on its own is on the way to an idle one.
            self.crossed = max(segments - 1, 0) + int(owed and leaves(abort, ended))
        if not self.fencing:
            self.server_aborted = abort is not None
            if self.refusal is not None:
                self._note_refusal(self.refusal, running)
        return response

    def _note_refusal(self, refusal: Abort, running: Multiplexer | None) -> None:
        """Take the refusal of an initiate: by the code of another service, or in another state."""
        if running is None:
            foreign = of_other_service(refusal, self.last_sent)
            if foreign is not None:
                self.note(foreign)
        if self.record.in_case and self.looks_for_aborts:
            step_aside(refusal, self.last_sent, self.device)

    def read(self, data: bytes) -> Response:
        """Follow a response, and what it confirms; return which it is."""
        running = self.line.open
        response = self.line.response(data)
        if self.line.completed is not None:
            self.parts.pop(self.line.completed, None)
        self.effects.answered(response, running if self.line.open is None else None)
        return response

    # What is found

    def note(self, violation: Violation) -> None:
        """Keep a breach that does not stop a transfer; that segments get lost is kept once."""
        if violation.rule is WHOLE_SUB_BLOCK:
            if self.device.learned.loses_segments:
                return
            self.device.learned.loses_segments = True
        self.record.note(violation, self.last_sent)

    def explain(self, violation: Violation, *, lost: bool = False) -> None:
        """Say of a silence that no answer has broken since what has brought it about.

        ``lost``: the device was told to end whatever it thinks is running.
        """
        abandoned = self.line.is_abandoned or (lost and self.line.waits_for_segments)
        if abandoned and violation.seen.kind == NO_ANSWER:
            violation.told_as = DEAF

    # Beside the case

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Exchange something beside the case: what the case has sent last stays that."""
        before, asked = self.sent_before, self.last_sent
        self.fencing = True
        try:
            yield
        except Violation as found:
            if asked is NOTHING_SENT:
                found.asked = self.last_sent
            raise
        finally:
            self.fencing = False
            self.sent_before, self.last_sent = before, asked
            self.after_fence()


def _as_asked(like: Request, data: bytes) -> Request:
    """Return which request was sent, ``like`` one of 8 bytes: no data have no command specifier."""
    return like if data else Unknown(data)
