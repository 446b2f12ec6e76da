"""A conversation with a device in lockstep with the oracle, which judges each of its responses."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import takewhile

from conformance.bus.link import Captured, Direction
from conformance.device.device import Device
from conformance.device.not_testable import NotTestable
from conformance.device.safety import may_ask
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.ended_transfers import has_left
from conformance.dialogue.rule_families import INCIDENTAL
from conformance.dialogue.silence import MOST_STRAY
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import (
    HIGHEST_NODE_ID,
    LARGEST_STANDARD_ID,
    REQUEST_BASE,
    ChannelIds,
)
from conformance.sdo.frames import INITIATES, Abort, Request, Response
from conformance.sdo.kinds import OTHER_DATA
from conformance.sdo.layout import Multiplexer, whole_frame
from conformance.sdo.line import Line
from conformance.sdo.oracle import Awaited, Facts, Knowledge, Oracle, Presence
from conformance.sdo.oracle.block_download import SubBlock
from conformance.sdo.rules import RESTART, UNSOLICITED, Cause, Level, Violation, idle
from conformance.sdo.rules.defects import GOES_ON, LENGTH_OF_ANOTHER, NOT_STORED
from conformance.sdo.rules.idle import (
    DOWNLOAD_WITHOUT_INITIATE,
    OUT_OF_BLOCK,
    UPLOAD_WITHOUT_INITIATE,
)
from conformance.sdo.rules.sizes import TYPE_LENGTH
from conformance.sdo.seen import Misread, abort_in

GIVEN_UP = (
    "what a server may do here was too much to follow: not every answer of this case was judged"
)

# By these a server says what is wrong with an initiate, not why it drops the transfer before it.
OF_AN_INITIATE = (AbortCode.INVALID_BLOCK_SIZE, AbortCode.LENGTH_TOO_HIGH)
# A frame behind an abort of the server breaks them because what it ended goes on.
WITHOUT_TRANSFER = frozenset(
    rule.id for rule in (DOWNLOAD_WITHOUT_INITIATE, UPLOAD_WITHOUT_INITIATE, OUT_OF_BLOCK)
)


def knowledge_of(
    device: Device, capacity: dict[Multiplexer, int], about: Iterable[Multiplexer] | None = None
) -> Knowledge:
    """Return what the oracle may take for granted of a device's objects.

    ``capacity`` has the bytes for which strings and domains surely have room. ``about`` are the
    objects that the conversation may name; None for all.
    """
    return Knowledge(
        {
            mux: Facts(
                Presence.PRESENT,
                known.access,
                known.data_type,
                device.contents.value(mux),
                steady=known.is_steady and mux in device.values,
                capacity=capacity.get(mux),
                habits=known.habits,
            )
            for mux in (device.known if about is None else about)
            if (known := device.known.get(mux)) is not None
        }
    )


class Lockstep:
    """Shows the oracle every frame that goes over the channel, and keeps what it finds.

    To the oracle, and in what is sent, any channel has the identifiers of the default one.
    """

    def __init__(self, sdo: Dialogue, oracle: Oracle) -> None:
        """Start with an idle server."""
        self.oracle = oracle
        self._sdo = sdo
        self._ids = sdo.channel.ids
        self._default_ids = ChannelIds.default(sdo.device.node_id)
        self._is_default = self._ids == self._default_ids
        self._findings: list[Violation] = []
        self._line = Line()
        self._held: list[Captured] = []
        self._point: Request | None = None
        # The server has aborted, and no transfer was asked for since.
        self._aborted = False

    @contextmanager
    def following(self) -> Iterator[None]:
        """Follow what is sent and received from here on."""
        link = self._sdo.channel.link
        link.listen(self._take)
        self._sdo.wire.after_fence = self._take_held
        self._sdo.wire.looks_for_aborts = False
        try:
            yield
        finally:
            self._sdo.wire.looks_for_aborts = True
            link.ignore(self._take)
            self._sdo.wire.after_fence = lambda: None

    def _take(self, captured: Captured) -> None:
        channel = self._sdo.channel
        numbers = (channel.request_id, channel.response_id)
        received = captured.direction is Direction.RECEIVED and captured.frame.can_id in numbers
        if received and not channel.is_response(captured.frame):
            return  # of another client or server
        if captured.frame.can_id not in numbers and self._is_elsewhere(captured.frame):
            return
        if self._sdo.wire.fencing:
            self._held.append(captured)
        else:
            self._show(captured)

    def _take_held(self) -> None:
        """Show the oracle a fence: what is no answer to its read came for what went before."""
        let_pass = self._sdo.wire.let_pass
        held = [captured for captured in self._held if captured.frame.data not in let_pass]
        self._held = []
        let_pass.clear()
        due = [answer for _, answer in self._sdo.device.baseline]
        received = [
            captured
            for captured in held
            if captured.direction is Direction.RECEIVED and self._is_response(captured)
        ]
        stray = list(
            takewhile(lambda captured: whole_frame(captured.frame.data) not in due, received)
        )
        for captured in stray:
            self._show(captured)
        for captured in held:
            if captured not in stray:
                self._show(captured)

    def _is_elsewhere(self, frame: CanFrame) -> bool:
        """Say whether a frame that is not on this channel is no request to another node either."""
        own = frame.can_id == self._default_ids.request.can_id
        return own or not 1 <= frame.can_id - REQUEST_BASE <= HIGHEST_NODE_ID

    def _as_default(self, frame: CanFrame) -> CanFrame:
        return frame if self._is_default else self._ids.translated(frame, self._default_ids)

    def _is_response(self, captured: Captured) -> bool:
        channel = self._sdo.channel
        return captured.frame.can_id in (channel.request_id, channel.response_id)

    def _show(self, captured: Captured) -> None:
        if captured.direction is Direction.SENT:
            request = self._line.request(captured.frame.data)
            self.oracle.observe(self._as_default(captured.frame))
            if isinstance(request, INITIATES):
                self._aborted = False
        elif self._is_response(captured):
            surplus = self._line.surplus(captured.frame.data, expected=True)
            if surplus is not None and self._sdo.record.causes.sub_blocks_are_exceeded:
                return  # it was noted, and is no answer
            findings = self.oracle.response(self._as_default(captured.frame))
            if surplus is not None:
                findings = [surplus if each.rule is UNSOLICITED else each for each in findings]
            self._find(findings)
            self._aborted |= isinstance(self._line.response(captured.frame.data), Abort)
            if self.oracle.ended is not None:
                self._sdo.record.early.note(self.oracle.ended.abort)

    def _find(self, findings: Iterable[Violation]) -> None:
        for found in findings:
            found.asked = self._sdo.wire.last_sent
            if self._aborted and found.rule.id in WITHOUT_TRANSFER:
                found.told_as = GOES_ON
            if found.rule is TYPE_LENGTH:
                found.told_as = LENGTH_OF_ANOTHER
            if isinstance(found.seen, Misread):
                nothing_is_stored = self._sdo.record.causes.nothing_is_stored
                found.told_as = (
                    NOT_STORED if nothing_is_stored else Cause(found.rule.id, *OTHER_DATA)
                )
                found.is_certain = True
            settling = isinstance(found.asked, Abort) and self._point != found.asked
            if (
                self._point is not None
                and settling
                and not self._sdo.record.causes.aborts_are_answered
            ):
                # What answers no abort has answered what went before.
                found.asked, settling = self._point, False
            elif settling and abort_in(found.seen) is None:
                found.asked = self._sdo.wire.sent_before  # crossed with the abort
            if self._point is not None and not settling:
                self._sdo.record.own.add(found)
            self._findings.append(found)

    def send(self, frame: CanFrame, *, point: bool = False) -> list[Response]:
        """Send any frame, take the answers that have to come, and return them.

        ``point``: what is wrong with them is what the case is about, and a fence follows. What
        comes behind an abort is waited for before that as well: its read would supersede what is
        served then. Not so where the abort has refused the request itself: whatever else comes has
        come before the answer to the fence.
        """
        answers = []
        if self.oracle.awaited is Awaited.NOTHING and not self.oracle.idle:
            self._look_for_abort()
        if not self._is_default:
            frame = self._default_ids.translated(frame, self._ids)
        if frame == self._ids.request.frame(frame.data):
            self._sdo.send(frame.data)  # which knows whether it is a segment of a block
        elif frame.can_id > LARGEST_STANDARD_ID and not frame.extended:
            raise NotTestable(f"needs a channel with 11-bit identifiers, not {self._ids}")
        else:
            self._sdo.send_frame(frame)
        self._point = self._sdo.wire.last_sent if point else None
        deadline = self._sdo.wire.waits.deadline(MOST_STRAY)
        while self.oracle.awaited is Awaited.ANSWER and not deadline.has_passed:
            answers += self._answer()
        latest = answers[-1] if answers else None
        if isinstance(latest, Abort) and not self._refuses_point(latest):
            answers += self._behind_abort()
        return answers

    def _refuses_point(self, abort: Abort) -> bool:
        """Say whether an abort names what is wrong with the initiate that a case is about."""
        reasons = self.oracle.rules - {RESTART, idle.ABORT_NOT_ANSWERED}
        named = abort.code in OF_AN_INITIATE and len(reasons) > 0
        return named and isinstance(self._point, INITIATES)

    def _behind_abort(self) -> list[Response]:
        """Take the answer that comes behind an abort where that is of a superseded transfer."""
        answers, deadline = list[Response](), self._sdo.wire.waits.deadline(MOST_STRAY)
        while not self.oracle.lost and (more := self._what_may_come()):
            answers += more
            if deadline.has_passed:
                break
        return answers

    def behind_gap(self) -> list[Response]:
        """Take the acknowledgements of a sub-block that may come behind a gap."""
        answers, deadline = list[Response](), self._sdo.wire.waits.deadline(MOST_STRAY)
        while SubBlock.name in self.oracle.states and (more := self._what_may_come()):
            answers += more
            if deadline.has_passed:
                break
        return answers

    def _answer(self) -> list[Response]:
        answer = self._sdo.wire.next_frame()
        if answer is None:
            self._sdo.wire.waits.unanswered()
            findings = self.oracle.settled()
            for silent in findings:
                silent.asked_as = silent.asked_as or self._sdo.wire.out_of_place
            self._find(findings)
        return self._taken(answer)

    def _what_may_come(self) -> list[Response]:
        """Take what may come and need not, if it comes as soon as this device answers.

        A silence settles nothing: what comes later crosses with what is sent next.
        """
        if self.oracle.awaited is not Awaited.MAYBE:
            return []
        return self._taken(self._sdo.wire.next_frame(self._sdo.wire.waits.look))

    def _taken(self, answer: CanFrame | None) -> list[Response]:
        self.check()
        if answer is None:
            return []
        return [self._sdo.wire.read(answer.data)]

    def arrived(self) -> list[Response]:
        """Take what has come though it did not have to."""
        answers = []
        for frame in self._sdo.drain():
            answers.append(self._sdo.wire.read(frame.data))
        self.check()
        return answers

    def _look_for_abort(self) -> None:
        """Take what the server has said of the transfer that runs before it is asked again."""
        if self._sdo.channel.waiting():
            self.arrived()

    def has_left(self) -> bool:
        """Say whether the server has left the sub-block that is being sent."""
        return has_left(self._sdo.wire)

    def may_ask(self, frame: CanFrame) -> bool:
        """Say whether the node that a frame is for may be sent requests."""
        return may_ask(frame, self._sdo.channel, self._sdo.device.permissions)

    def settle(self, mux: Multiplexer, *, abort: bool = False) -> None:
        """Abort what may be open, and prove by a fence that nothing more comes.

        A server may mind only an abort that names the object of its transfer. That is ``mux``
        where the oracle knows of none. ``abort``: also where nothing can be open. Each request may
        have been answered: as many answers may come before that of the fence.
        """
        if self.oracle.awaited is Awaited.NOTHING and not self.oracle.idle:
            self._look_for_abort()
        for target in self._may_run(mux):
            if abort or not self.oracle.idle:
                self._sdo.send(Abort(target, AbortCode.GENERAL_ERROR))
                abort = False
        try:
            self._sdo.silence.fence(most=MOST_STRAY + self.oracle.owed)
        except Violation as breach:
            if breach.told_as is None:
                self.check()
            raise
        self._find(self.oracle.settled())
        self.check()

    def _may_run(self, mux: Multiplexer) -> Iterable[Multiplexer]:
        """Return the objects that a transfer may be about, the likeliest first.

        What was asked for last may begin one yet: a frame of another length than 8, say.
        """
        asked = self._sdo.wire.last_sent
        begun = asked.mux if isinstance(asked, INITIATES) else None
        running = (*self.oracle.running, self._sdo.line.open, begun)
        return dict.fromkeys(each for each in (*running, mux) if each is not None)

    def check(self) -> None:
        """Raise the first breach found that fails a device; note the others.

        What other cases have met is noted as well, unless it is what this case is about and the
        oracle can no longer follow: an abort that names another object is an abort all the same.
        """
        if self.oracle.given_up and GIVEN_UP not in self._sdo.record.notes:
            self._sdo.info(GIVEN_UP)
        findings, self._findings = self._findings, []
        for found in findings:
            if self._fails(found):
                raise found
            self._sdo.note(found)

    def _fails(self, found: Violation) -> bool:
        if found.level is not Level.MUST or found.rule in INCIDENTAL:
            return False
        unknown = (
            self._sdo.record.causes.get(self._sdo.record.cause_of(found, self._sdo.wire.last_sent))
            is None
        )
        return unknown or (found in self._sdo.record.own and self.oracle.lost)
