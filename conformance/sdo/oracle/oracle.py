"""Follows a conversation on one SDO channel, and judges each response of the server.

Sans-I/O: frames go in, judgements come out. The caller says what was sent (``request``), what came
(``response``), that nothing more came (``settled``), and that the client was silent for so long
that a server may give up (``silence``). Each of the last three returns the breaches found, the
first of which stops the following unless it is one of shape; the oracle then waits for the next
initiate or abort of the client to find its way back.

What happens on other channels it is not told: a server that refuses an object because another
client is at it must not be followed on one channel alone.
"""

from dataclasses import replace

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE, RESPONSE_BASE
from conformance.sdo.decoding import CODES, decode_response
from conformance.sdo.frames import Abort
from conformance.sdo.limits import LARGEST_BLOCK
from conformance.sdo.oracle.answers import violation
from conformance.sdo.oracle.branch import Branch, Misfit, quiet
from conformance.sdo.oracle.endings import Ended, ending
from conformance.sdo.oracle.going_on import AT_THE_END, goes_on, waits_for_the_end
from conformance.sdo.oracle.knowledge import Knowledge, Memory
from conformance.sdo.oracle.levels import must
from conformance.sdo.oracle.losing import bearing, bears, is_fence, lost_from, rested
from conformance.sdo.oracle.lost import LOST, Lost
from conformance.sdo.oracle.no_requests import hear_no_request
from conformance.sdo.oracle.requests_in_turn import (
    ABORT_COMMAND,
    Hearing,
    acknowledged_early,
    answers_due,
)
from conformance.sdo.oracle.standing import Awaited, Standing
from conformance.sdo.oracle.states import IDLE
from conformance.sdo.oracle.wire_shape import shaped
from conformance.sdo.rules import (
    ANSWERED,
    NOT_REFUSED,
    SPECIFIER,
    UNSOLICITED,
    Violation,
    channels,
    idle,
)
from conformance.sdo.rules import block_upload as block_uploads
from conformance.sdo.rules.block_upload import EARLY_ACKNOWLEDGEMENT
from conformance.sdo.seen import NoAnswer

NODE_IDS = range(1, 128)
# So many requests in a row are waited on together for answers that come late.
MOST_OVERDUE = 4


class Oracle(Standing):
    """What is known of one server after what was said so far.

    >>> oracle = Oracle()
    >>> oracle.request(bytes.fromhex("40 18 10 01 00 00 00 00"))
    >>> oracle.response(bytes.fromhex("43 18 10 01 04 00 00 00"))
    []
    """

    def __init__(self, knowledge: Knowledge | None = None, node_id: int | None = None) -> None:
        """Start with an idle server. ``node_id`` is needed for CAN frames as a whole only."""
        super().__init__(quiet(IDLE, Memory(knowledge or Knowledge()), NOT_REFUSED))
        self._node_id = node_id
        self._hearing = Hearing()
        self._asked = False
        self._other_asked = False
        # Requests since the last response: an abort of the server may have crossed with them.
        self._sent: list[bytes] = []
        # Where an answer was wrong, the right one may still come: the wrong one was another then.
        self._still_due: list[Branch] = []
        # Requests of which answers may still come to a client that has lost the server.
        self._crossing: set[bytes] = set()
        self.ended: Ended | None = None
        # Whether the latest response was let pass because the state of the server was not known.
        self.unjudged = False

    @property
    def owed(self) -> int:
        """The most answers that may still come to what was sent."""
        behind = [branch.state.owed for branch in self._branches if isinstance(branch.state, Lost)]
        return max(behind, default=0) + len(self._sent) + self._most_waiting()

    @property
    def effort(self) -> int:
        """How many ways to go on have been looked at so far, for all that was said."""
        return self._hearing.effort

    def request(self, frame: bytes | CanFrame) -> None:
        """Take what the client sent: the data bytes of a request, or a whole CAN frame.

        A CAN frame that is no request on this channel asks for nothing.
        """
        if isinstance(frame, CanFrame):
            self._other_asked = self._is_for_another(frame)
            if not self._is_addressed(frame):
                return
            if frame.extended or frame.remote:
                self._go_to(
                    [to for branch in self._branches for to in hear_no_request(branch, frame)]
                )
                return
            frame = frame.data
        self._asked = True
        self._sent.append(frame)
        self._still_due.clear()
        hear = self._hearing.hear
        self._go_to([after for branch in self._branches for after in hear(branch, frame)])

    def response(self, frame: bytes | CanFrame) -> list[Violation]:
        """Take what the server sent; return what was wrong with it."""
        data, findings = shaped(frame, self._node_id)
        fits: list[Branch] = []
        misfits: list[Misfit] = []
        still_due, self._still_due = self._still_due, []
        for branch, due in answers_due([*self._branches, *still_due], data):
            try:
                fits += self._hearing.take(branch, due, data)
            except Misfit as misfit:
                misfits.append(misfit)
        near = any(misfit.near for misfit in misfits)
        found = bool(fits)
        if self.lost and not (found and is_fence(self._sent, self._crossing, data)):
            fits += [
                bearing(each) for each in self._branches if bears(each, data, fits=found, near=near)
            ]
        self.ended = None
        self.unjudged = not found and bool(fits)
        unfit = not fits or min(branch.failures for branch in fits) > 0
        abort = decode_response(data)
        refused = bool(fits) and isinstance(abort, Abort) and abort.code in CODES
        stray = unfit and not near and not refused
        going_on = goes_on(self._branches, data) if stray else None
        if going_on is not None:
            broken = [going_on]
            memory = self._branches[0].memory.in_doubt()
            self._go_to([quiet(Lost(LARGEST_BLOCK), memory, block_uploads.FOREIGN)])
        elif unfit and any(map(acknowledged_early, self._branches)):
            broken = []
            memory = self._branches[0].memory.in_doubt()
            self._go_to([quiet(Lost(LARGEST_BLOCK), memory, EARLY_ACKNOWLEDGEMENT)])
        elif unfit:
            broken = self._unfit(fits, misfits, data)
        else:
            end = ending(self._branches, data, self._sent) if data[0] == ABORT_COMMAND else None
            reasonable = end is not None and end.may_cross
            broken = self._keep_best([*fits, *(end.branches if end and reasonable else ())])
            if broken and end is not None and not end.wrong:
                # It may as well have ended what ran before it got what fits so badly.
                self._go_to([*self._branches, *end.branches])
        self._asked = self._other_asked = False
        self._cross()
        self._sent.clear()
        return findings + broken

    def _cross(self) -> None:
        """Remember the requests that may have crossed with a response, while that is not clear."""
        if any(isinstance(branch.state, Lost) and branch.state.owed for branch in self._branches):
            self._crossing.update(self._sent)
        else:
            self._crossing.clear()

    def _unfit(self, fits: list[Branch], misfits: list[Misfit], data: bytes) -> list[Violation]:
        """Take a response that is not allowed, unless it is the abort that always is."""
        end = ending(self._branches, data, self._sent)
        if end is None:
            if fits:
                return self._keep_best(fits)
            broken = self._misfit(misfits, data)
            self._recover(data)
            return broken
        broken = self._keep_best(fits) if fits else end.wrong or self._misfit(misfits, data)
        self._go_to(end.branches)
        if end.due and not end.wrong:
            return self._keep_best(self._branches)
        if not (end.wrong or end.senseless):
            self.ended = Ended(end.abort, broken[0], refusal=bool(fits))
        return broken

    def settled(self) -> list[Violation]:
        """Take that nothing more came, as a fence or a time-out proves; return what is missing."""
        resting = [rested(branch) for branch in self._branches if branch.due is None]
        silent = None if resting else self._silent(self._branches)
        self._forget_requests()
        if silent is not None:
            memory = self._branches[0].memory.in_doubt()
            self._go_to(
                [quiet(lost_from(self._branches, self._sent), memory, self._branches[0].rule)]
            )
            return [silent]
        if resting == self._branches and len(resting) == 1:
            return self._keep_best(resting) if resting[0].findings else []
        return self._keep_best(resting)

    def overdue(self, *also: Violation) -> Violation | None:
        """Take that the answer may never come, since it has not for long; a later one is right.

        Returns the breach that it is if none comes; None where none has to. ``also`` are those of
        the requests behind it.
        """
        if self.awaited is not Awaited.ANSWER:
            return None
        latest = [branch for branch in self._branches if not branch.backlog] or self._branches
        silent = self._silent(latest)
        nearest = min(latest, key=lambda branch: branch.failures)
        state = lost_from(self._branches, self._sent)
        lost = quiet(state, nearest.memory.in_doubt(), nearest.rule)
        waiting_on = [each for each in self._branches if len(each.backlog) < MOST_OVERDUE]
        del self._sent[:-MOST_OVERDUE]
        self._go_to([*waiting_on, lost.noting(*nearest.findings, silent, *also)])
        return silent

    def rested(self) -> None:
        """Take that the bus was quiet: a server that is lost hardly owes anything any more."""
        if self.lost:
            self._go_to([rested(each) if each.due is None else each for each in self._branches])

    def _silent(self, branches: list[Branch]) -> Violation:
        """Build the breach that no answer came, where each of these branches owes one."""
        due = [branch.due for branch in branches if branch.due is not None]
        expected = " or ".join(dict.fromkeys(answer.words for answer in due if answer.words))
        # A sub-block that stops in the middle was answered, but not to its end.
        rule = ANSWERED if self._asked else must(due[0].rule)
        at_end = self._asked and waits_for_the_end(branches)
        asked_as = AT_THE_END if at_end else ""
        return Violation(rule, expected=expected, actual=NoAnswer(), asked_as=asked_as)

    def silence(self) -> list[Violation]:
        """Take that the client was silent for longer than a server's time-out may be."""
        findings = self.settled()
        self._go_to(
            [
                after.choosing(*branch.freedoms)
                for branch in self._branches
                for after in branch.state.pass_time(branch.memory)
            ]
        )
        return findings

    def lose(self) -> None:
        """Take that the state of the server is unknown: it was stopped, or not watched."""
        due = any(branch.due is not None for branch in self._branches)
        lost = Lost(due + self._most_waiting())
        self._forget_requests()
        self._go_to([quiet(lost, self._branches[0].memory.in_doubt(), channels.NMT_INTERRUPTED)])

    def reset(self, *, booted: bool, on_its_way: bytes | None = None) -> None:
        """Take that the node was reset, and that it has ``booted``: its server is idle then.

        A request that was ``on_its_way`` may be answered, or not.
        """
        memory = self._branches[0].memory.after_reset()
        self._forget_requests()
        rest = quiet(IDLE if booted else LOST, memory, channels.NMT_INTERRUPTED)
        self._go_to([rest, *(rest.state.receive(on_its_way, memory) if on_its_way else ())])
        self._asked = on_its_way is not None

    def _forget_requests(self) -> None:
        self._asked = self._other_asked = False
        self._sent.clear()
        self._still_due.clear()

    def observe(self, frame: CanFrame) -> list[Violation]:
        """Take any CAN frame from the bus; return what was wrong with it."""
        if self._node_id is not None and frame.can_id == RESPONSE_BASE + self._node_id:
            return self.response(frame)
        self.request(frame)
        return []

    def _is_addressed(self, frame: CanFrame) -> bool:
        return self._node_id is None or frame.can_id == REQUEST_BASE + self._node_id

    def _is_for_another(self, frame: CanFrame) -> bool:
        """Say whether a frame is a request to another node."""
        other = not self._is_addressed(frame) and frame.can_id - REQUEST_BASE in NODE_IDS
        return other and not frame.extended and not frame.remote

    def _misfit(self, misfits: list[Misfit], data: bytes) -> list[Violation]:
        if not misfits:
            if self._other_asked:
                return [violation(channels.REQUEST_IDENTIFIER, "no answer for another node", data)]
            if self._asked:
                return [violation(must(self._branches[0].rule), "no answer", data)]
            return [violation(UNSOLICITED, "nothing that was not asked for", data)]
        nearest = max(misfits, key=lambda misfit: misfit.near)
        found = nearest.violation
        if nearest.near:
            return [found]
        expected = " or ".join(dict.fromkeys(misfit.violation.expected for misfit in misfits))
        # Who refuses what is to be served has understood the request, others have not.
        other = found.rule is NOT_REFUSED and not isinstance(decode_response(data), Abort)
        return [Violation(SPECIFIER if other else found.rule, expected=expected, actual=found.seen)]

    def _recover(self, data: bytes) -> None:
        """Think where a server may be that broke the protocol."""
        doubted = [replace(each, memory=each.memory.in_doubt()) for each in self._branches]
        memory = doubted[0].memory
        owed = self._most_waiting()
        if isinstance(decode_response(data), Abort) and not owed:
            self._go_to([quiet(IDLE, memory, idle.ABORT_NOT_ANSWERED)])
            return
        lost = quiet(
            replace(lost_from(self._branches, self._sent), owed=owed),
            memory,
            idle.ABORT_NOT_ANSWERED,
        )
        if self._asked:
            self._still_due = [each for each in doubted if each.due is not None]
            self._go_to([lost])
        else:
            self._go_to([*(each for each in doubted if each.due is None), lost])
