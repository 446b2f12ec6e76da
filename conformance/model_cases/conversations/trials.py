"""One conversation after another on one device, each from an idle server."""

from collections.abc import Sequence
from dataclasses import dataclass

from conformance.bus.errors import BenchError
from conformance.bus.link import Captured
from conformance.device.effort import TRIES_OF_TRANSFER
from conformance.dialogue.changing import changes_by_itself
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.server_aborts import Way, is_systematic
from conformance.model_cases.conversations.conversation import Conversation
from conformance.model_cases.conversations.converse import converse
from conformance.model_cases.conversations.device_objects import DeviceObjects
from conformance.run.leaving import leave, shift
from conformance.run.session import DeviceSession
from conformance.run.verdict import Afterwards
from conformance.sdo.checks import ServerAborted
from conformance.sdo.kinds import OTHER_DATA
from conformance.sdo.rules import Cause, Rule, Violation


@dataclass(frozen=True, slots=True)
class Failure:
    """A conversation that failed, what was wrong, and its frames up to there.

    Of one that ``is_known`` other cases have told the cause.
    """

    conversation: Conversation
    violation: Violation
    frames: Sequence[Captured]
    is_known: bool

    @property
    def rule(self) -> Rule:
        """The rule that was broken."""
        return self.violation.rule


class Trials:
    """Tries conversations. Of what is exchanged, the session keeps the last one only.

    When the device or the bench is lost, ``ended`` says so, and nothing is sent any more;
    ``bench_error`` is what is wrong with the bench.
    """

    def __init__(self, session: DeviceSession, sdo: Dialogue, objects: DeviceObjects) -> None:
        """Take an idle device that was surveyed."""
        self.ended = False
        self.bench_error: BenchError | None = None
        self._session = session
        self._sdo = sdo
        self._objects = objects
        self._left: Way | None = None

    @property
    def answers(self) -> int:
        """How many answers they have waited for."""
        return self._sdo.wire.timing.answers

    def attempt(self, conversation: Conversation, like: Rule | None = None) -> Failure | None:
        """Perform a conversation; return how it failed, if it did.

        ``like`` is the rule that it has to break; None stands for any. One in which the server
        has ended a transfer early is performed again: it may, but not in the same way each time.
        """
        ways: list[Way] = []
        while (failure := self._perform(conversation)) is not None and self._left is not None:
            ways.append(self._left)
            if len(ways) == TRIES_OF_TRANSFER:
                break
            shift(self._sdo, len(ways) ** 2)
        by_chance = len(ways) == TRIES_OF_TRANSFER and not is_systematic(ways)
        if failure is None or by_chance:
            return None
        return failure if like in (None, failure.rule) else None

    def _perform(self, conversation: Conversation) -> Failure | None:
        self._left = None
        if self.ended:
            return None
        try:
            self._objects.restore(self._sdo)
            self._session.show(())
            self._sdo.record.early.forget()
            converse(conversation, self._objects, self._sdo)
        except Violation as violation:
            violation.asked = violation.asked or self._sdo.wire.last_sent
            record, asked = self._sdo.record, self._sdo.wire.last_sent
            is_known = record.explains() is not None or record.is_known(violation, asked)
            failure = Failure(conversation, violation, self._session.frames, is_known)
            excused = self._sdo.wire.pauses.excuse
            if not is_known:
                self._left = record.early.way(violation, asked)
            self._recover()
            reads_wrong = violation.told_as == Cause(violation.rule.id, *OTHER_DATA)
            moved = reads_wrong and self._moves(conversation)
            return None if excused or moved else failure
        except BenchError as error:
            self.bench_error, self.ended = error, True
        finally:
            self._sdo.wire.pauses.forget()
            self._sdo.record.early.forget()
            self._keep_one_of_each()
        return None

    def _recover(self) -> None:
        try:
            self.ended = leave(self._sdo, failed=True).afterwards is Afterwards.LOST
        except BenchError as error:
            self.bench_error, self.ended = error, True

    def _moves(self, conversation: Conversation) -> bool:
        """Say whether the device changes an object of a conversation by itself."""
        targets = dict.fromkeys(transfer.target for transfer in conversation)
        try:
            return not self.ended and any(changes_by_itself(self._sdo, mux) for mux in targets)
        except (Violation, ServerAborted):
            return False  # the failure says enough
        except BenchError as error:
            self.bench_error, self.ended = error, True
            return False

    def _keep_one_of_each(self) -> None:
        """Keep one breach of each rule that does not fail a device: there are many examples."""
        one_each = {found.rule: found for found in reversed(self._sdo.record.minor)}
        self._sdo.record.minor[:] = one_each.values()
