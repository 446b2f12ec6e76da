"""Which nodes are in Stopped, by the commands in a log and by their own heartbeats."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from conformance.logs.findings import Finding
from conformance.logs.reading import Seen
from conformance.sdo.decoding import decode_response
from conformance.sdo.nmt import NmtState
from conformance.sdo.rules import Violation
from conformance.sdo.rules.channels import NMT_STOPPED
from conformance.sdo.seen import Received

NODE_IDS = range(1, 128)
# A device needs so many seconds at the most to be where a command leads; until then its heartbeat
# may say what was before.
TRANSITION = 0.1


@dataclass(slots=True)
class Stopped:
    """A node that was told to stop, or says that it is stopped, from when on.

    ``certain``: it is not the one that may have sent the command itself. ``owing`` says that an
    answer may have been on its way then, or that a transfer ended with an abort; ``asked`` that
    there was a request since.
    """

    since: float
    owing: bool
    certain: bool
    asked: bool = False


@dataclass(slots=True)
class StoppedNodes:
    """The nodes of one bus."""

    _stopped: dict[int, Stopped] = field(default_factory=dict)
    _commanded: dict[int, float] = field(default_factory=dict)

    def stop(self, node_id: int, now: float, *, owing: bool, certain: bool) -> None:
        """Take a command to stop."""
        self._commanded.pop(node_id, None)
        known = self._stopped.setdefault(node_id, Stopped(now + TRANSITION, owing, certain))
        known.certain |= certain

    def go_on(self, node_id: int, now: float) -> bool:
        """Take a command by which a node leaves Stopped; say whether it was there."""
        self._commanded[node_id] = now
        return self._stopped.pop(node_id, None) is not None

    def says(self, node_id: int, state: int, now: float, *, owing: bool) -> bool:
        """Take a heartbeat; say whether by it a node enters Stopped, or leaves it."""
        if state != NmtState.STOPPED:
            return self._stopped.pop(node_id, None) is not None
        if now - self._commanded.get(node_id, -TRANSITION) < TRANSITION:
            return False  # it was on its way when the node was told to go on
        stopped = self._stopped.get(node_id)
        if stopped is None:
            self._stopped[node_id] = Stopped(now, owing, certain=True)
        else:
            stopped.certain, stopped.since = True, min(stopped.since, now)
        return stopped is None

    def asks(self, node_id: int, now: float) -> bool:
        """Take a request; say whether the node is in Stopped."""
        stopped = self._stopped.get(node_id)
        if stopped is None:
            return False
        stopped.asked |= stopped.certain and now >= stopped.since
        return True

    def is_left(self, node_id: int, now: float) -> bool:
        """Take that a node answers; say whether it shows by this that it was never stopped."""
        stopped = self._stopped.get(node_id)
        if stopped is None or stopped.certain or now < stopped.since:
            return False
        del self._stopped[node_id]
        return True

    def __contains__(self, node_id: int) -> bool:
        """Say whether a node is in Stopped, as far as is known."""
        return node_id in self._stopped

    def judged(self, node_id: int, seen: Seen) -> Iterator[Finding]:
        """Yield that a node answers in Stopped, unless it ended what was running before."""
        stopped = self._stopped[node_id]
        owing, stopped.owing = stopped.owing, False
        if stopped.asked and not owing:
            answer = Received(decode_response(seen.frame.data))
            broken = Violation(NMT_STOPPED, expected="no answer in Stopped", actual=answer)
            yield Finding(node_id, seen, broken)
