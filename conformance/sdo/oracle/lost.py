"""A server whose state is not known, and what can be said of its answers all the same."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

from conformance.sdo.decoding import ANSWERS, decode_request, decode_response
from conformance.sdo.describe import describe
from conformance.sdo.frames import Abort, BlockAck, BlockUploadStart
from conformance.sdo.limits import LARGEST_BLOCK
from conformance.sdo.oracle.answers import DueAbort, violation
from conformance.sdo.oracle.branch import Branch, Due, Misfit, owing, quiet
from conformance.sdo.oracle.knowledge import Memory
from conformance.sdo.oracle.states import IDLE, Initiate
from conformance.sdo.rules import ANSWERED, RESTART, SPECIFIER, idle, timing


@dataclass(frozen=True, slots=True)
class Lost:
    """The state of the server is unknown: it has broken the protocol, or was not watched.

    ``owed`` answers may still come to what was sent before. They cannot be told from those to
    later requests, so nothing is certain until as many have come, or the bus has been quiet.
    ``begun`` says that an initiate was sent last: by its answer the server is found. ``given_up``
    says that there were too many ways to go on.

    One that was ``watched`` is in no block transfer: each initiate is answered then, and
    nothing comes unasked. ``asked`` is the initiate whose answer comes next.
    """

    owed: int = 0
    begun: bool = False
    given_up: bool = False
    watched: bool = False
    asked: bytes = b""
    name: ClassVar[str] = "lost"

    def receive(self, frame: bytes, memory: Memory) -> list[Branch]:
        """Find the way back with an abort of the client, or with a new transfer."""
        request = decode_request(frame)
        # Where nothing else is owed, the answer to an initiate is followed as such.
        owed = self.owed + 1 if self.owed and self.begun else self.owed
        if isinstance(request, Abort) and not request.reserved_bits:
            return [quiet(Lost(owed) if owed else IDLE, memory, idle.ABORT_NOT_ANSWERED)]
        if not isinstance(request, Initiate):
            return [quiet(Lost(owed + most_answers(frame)), memory, ANSWERED)]
        refused = DueAbort(RESTART).branch(self, IDLE, memory)
        found = [*IDLE.receive(frame, memory), refused]
        if self.watched and not owed:
            return [*found, self._answer_to(frame, memory)]
        asked = b"" if owed else frame
        return [quiet(Lost(owed, begun=True, asked=asked), memory, ANSWERED), *found]

    def _answer_to(self, frame: bytes, memory: Memory) -> Branch:
        """Build the branch of a server that has to answer an initiate, wherever it is."""

        def take(response: bytes) -> Iterable[Branch]:
            words = f"an answer to {describe(decode_request(frame))}"
            raise Misfit(partial(violation, SPECIFIER, words, response))

        return owing(replace(self, asked=frame), memory, Due(ANSWERED, "", take))

    def bears(self, response: bytes) -> bool:
        """Say whether a server that owes nothing may send a response, wherever it is."""
        if self.asked:
            return may_answer(self.asked, response) or self._is_acknowledgement(response)
        return not self.watched

    def _is_acknowledgement(self, response: bytes) -> bool:
        """Within a sub-block of a download, an initiate is a segment like any other frame."""
        return isinstance(decode_response(response), BlockAck)

    def pass_time(self, memory: Memory) -> list[Branch]:
        """Stay lost."""
        return [quiet(self, memory, timing.SERVER_TIME_OUT)]


LOST = Lost()
WATCHED = Lost(watched=True)


def most_answers(frame: bytes) -> int:
    """Return how many responses a request may bring at the most, whatever state it meets."""
    sub_block = isinstance(decode_request(frame), BlockUploadStart | BlockAck)
    return LARGEST_BLOCK if sub_block else 1


def may_answer(initiate: bytes, response: bytes) -> bool:
    """Say whether a response may be the answer to an initiate in any state but a sub-block."""
    request, answer = decode_request(initiate), decode_response(response)
    if isinstance(answer, Abort):
        return True
    return isinstance(answer, ANSWERS.get(type(request), ()))
