"""How a server may go on with a request, and with an answer, from where it is.

A request that comes before the answer to the one before waits. It may be served in order, dropped,
or refused at once; which of them is asked when that answer has come: asked before, each
request that waits would multiply the ways to go on.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from conformance.sdo.decoding import decode_request, decode_response
from conformance.sdo.frames import Abort, BlockAck
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.limits import LARGEST_BLOCK
from conformance.sdo.oracle.answers import DueAbort, refusing
from conformance.sdo.oracle.block_download import SubBlock
from conformance.sdo.oracle.block_upload import Sending
from conformance.sdo.oracle.branch import Branch, Due, Freedom, State, quiet
from conformance.sdo.oracle.knowledge import Memory
from conformance.sdo.oracle.lost import Lost, most_answers
from conformance.sdo.oracle.merging import merged
from conformance.sdo.oracle.states import IDLE
from conformance.sdo.rules import freedoms, idle

ABORT_COMMAND = 0x80
# With more ways to go on at once than this, nothing can be said any more.
MOST_BRANCHES = 1000
# So few it takes longer to merge than to follow.
FEW = 4
MOST_REMEMBERED = 512
SECOND = "a second request before the answer"
TOO_EARLY = DueAbort(freedoms.BEHIND_ANOTHER)
DROPPED, REFUSED = Freedom(SECOND, "dropped"), Freedom(SECOND, "refused")


class Hearing:
    """Takes requests and answers for a branch.

    Most requests meet an idle server, and are the same again and again: what it may do with them is
    remembered until something is learned of its objects. ``effort`` counts the ways to go on that
    were looked at.
    """

    def __init__(self) -> None:
        """Remember nothing."""
        self.effort = 0
        self._memory: Memory | None = None
        self._when_idle: dict[bytes, list[Branch]] = {}

    def hear(self, branch: Branch, frame: bytes) -> Iterator[Branch]:
        """Yield how a branch may go on with a request."""
        self.effort += 1
        if branch.due is None:
            for after in self._received(branch.state, frame, branch.memory):
                yield after.choosing(*branch.freedoms).noting(*branch.findings)
            return
        yield branch.waiting(frame)
        if _is_abort(frame):
            yield replace(branch, state=IDLE, due=None, backlog=(), rule=idle.ABORT_NOT_ANSWERED)

    def _received(self, state: State, frame: bytes, memory: Memory) -> list[Branch]:
        if state is not IDLE:
            return state.receive(frame, memory)
        if memory is not self._memory or len(self._when_idle) >= MOST_REMEMBERED:
            self._memory = memory
            self._when_idle.clear()
        if frame not in self._when_idle:
            self._when_idle[frame] = state.receive(frame, memory)
        return self._when_idle[frame]

    def take(self, branch: Branch, due: Due, frame: bytes) -> list[Branch]:
        """Return how a branch may go on with the answer due; raises Misfit where it cannot."""
        branches = [
            after.choosing(*branch.freedoms).noting(*branch.findings) for after in due.take(frame)
        ]
        self.effort += 1
        in_order = isinstance(branch.state, SubBlock)
        for request in branch.backlog:
            if len(branches) > FEW:
                branches = merged(branches)
            if len(branches) > MOST_BRANCHES:
                return [given_up([branch])]
            branches = [
                later
                for after in branches
                for later in self._catch_up(after, request, in_order=in_order)
            ]
        return branches

    def _catch_up(self, branch: Branch, request: bytes, *, in_order: bool) -> Iterator[Branch]:
        """Yield how a branch may go on with a request that has waited for the answer before.

        In a sub-block segments are taken in order; any other request may have been dropped.
        """
        yield from self.hear(branch, request)
        if branch.due is None and not (in_order and isinstance(branch.state, SubBlock)):
            yield branch.choosing(DROPPED)


def answers_due(branches: Iterable[Branch], frame: bytes) -> Iterator[tuple[Branch, Due]]:
    """Yield the answers that a response may be, each with the branch in which it is due.

    An abort may be the refusal of a request that waits, too. A segment that the server has lost in
    a sub-block it may report at any time.
    """
    aborts = isinstance(decode_response(frame), Abort)
    for branch in branches:
        if branch.due is None:
            if isinstance(branch.state, SubBlock):
                lossy = branch.state.lossy(frame, branch.memory)
                if lossy is not None:
                    yield branch, lossy
            continue
        yield branch, branch.due
        if aborts and branch.backlog and not isinstance(branch.state, SubBlock):
            yield from _refusals(branch)


def _refusals(branch: Branch) -> Iterator[tuple[Branch, Due]]:
    """Yield the refusal of each request that waits; what is behind it waits on."""
    due = refusing((TOO_EARLY,), IDLE, IDLE, branch.memory)
    refused = replace(branch, state=IDLE, due=due, rule=due.rule).choosing(REFUSED)
    for place, request in enumerate(branch.backlog, start=1):
        if not _is_abort(request):
            yield replace(refused, backlog=branch.backlog[place:]), due


def acknowledged_early(branch: Branch) -> bool:
    """Say whether an acknowledgement has come while the server sends a sub-block.

    That may have any effect: the server may start over, or count on from there.
    """
    waits = any(isinstance(decode_request(frame), BlockAck) for frame in branch.backlog)
    return isinstance(branch.state, Sending) and waits


def _is_abort(frame: bytes) -> bool:
    return len(frame) == FRAME_LENGTH and frame[0] == ABORT_COMMAND


def waiting(branch: Branch) -> int:
    """Return how many responses the requests may bring that wait in a branch."""
    return sum(most_answers(request) for request in branch.backlog)


def given_up(branches: Sequence[Branch]) -> Branch:
    """Follow no longer: there are too many ways to go on."""
    # What is due may be a segment of a sub-block, with all others behind it.
    owed = LARGEST_BLOCK + max(map(waiting, branches))
    lost = Lost(owed, given_up=True)
    return quiet(lost, branches[0].memory.in_doubt(), branches[0].rule)
