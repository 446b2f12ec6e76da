"""Proof that nothing was answered, and what leaves a server idle.

That a frame must *not* be answered is proven by a fence, never by waiting: the read of 1000h that
the run began with is sent behind it, and only its answer may come.
"""

from conformance.device.device import DEVICE_TYPE
from conformance.dialogue.cause_of import blocked
from conformance.dialogue.ended_transfers import leaves_unasked, look_for_abort
from conformance.dialogue.server_aborts import leaves
from conformance.dialogue.shape_breaches import unasked, unsolicited
from conformance.dialogue.wire import Wire
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_request, is_abort
from conformance.sdo.describe import hex_bytes
from conformance.sdo.emergency import ERROR_REGISTER
from conformance.sdo.frames import (
    INITIATES,
    Abort,
    BlockEndResponse,
    BlockSegment,
    DownloadInitiateResponse,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
)
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.rules import ANSWERED, CONSTANT, SPECIFIER, UNSOLICITED, Violation
from conformance.sdo.seen import NoAnswer, Received

# Three sub-blocks that a server sends unasked are taken to their end.
MOST_STRAY = 400
# What comes faster than it is taken has no end.
MOST_DRAINED = 10_000


class Silence:
    """The silence of a server on a channel: proven, and brought about where it has to be.

    It ``calms_down`` a noisy device only where that is sure to answer: unsolicited responses of one
    that sends them are taken away before the next transfer begins.
    """

    def __init__(self, wire: Wire) -> None:
        """Take the frames of the channel."""
        self.calms_down = True
        self._wire = wire
        self._device = wire.device
        self._causes = wire.record.causes

    # Before a request

    def before(self, data: bytes) -> None:
        """Take what the server may still send before it gets its next request.

        Raises Violation where it has ended the transfer.
        """
        wire = self._wire
        if wire.line.owed and wire.line.unacknowledged and not is_abort(data):
            return  # nothing has come behind the segment before
        if wire.crossed:
            self._let_pass()
        wire.misshapen = None
        look_for_abort(wire, data)
        if wire.line.open is None and not wire.line.owed and self._causes.noisy:
            self._calm_before(data)

    def _let_pass(self) -> None:
        """Wait for the answers to segments that were on their way when the server aborted.

        It was idle then, and may refuse each of them as a request.
        """
        stray = self.fence()
        if stray:
            raise unsolicited(stray)

    def _calm_before(self, data: bytes) -> None:
        begins = len(data) == FRAME_LENGTH and isinstance(decode_request(data), INITIATES)
        # What comes right behind an abort would be answered second. (81h to 9Fh may be a segment.)
        wire = self._wire
        aborted = wire.own_abort is None and is_abort(wire.last_sent.encode())
        behind_abort = aborted and not is_abort(data) and self._causes.aborts_are_answered
        behind_end = isinstance(wire.last_sent, BlockEndResponse)
        is_calm = wire.channel.is_calm and not wire.channel.waiting()
        if (begins or behind_abort or behind_end) and self.calms_down and not is_calm:
            self.calm()

    # The fence

    def fence(self, most: int = MOST_STRAY) -> list[Response]:
        """Read 1000h and return what came before its answer, ``most`` responses at most.

        Not the refusals of segments that crossed with an abort of the server.
        """
        with self._wire.aside():
            return self._fence(most)

    def _fence(self, most: int) -> list[Response]:
        wire = self._wire
        stray: list[Response] = []
        crossed, wire.crossed = wire.crossed, 0
        at_rest = wire.channel.at_rest and wire.line.open is None
        self._send_baseline()
        asked, deadline = wire.channel.link.now(), wire.waits.deadline(most)
        retried = False
        while True:
            frame = wire.next_frame()
            if frame is None:
                # One request right behind another may get lost in a small device (a read is
                # harmless to repeat); one that follows silence may not.
                if retried:
                    raise self._no_answer(stray)
                retried = True
                wire.waits.unanswered()
                self._note_silence()
                self._send_baseline()
                continue
            response = wire.take(frame)
            if response.encode() == self._device.baseline[0][1]:
                if at_rest:
                    wire.channel.pace.read(answered=not retried)
                break
            if self._is_read_otherwise(response):
                wire.let_pass.append(frame.data)
                break
            taken = self._taken_segment(response)
            if crossed and (taken is not None or isinstance(response, Abort)):
                crossed -= 1
                if taken is not None:
                    wire.effects.note_taken_segment(taken)
                wire.let_pass.append(frame.data)
                continue
            if wire.pauses.excuses(response):
                continue
            stray.append(response)
            wire.timing.came_late()
            if len(stray) > most or deadline.has_passed:
                raise unsolicited(stray)
        if retried:
            took = wire.channel.arrived - asked
            if self._take_second_answer():
                wire.channel.pace.late(took)
        if response.encode() == self._device.baseline[0][1]:
            self._read_the_rest()
        wire.is_proven = wire.channel.is_calm = not stray
        return stray

    def _note_silence(self) -> None:
        """Say in the result that a read of 1000h is sent again."""
        waited = self._wire.waits.patience * 1000
        self._wire.record.notes.append(
            f"a read of 1000h was not answered within {waited:.4g} ms, and was sent again"
        )

    def _is_read_otherwise(self, response: Response) -> bool:
        """Take the answer of a device that has let 1000h be written: the value is put back later.

        It is that only where a probe was sent and 1000h is not known to be as before.
        """
        changed = self._device.contents.outstanding
        if DEVICE_TYPE not in changed or not isinstance(response, UploadInitiateResponse):
            return False
        if response.mux != DEVICE_TYPE:
            return False
        if self._wire.line.open is not None:
            self._wire.abort_open()
        due = f"{DEVICE_TYPE} reads {hex_bytes(changed[DEVICE_TYPE])}, as at the beginning"
        self._wire.note(Violation(CONSTANT, expected=due, actual=Received(response)))
        return True

    def _taken_segment(self, response: Response) -> Multiplexer | None:
        """Return the object that an answer says was written, if a segment that crossed names it."""
        if not isinstance(response, DownloadInitiateResponse):
            return None
        return response.mux if response.mux in self._wire.effects.spelled else None

    def _no_answer(self, stray: list[Response]) -> Violation:
        return Violation(
            SPECIFIER if stray else ANSWERED,
            expected="an answer to the read of 1000h that follows",
            actual=NoAnswer(responses=stray, remark=self._wire.heard_elsewhere()),
            told_as=blocked(stray, DEVICE_TYPE),
        )

    def _read_the_rest(self) -> None:
        """Read the segments of 1000h, where it takes any."""
        for request, due in self._device.baseline[1:]:
            self._wire.send(request)
            response = self._wire.receive()
            if response.encode() != due:
                raise Violation(UNSOLICITED, expected=hex_bytes(due), actual=Received(response))

    def _take_second_answer(self) -> bool:
        """Take the answer to the other of two reads, lest it be taken for that to what comes next.

        Whichever was answered, the other may be still: a server that was busy has both to answer.
        Another read behind them, of what each device has (7.5.2.2), tells without waiting. Say
        whether both were answered: the first was answered late then.
        """
        wire = self._wire
        baseline = self._device.baseline[0][1]
        wire.send(UploadInitiate(ERROR_REGISTER).encode())
        deadline, both = wire.waits.deadline(1), False
        while (frame := wire.next_frame()) is not None and wire.take(frame).encode() == baseline:
            both = True
            if deadline.has_passed:
                break
        if len(self._device.baseline) > 1:
            self._send_baseline()
            wire.receive()
        return both

    def _send_baseline(self) -> None:
        self._wire.send(self._device.baseline[0][0])

    def reaction(self) -> Response | None:
        """Return the answer to what was sent last, or None when there was none.

        Ends the open transfer, if any, by an abort, so that the fence finds the server idle.
        Raises Violation when more than one answer came.
        """
        own = None if self._wire.line.open is None else self._wire.abort_open()
        stray = self.fence()
        if own is not None:
            self._take_answer_to_abort(own, stray)
        if len(stray) > 1:
            raise unsolicited(stray, "one answer at most")
        return stray[0] if stray else None

    def _take_answer_to_abort(self, own: Abort, stray: list[Response]) -> None:
        """Take away what answers the suite's own abort, which came behind the point of a case.

        One abort may be the answer to what the case has sent, unless the device is known to answer
        aborts.
        """
        least = 0 if self._causes.aborts_are_answered else 1
        while len(stray) > least and isinstance(stray[-1], Abort):
            violation = unasked(stray.pop(), aborted=True)
            violation.asked = own
            self._wire.note(violation)

    # An idle server

    def end_transfer(self) -> None:
        """Abort the open transfer from the client's side; a server never answers that."""
        wire = self._wire
        if leaves_unasked(wire):
            wire.receive()  # it has ended the transfer itself
        if wire.line.open is None:
            return
        # What answers a request before the abort is no noise: the case will look at it.
        segment = isinstance(wire.last_sent, BlockSegment) and not wire.last_sent.last
        owed = wire.line.owed and not segment
        wire.sent_before, wire.last_sent = wire.last_sent, wire.abort_open()
        if self._causes.noisy and self.calms_down and not owed:
            self._calm_afterwards()

    def _calm_afterwards(self) -> None:
        """Calm the device down where a transfer was ended; the next request will meet its silence.

        It is ended in the middle of tidying as well, where nothing may be raised.
        """
        try:
            self.calm()
        except Violation:
            self.drain()

    def calm(self) -> None:
        """Take what the device sends unasked, and note it.

        Not what was on its way when the client ended the transfer: the segments of a sub-block, or
        an abort for a reason of the server's own.
        """
        aborted, latest = self._wire.has_aborted, self._wire.line.latest
        for response in self.fence():
            crossed = isinstance(response, BlockSegment) or leaves(response, latest)
            if not (aborted and crossed):
                self._wire.note(unasked(response, aborted=aborted))

    def recover(self, *, crossed: bool = False) -> bool:
        """Leave the server idle after a breach, whatever it may still send.

        ``crossed``: the server has ended a transfer, perhaps while a request was on the way; as an
        idle server it may refuse that. Say whether it answers at all: a device that is lost has
        nothing to recover.
        """
        self.end_transfer()
        if crossed:
            self._wire.crossed = max(self._wire.crossed, 1)
        try:
            self.calm()
        except Violation as breach:
            self.drain()
            return breach.rule is not ANSWERED or not self._is_gone()
        return True

    def _is_gone(self) -> bool:
        """Say whether not even a read of 1000h is answered behind an abort of what may run."""
        wire = self._wire
        wire.channel.abort(wire.line.latest or DEVICE_TYPE, AbortCode.GENERAL_ERROR)
        try:
            self.fence()
        except Violation as breach:
            return breach.rule is ANSWERED
        return False

    def outlast(self) -> list[Response]:
        """Wait until the device sends nothing more by itself, and return what it has sent.

        No fence shows segments of a block that are sent one by one, as its answer may come between
        two of them.
        """
        wire, channel = self._wire, self._wire.channel
        look, deadline = wire.waits.look, wire.waits.deadline(MOST_STRAY)
        found: list[Response] = []
        while len(found) < MOST_STRAY and (frame := channel.receive(look)) is not None:
            if deadline.has_passed:
                break
            found.append(wire.line.response(frame.data))
        return found

    def drain(self) -> list[CanFrame]:
        """Return the responses that are there though nothing was asked."""
        found: list[CanFrame] = []
        while len(found) < MOST_DRAINED:
            frame = self._wire.channel.receive(0)
            if frame is None:
                break
            found.append(frame)
        return found
