"""Where a server may be after what was said: the branches, and what all of them have in common."""

from enum import Enum, auto

from conformance.sdo.layout import Multiplexer
from conformance.sdo.oracle.block_download import SubBlock
from conformance.sdo.oracle.branch import Branch
from conformance.sdo.oracle.lost import Lost
from conformance.sdo.oracle.merging import merged
from conformance.sdo.oracle.profile import Profile
from conformance.sdo.oracle.requests_in_turn import MOST_BRANCHES, given_up, waiting
from conformance.sdo.oracle.states import IDLE, Running
from conformance.sdo.rules import Rule, Violation


class Awaited(Enum):
    """What the server has to send now."""

    NOTHING = auto()
    MAYBE = auto()
    ANSWER = auto()


class Standing:
    """The branches of one server, each a state that it may be in."""

    def __init__(self, branch: Branch) -> None:
        """Begin with one."""
        self.profile = Profile()
        self._branches = [branch]
        # Whether there have been too many ways to go on, so that something was not judged.
        self.given_up = False

    @property
    def awaited(self) -> Awaited:
        """Whether an answer is due."""
        owing = [branch.due is not None for branch in self._branches]
        if all(owing):
            return Awaited.ANSWER
        return Awaited.MAYBE if self.lost or any(owing) else Awaited.NOTHING

    @property
    def lost(self) -> bool:
        """Whether the server broke the protocol so that it cannot be followed for now."""
        return any(isinstance(branch.state, Lost) for branch in self._branches)

    @property
    def is_unwatched(self) -> bool:
        """Whether a transfer may be running of which nothing was seen."""
        states = (branch.state for branch in self._branches)
        return any(isinstance(state, Lost) and not state.watched for state in states)

    @property
    def in_sub_block(self) -> bool:
        """Whether segments may follow one another unanswered, and an answer cross with them."""
        return any(isinstance(branch.state, SubBlock) for branch in self._branches)

    @property
    def states(self) -> frozenset[str]:
        """The names of the states that the server may be in."""
        return frozenset(branch.state.name for branch in self._branches)

    @property
    def rules(self) -> frozenset[Rule]:
        """The rules by which the server may have come to wait for a request."""
        return frozenset(branch.rule for branch in self._branches if branch.due is None)

    @property
    def idle(self) -> bool:
        """Whether the server is idle for sure."""
        return all(branch.state is IDLE and branch.due is None for branch in self._branches)

    @property
    def is_without_transfer(self) -> bool:
        """Whether no transfer runs for sure, whatever answer may come yet."""
        return all(branch.state is IDLE for branch in self._branches)

    @property
    def running(self) -> tuple[Multiplexer, ...]:
        """The objects of the transfers that the server may have running, each once."""
        states = [branch.state for branch in self._branches]
        return tuple(dict.fromkeys(state.mux for state in states if isinstance(state, Running)))

    @property
    def values(self) -> dict[Multiplexer, frozenset[bytes] | None]:
        """What objects that were written or read may hold now; None stands for anything."""
        touched = {mux for branch in self._branches for mux in branch.memory.values}
        return {mux: self.may_hold(mux) for mux in sorted(touched)}

    def may_hold(self, mux: Multiplexer) -> frozenset[bytes] | None:
        """Return the values that an object may have now; None stands for any."""
        values = [branch.memory.now(mux) for branch in self._branches]
        known = frozenset(value for value in values if value is not None)
        return known if len(known) and None not in values else None

    def _most_waiting(self) -> int:
        """Return how many responses the requests may bring that wait for the answer before."""
        return max(waiting(branch) for branch in self._branches)

    def _keep_best(self, branches: list[Branch]) -> list[Violation]:
        """Go on with those that break the fewest rules, and return what the best of them breaks."""
        if len(branches) == 1:
            self._go_to([branches[0].unburdened()])
            return list(branches[0].findings)
        fewest = min(branch.failures for branch in branches)
        kept = [branch for branch in branches if branch.failures == fewest]
        best = min(kept, key=lambda branch: len(branch.findings))
        self._go_to([branch.unburdened() for branch in kept])
        return list(best.findings)

    def _go_to(self, branches: list[Branch]) -> None:
        """Merge what is the same, and record the choices that all have in common."""
        if len(branches) == 1 and not branches[0].freedoms:
            self._branches = branches
            self.given_up |= _is_given_up(branches[0])
            return
        alone = merged(branches) if len(branches) > 1 else branches
        if len(alone) > MOST_BRANCHES:
            alone = [given_up(alone)]
        common = frozenset.intersection(*(branch.freedoms for branch in alone))
        self.profile.add(common)
        self.given_up |= any(map(_is_given_up, alone))
        self._branches = [
            branch.having(branch.freedoms - common) if common else branch for branch in alone
        ]


def _is_given_up(branch: Branch) -> bool:
    return isinstance(branch.state, Lost) and branch.state.given_up
